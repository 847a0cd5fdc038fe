// The arm of one register's worth of shots at given deflections: frames and twists, in the axes of the station with the
// arm's base as origin. Compiled once per instruction set.
#if defined(SAGITTA_MODELS_BATCH_LANE_CHAIN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SAGITTA_MODELS_BATCH_LANE_CHAIN_INL_H_
#undef SAGITTA_MODELS_BATCH_LANE_CHAIN_INL_H_
#else
#define SAGITTA_MODELS_BATCH_LANE_CHAIN_INL_H_
#endif

#include "models/batch/batch_rows.h"
#include "models/batch/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {

// Handed out piece by piece.
class LaneMemory {
 public:
  explicit LaneMemory(double* memory) : memory_(reinterpret_cast<char*>(memory)) {}
  template <typename T>
  T* Take(std::size_t count) {
    T* here = reinterpret_cast<T*>(memory_);
    memory_ += count * sizeof(T);
    return here;
  }

 private:
  char* memory_;
};

class LaneChain {
 public:
  LaneChain(const ShotProgram& program, const BatchPoint& at, LaneMemory* memory)
      : p_(program), at_(at), base_(Same(at.base_in_station.rotation)) {
    twists_ = memory->Take<TwistLanes>(p_.twists.size());
    frames_ = memory->Take<Frame>(p_.num_kept_frames);
  }
  static std::size_t MemoryFor(const ShotProgram& p) {
    return p.twists.size() * sizeof(TwistLanes) + p.num_kept_frames * sizeof(Frame);
  }

  // deflection: of each slot. Twists of rotations are left as axis and origin.
  void Evaluate(const double* data, const V* deflection) {
    Frame here = {base_, Zero3()};
    if (p_.world_frame >= 0) frames_[p_.world_frame] = here;
    for (size_t e = 0; e < p_.transforms.size(); ++e) {
      switch (p_.transforms[e].axis) {
        case 0:
          Pass<0>(e, data, deflection, &here);
          break;
        case 1:
          Pass<1>(e, data, deflection, &here);
          break;
        default:
          Pass<2>(e, data, deflection, &here);
      }
    }
  }
  void CompleteTwists() {
    for (size_t k = 0; k < p_.twists.size(); ++k) {
      if (p_.twists[k].is_rotation) twists_[k].v = Cross(twists_[k].v, twists_[k].w);
    }
  }
  // The joint of the spring alone.
  void TurnSpring(const double* data, const V* deflection) {
    if (p_.has_spring) Turn(p_.spring.transform, data, deflection, &spring_sine_, &spring_cosine_);
  }

  const M3& base() const { return base_; }
  const Frame& KeptFrame(int kept) const { return frames_[kept]; }
  const TwistLanes& Twist(int twist) const { return twists_[twist]; }
  V spring_sine() const { return spring_sine_; }
  V spring_cosine() const { return spring_cosine_; }

 private:
  static V Datum(const double* data, int index) { return At(data + index * kBatchLanes); }

  // What is added to the lane's own value.
  HWY_INLINE V ValueOf(size_t e, const double* data, const V* deflection) const {
    const ShotProgram::Transform& transform = p_.transforms[e];
    V value = Of(at_.fixed[2 * e]);
    for (const ShotProgram::Scaled& term : transform.terms) {
      value = Fma(Of(at_.theta[term.parameter]), Datum(data, term.data), value);
    }
    return transform.slot >= 0 ? hn::Add(value, deflection[transform.slot]) : value;
  }
  HWY_INLINE void Turn(size_t e, const double* data, const V* deflection, V* sine, V* cosine) const {
    const int own = p_.transforms[e].lane_value;
    SinCos(ValueOf(e, data, deflection), sine, cosine);
    if (own < 0) return;
    const V own_sine = Datum(data, own), own_cosine = Datum(data, own + 1);
    const V s = Fma(own_sine, *cosine, hn::Mul(own_cosine, *sine));  // of the sum
    *cosine = Fnma(own_sine, *sine, hn::Mul(own_cosine, *cosine));
    *sine = s;
  }

  // From the frame before a transform to the one after it. By the axis, so that the frame stays in registers.
  template <int kAxis>
  HWY_INLINE void Pass(size_t e, const double* data, const V* deflection, Frame* here) {
    const ShotProgram::Transform& transform = p_.transforms[e];
    const V3& axis = here->rotation.column[kAxis];
    if (transform.twist >= 0) {
      twists_[transform.twist] = transform.is_rotation ? TwistLanes{axis, here->origin} : TwistLanes{Zero3(), axis};
    }
    if (!(transform.is_fixed() && at_.fixed[2 * e] == 0.0)) Apply<kAxis>(e, data, deflection, here);
    if (transform.kept_frame >= 0) frames_[transform.kept_frame] = *here;
  }
  template <int kAxis>
  HWY_INLINE void Apply(size_t e, const double* data, const V* deflection, Frame* here) {
    const ShotProgram::Transform& transform = p_.transforms[e];
    if (!transform.is_rotation) {
      V value = ValueOf(e, data, deflection);
      if (transform.lane_value >= 0) value = hn::Add(value, Datum(data, transform.lane_value));
      here->origin = Fma(value, here->rotation.column[kAxis], here->origin);
      return;
    }
    V sine = Of(at_.fixed[2 * e]), cosine = Of(at_.fixed[2 * e + 1]);
    if (!transform.is_fixed()) Turn(e, data, deflection, &sine, &cosine);
    if (p_.has_spring && p_.spring.transform == static_cast<int>(e)) spring_sine_ = sine, spring_cosine_ = cosine;
    V3& u = here->rotation.column[(kAxis + 1) % 3];
    V3& v = here->rotation.column[(kAxis + 2) % 3];
    const V3 turned = Fma(cosine, u, Times(sine, v));
    v = Fnma(sine, u, Times(cosine, v));
    u = turned;
  }

  const ShotProgram& p_;
  const BatchPoint& at_;
  const M3 base_;  // of the base in the station's axes
  TwistLanes* twists_;
  Frame* frames_;  // kept ones
  V spring_sine_, spring_cosine_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#endif
