// The loaded arm of one register's worth of shots: chain, torques, equilibrium and what moves it. Compiled once per
// instruction set. The equations are those of models/elastostatics.h and models/wrench.h; wrenches are summed by the
// frames that bear them before any transform is looked at:
//
//   F = sum F_w,  M0 = sum x_w x F_w + M_w,  Q = sum F_w x_w'        over frames beyond the transform
//   tau_b = xi_b . (M0, F)
//   d tau_b / d v_a = S . w_a + H . v_a,  a >= b   S = Q z - tr(Q) z,  H = F x z        (z = z_b, a rotation)
//                   = before . w_a,       a < b    before = z x (M0 - o x F) + S - ((z . o) F - (o . F) z)
#if defined(SAGITTA_MODELS_BATCH_LANE_STATICS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SAGITTA_MODELS_BATCH_LANE_STATICS_INL_H_
#undef SAGITTA_MODELS_BATCH_LANE_STATICS_INL_H_
#else
#define SAGITTA_MODELS_BATCH_LANE_STATICS_INL_H_
#endif

#include <algorithm>

#include "models/batch/batch_rows.h"
#include "models/batch/lane_spring-inl.h"
#include "models/batch/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {

constexpr double kSettled = 1e-10;    // rad or m: what is left is added to first order; derivatives keep as much
constexpr double kFoldedLanes = 0.5;  // rad or m: the reference looks closer
constexpr int kMostNewtonSteps = 8;

class LaneStatics {
 public:
  LaneStatics(const ShotProgram& program, const BatchPoint& at, BatchScratch* scratch)
      : p_(program), at_(at), base_(Same(at.base_in_station.rotation)) {
    memory_ = reinterpret_cast<char*>(scratch->Reserve(0));
    const std::size_t slots = p_.slots.size(), levels = static_cast<std::size_t>(p_.num_levels);
    twists_ = Rest<TwistLanes>(p_.twists.size());
    origins_ = Rest<V3>(slots);
    frames_ = Rest<Frame>(p_.num_kept_frames);
    measured_ = Rest<Sums>(levels + 1);
    in_base_ = Rest<Sums>(levels + 1);
    own_ = Rest<Sums>(levels + 1);
    beyond_ = Rest<TwistLanes>(slots * (levels + 1));
    before_ = Rest<V3>(slots);
    torque_ = Rest<V>(slots);
    flexibility_ = Rest<V>(slots);
    deflection_ = Rest<V>(slots);
    step_ = Rest<V>(slots);
    law_ = Rest<V>(slots);
    matrix_ = Rest<V>(slots * slots);
    response_ = Rest<V>(slots * slots);
    imposed_ = Rest<TwistLanes>(slots);
    by_rotation_ = Rest<V>(3 * slots);
  }

  static std::size_t MemoryFor(const ShotProgram& p) {
    const std::size_t slots = p.slots.size(), levels = static_cast<std::size_t>(p.num_levels) + 1;
    return sizeof(V) * (p.twists.size() * 6 + slots * (3 + 6 * levels + 3 + 5 + 2 * slots + 6 + 3) +
                        p.num_kept_frames * 12 + 3 * levels * sizeof(Sums) / sizeof(V));
  }
  template <typename T>
  T* Rest(std::size_t count) {
    T* here = reinterpret_cast<T*>(memory_ + used_);
    used_ += count * sizeof(T);
    return here;
  }

  // Finds the equilibrium; a bit for each lane that does not get there.
  unsigned Settle(const double* data, int lane) {
    data_ = data + lane;
    lane_ = lane;
    const int n = static_cast<int>(p_.slots.size());
    for (int s = 0; s < n; ++s) deflection_[s] = step_[s] = Of(0.0);
    auto settled = hn::Lt(Of(0.0), Of(1.0));
    for (int i = 0; i < kMostNewtonSteps; ++i) {
      EvaluateChain();
      if (n == 0) return 0;
      EvaluateLaw();
      InvertResponse();
      V largest = Of(0.0), bent = Of(0.0);
      for (int s = 0; s < n; ++s) {
        V step = Of(0.0);
        for (int k = 0; k < n; ++k) step = Fma(response_[s * n + k], hn::Sub(law_[k], deflection_[k]), step);
        step_[s] = step;
        largest = hn::Add(largest, hn::Abs(step));
        bent = hn::Add(bent, hn::Abs(hn::Add(deflection_[s], step)));
      }
      settled = hn::And(hn::Lt(largest, Of(kSettled)), hn::Lt(bent, Of(kFoldedLanes)));
      if (hn::AllTrue(Tag(), settled)) return 0;
      if (i + 1 == kMostNewtonSteps) break;
      for (int s = 0; s < n; ++s) deflection_[s] = hn::Add(deflection_[s], step_[s]);
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(Tag(), hn::Not(settled), bits);
    return bits[0];
  }

  const Frame& KeptFrame(int kept) const { return frames_[kept]; }
  V Datum(int index) const { return At(data_ + index * kBatchLanes); }
  V Phi(ElasticLaw law, int slot) const {
    const V torque = torque_[slot];
    if (law == ElasticLaw::kLinear) return torque;
    if (law == ElasticLaw::kCubic) return hn::Mul(torque, hn::Mul(torque, torque));
    const V zero = Of(0.0);
    return hn::Sub(hn::IfThenElseZero(hn::Lt(zero, torque), Of(1.0)),
                   hn::IfThenElseZero(hn::Lt(torque, zero), Of(1.0)));
  }

  // From here on columns are twists of `frame`: H = Xi A over the slots before it.
  void RespondOn(int frame) {
    frame_ = frame;
    const int n = static_cast<int>(p_.slots.size());
    for (int s = 0; s < n; ++s) {
      imposed_[s] = ZeroTwist();
      for (int k = 0; k < n; ++k) {
        if (p_.slots[k].transform >= frame) continue;
        imposed_[s] = Fma(response_[k * n + s], twists_[p_.slots[k].twist], imposed_[s]);
      }
    }
  }
  // By a deflection imposed on a slot.
  const TwistLanes& Imposed(int slot) const { return imposed_[slot]; }

  // By the value of a transform.
  TwistLanes Total(int twist, int frame) const {
    const TwistLanes& own = twists_[twist];
    TwistLanes total = p_.twists[twist].transform < frame ? own : ZeroTwist();
    for (size_t s = 0; s < p_.slots.size(); ++s) {
      total = Fma(LawBy(static_cast<int>(s), twist), imposed_[s], total);
    }
    return total;
  }

  // Adds what one unit of these wrenches does.
  void AddTorques(const ShotProgram::Loads& loads, TwistLanes* column) const {
    for (size_t s = 0; s < p_.slots.size(); ++s) {
      const V bend = hn::Mul(flexibility_[s], TorqueOf(loads, static_cast<int>(s)));
      *column = Fma(bend, imposed_[s], *column);
    }
  }
  V TorqueOf(const ShotProgram::Loads& loads, int slot) const {
    V torque = Of(0.0);
    for (const ShotProgram::Wrench& wrench : loads.wrenches) {
      if (wrench.level < p_.slots[slot].level) continue;
      const Applied applied = Apply(wrench);
      torque = hn::Add(torque, Work(twists_[p_.slots[slot].twist], Cross(applied.point, applied.force) + applied.moment,
                                    applied.force));
    }
    return torque;
  }
  // How far a torque on each slot moves the slots (the largest), by what wrenches or a parameter of the spring do.
  V LargestDeflection(const ShotProgram::Loads& loads) const {
    return LargestOf([&](int s) HWY_ATTR { return TorqueOf(loads, s); });
  }
  V LargestDeflectionBySpring(int parameter) const {
    return LargestOf([&](int s) HWY_ATTR { return s == p_.spring.slot ? by_spring_[parameter] : Of(0.0); });
  }
  V TorqueOn(int slot) const { return torque_[slot]; }
  V LargestForce() const {
    V squared = Of(0.0);
    for (const ShotProgram::Wrench& wrench : p_.loads[0].wrenches) {
      const V3 force = At3(data_, wrench.data + 3, 0);
      squared = hn::Max(squared, Dot(force, force));
    }
    return hn::Sqrt(squared);
  }
  void AddSpring(int parameter, TwistLanes* column) const {
    const int s = p_.spring.slot;
    *column = Fma(hn::Mul(flexibility_[s], by_spring_[parameter]), imposed_[s], *column);
  }

  // By a left perturbation of the base rotation about a station's axis: the arm turns, wrenches that are given in the
  // measurement frame stay.
  TwistLanes ByRotation(int axis) const {
    const V3 turn = StationAxis(axis);
    TwistLanes total = {turn, Zero3()};
    for (size_t s = 0; s < p_.slots.size(); ++s) {
      total = Fma(by_rotation_[3 * s + axis], imposed_[s], total);
    }
    return total;
  }

  // What the last Newton step would still move.
  TwistLanes LeftOver(int frame) const {
    TwistLanes total = ZeroTwist();
    for (size_t s = 0; s < p_.slots.size(); ++s) {
      if (p_.slots[s].transform < frame) total = Fma(step_[s], twists_[p_.slots[s].twist], total);
    }
    return total;
  }

  // Derivatives of the law by the base rotation; after Settle, where they are asked for.
  void TurnBase() {
    for (int s = 0; s < static_cast<int>(p_.slots.size()) * 3; ++s) by_rotation_[s] = Of(0.0);
    AddTurn(measured_, -1, Of(1.0));
    for (const ShotProgram::Loads& sag : p_.sags) {
      if (at_.theta[sag.parameter] == 0.0) continue;
      Clear(own_);
      Sum(sag, Of(1.0), own_, nullptr);
      Accumulate(own_);
      AddTurn(own_, sag.slot, Of(at_.theta[sag.parameter]));
    }
  }

 private:
  struct Applied {
    V3 point, force, moment;
  };
  // Of all wrenches beyond a frame.
  struct Sums {
    V3 force, about_base, pure;
    M3 q;  // sum of F x'
  };

  template <typename Torque>
  V LargestOf(const Torque& torque_on) const {
    const int n = static_cast<int>(p_.slots.size());
    V largest = Of(0.0);
    for (int k = 0; k < n; ++k) {
      V moved = Of(0.0);
      for (int s = 0; s < n; ++s) moved = Fma(hn::Mul(response_[k * n + s], flexibility_[s]), torque_on(s), moved);
      largest = hn::Max(largest, hn::Abs(moved));
    }
    return largest;
  }

  V3 StationAxis(int axis) const {  // in the base frame: a row of the base rotation
    const auto row = at_.base_in_station.rotation.row(axis);
    return {Of(row[0]), Of(row[1]), Of(row[2])};
  }

  void EvaluateChain() {
    Frame here = {Same(Eigen::Matrix3d::Identity()), Zero3()};
    if (p_.world_frame >= 0) frames_[p_.world_frame] = here;
    for (size_t e = 0; e < p_.transforms.size(); ++e) {
      const ShotProgram::Transform& transform = p_.transforms[e];
      const V3 axis = here.rotation.column[transform.axis];
      if (transform.twist >= 0) {
        twists_[transform.twist] =
            transform.is_rotation ? TwistLanes{axis, Cross(here.origin, axis)} : TwistLanes{Zero3(), axis};
      }
      if (transform.slot >= 0) origins_[transform.slot] = here.origin;
      if (!(transform.is_fixed() && at_.fixed[2 * e] == 0.0)) Apply(static_cast<int>(e), transform, axis, &here);
      if (transform.kept_frame >= 0) frames_[transform.kept_frame] = here;
    }
  }

  HWY_INLINE void Apply(int e, const ShotProgram::Transform& transform, V3 axis, Frame* here) {
    V value = Of(at_.fixed[2 * e]), sine = value, cosine = Of(at_.fixed[2 * e + 1]);
    if (!transform.is_fixed()) {
      for (const ShotProgram::Scaled& term : transform.terms) {
        value = Fma(Of(at_.theta[term.parameter]), Datum(term.data), value);
      }
      if (transform.slot >= 0) value = hn::Add(value, deflection_[transform.slot]);
      if (transform.is_rotation) {
        SinCos(value, &sine, &cosine);
        if (transform.lane_value >= 0)
          Compose(Datum(transform.lane_value), Datum(transform.lane_value + 1), &sine, &cosine);
      } else if (transform.lane_value >= 0) {
        value = hn::Add(value, Datum(transform.lane_value));
      }
    }
    if (!transform.is_rotation) {
      here->origin = Fma(value, axis, here->origin);
      return;
    }
    if (p_.has_spring && p_.spring.transform == e) spring_sine_ = sine, spring_cosine_ = cosine;
    V3* const u = &here->rotation.column[(transform.axis + 1) % 3];
    V3* const v = &here->rotation.column[(transform.axis + 2) % 3];
    const V3 turned = Fma(cosine, *u, Times(sine, *v));
    *v = Fnma(sine, *u, Times(cosine, *v));
    *u = turned;
  }
  // sin and cos of a sum.
  static HWY_INLINE void Compose(V sine, V cosine, V* own_sine, V* own_cosine) {
    const V s = Fma(sine, *own_cosine, hn::Mul(cosine, *own_sine));
    *own_cosine = Fnma(sine, *own_sine, hn::Mul(cosine, *own_cosine));
    *own_sine = s;
  }

  HWY_INLINE Applied Apply(const ShotProgram::Wrench& wrench) const {
    Applied applied = {frames_[wrench.kept_frame] * At3(data_, wrench.data, 0), At3(data_, wrench.data + 3, 0),
                       At3(data_, wrench.data + 6, 0)};
    if (wrench.in_base) return applied;
    applied.force = TransposeTimes(base_, applied.force);
    applied.moment = TransposeTimes(base_, applied.moment);
    return applied;
  }

  void Clear(Sums* sums) const {
    for (int k = 0; k <= p_.num_levels; ++k) sums[k] = {Zero3(), Zero3(), Zero3(), Zero33()};
  }
  // By the frame that bears them; those given in the base frame apart (null: left out).
  void Sum(const ShotProgram::Loads& loads, V times, Sums* measured, Sums* in_base) const {
    for (const ShotProgram::Wrench& wrench : loads.wrenches) {
      Sums* const sums = wrench.in_base ? in_base : measured;
      if (sums != nullptr) Add(Apply(wrench), times, &sums[wrench.level]);
    }
  }
  static HWY_INLINE void Add(const Applied& applied, V times, Sums* sums) {
    const V3 force = Times(times, applied.force);
    sums->force = sums->force + force;
    sums->pure = Fma(times, applied.moment, sums->pure);
    sums->about_base = sums->about_base + Fma(times, applied.moment, Cross(applied.point, force));
    sums->q.column[0] = Fma(applied.point.x, force, sums->q.column[0]);
    sums->q.column[1] = Fma(applied.point.y, force, sums->q.column[1]);
    sums->q.column[2] = Fma(applied.point.z, force, sums->q.column[2]);
  }
  // From the flange to the base.
  void Accumulate(Sums* sums) const {
    for (int k = p_.num_levels - 1; k >= 0; --k) Add(sums[k + 1], &sums[k]);
  }
  static void Add(const Sums& other, Sums* sums) {
    sums->force = sums->force + other.force;
    sums->about_base = sums->about_base + other.about_base;
    sums->pure = sums->pure + other.pure;
    for (int c = 0; c < 3; ++c) sums->q.column[c] = sums->q.column[c] + other.q.column[c];
  }

  // f and F at the current deflections.
  void EvaluateLaw() {
    const int n = static_cast<int>(p_.slots.size()), levels = p_.num_levels;
    Clear(measured_);
    Clear(in_base_);
    for (const ShotProgram::Loads& loads : p_.loads) {
      if (loads.parameter >= 0 && at_.theta[loads.parameter] == 0.0) continue;
      Sum(loads, loads.parameter < 0 ? Of(1.0) : Of(at_.theta[loads.parameter]), measured_, in_base_);
    }
    Accumulate(measured_);
    if (p_.has_base_loads) Accumulate(in_base_);
    for (int s = 0; s < n; ++s) {
      law_[s] = flexibility_[s] = Of(0.0);
      torque_[s] = TorqueBy(measured_, s);
      if (p_.has_base_loads) torque_[s] = hn::Add(torque_[s], TorqueBy(in_base_, s));
    }
    if (p_.has_spring) EvaluateSpring();
    for (const ShotProgram::Elastic& term : p_.elastic) {
      if (term.slot < 0) continue;
      const V gain = hn::Mul(Of(at_.theta[term.parameter]), Datum(term.data));
      law_[term.slot] = Fma(gain, Phi(term.law, term.slot), law_[term.slot]);
      flexibility_[term.slot] = Fma(gain, PhiDerivative(term.law, term.slot), flexibility_[term.slot]);
    }
    for (int s = 0; s < n; ++s) {
      before_[s] = Zero3();
      for (int k = 0; k <= levels; ++k) beyond_[s * (levels + 1) + k] = ZeroTwist();
      AddAnswer(measured_, s, flexibility_[s]);
      if (p_.has_base_loads) AddAnswer(in_base_, s, flexibility_[s]);
    }
    AddSags();
  }
  V PhiDerivative(ElasticLaw law, int slot) const {
    if (law == ElasticLaw::kLinear) return Of(1.0);
    return law == ElasticLaw::kCubic ? hn::Mul(Of(3.0), hn::Mul(torque_[slot], torque_[slot])) : Of(0.0);
  }
  V TorqueBy(const Sums* sums, int s) const {
    const Sums& acting = sums[p_.slots[s].level];
    return Work(twists_[p_.slots[s].twist], acting.about_base, acting.force);
  }

  // The derivative of the torque on slot s by every transform, times `factor`.
  void AddAnswer(const Sums* sums, int s, V factor) {
    const ShotProgram::Slot& slot = p_.slots[s];
    const Sums& acting = sums[slot.level];
    if (!p_.transforms[slot.transform].is_rotation) {
      before_[s] = Fnma(factor, Cross(acting.force, twists_[slot.twist].v), before_[s]);
      return;
    }
    const V3 z = twists_[slot.twist].w, o = origins_[s];
    for (int k = slot.level; k < p_.num_levels; ++k) {
      TwistLanes& beyond = beyond_[s * (p_.num_levels + 1) + k];
      beyond.w = Fma(factor, Turned(sums[k], z), beyond.w);
      beyond.v = Fma(factor, Cross(sums[k].force, z), beyond.v);
    }
    const V3 about = acting.about_base - Cross(o, acting.force);
    const V3 shift = Fnma(Dot(o, acting.force), z, Times(Dot(z, o), acting.force));
    before_[s] = Fma(factor, Cross(z, about) + Turned(acting, z) - shift, before_[s]);
  }
  // Q z - tr(Q) z
  static HWY_INLINE V3 Turned(const Sums& sums, V3 z) { return Fnma(Trace(sums.q), z, sums.q * z); }

  void AddSags() {
    for (const ShotProgram::Loads& sag : p_.sags) {
      if (at_.theta[sag.parameter] == 0.0) continue;
      const V theta = Of(at_.theta[sag.parameter]);
      Clear(own_);
      Sum(sag, Of(1.0), own_, own_);
      Accumulate(own_);
      law_[sag.slot] = Fma(theta, TorqueBy(own_, sag.slot), law_[sag.slot]);
      AddAnswer(own_, sag.slot, theta);
    }
  }

  // d f_s / d value of the transform behind `twist`.
  HWY_INLINE V LawBy(int s, int twist) const {
    const ShotProgram::Slot& slot = p_.slots[s];
    const ShotProgram::Twist& own = p_.twists[twist];
    const TwistLanes& moves = twists_[twist];
    if (own.transform < slot.transform) return Dot(before_[s], moves.w);
    const TwistLanes& beyond = beyond_[s * (p_.num_levels + 1) + own.level];
    V by = Work(moves, beyond.w, beyond.v);
    if (own.transform == slot.transform && p_.has_spring && p_.spring.slot == s) {
      by = Fma(flexibility_[s], spring_stiffness_, by);
    }
    return by;
  }

  // (I - F_u)^-1 by Gauss and Jordan; F_u is small where the arm does not fold, so that no pivots are sought.
  void InvertResponse() {
    const int n = static_cast<int>(p_.slots.size());
    for (int r = 0; r < n; ++r) {
      for (int c = 0; c < n; ++c) {
        const V unit = Of(r == c ? 1.0 : 0.0);
        matrix_[r * n + c] = hn::Sub(unit, LawBy(r, p_.slots[c].twist));
        response_[r * n + c] = unit;
      }
    }
    for (int k = 0; k < n; ++k) {
      const V inverse = hn::Div(Of(1.0), matrix_[k * n + k]);
      for (int c = k; c < n; ++c) matrix_[k * n + c] = hn::Mul(matrix_[k * n + c], inverse);
      for (int c = 0; c <= k; ++c) response_[k * n + c] = hn::Mul(response_[k * n + c], inverse);
      for (int r = 0; r < n; ++r) {
        if (r == k) continue;
        const V factor = matrix_[r * n + k];
        for (int c = k; c < n; ++c) matrix_[r * n + c] = Fnma(factor, matrix_[k * n + c], matrix_[r * n + c]);
        for (int c = 0; c <= k; ++c) response_[r * n + c] = Fnma(factor, response_[k * n + c], response_[r * n + c]);
      }
    }
  }

  void EvaluateSpring() {
    const V sign = Of(p_.spring.sign), cos_offset = Of(p_.spring.cos_offset), sin_offset = Of(p_.spring.sin_offset);
    // q = sign (v - offset)
    const V sine = hn::Mul(sign, Fnma(spring_cosine_, sin_offset, hn::Mul(spring_sine_, cos_offset)));
    const V cosine = Fma(spring_cosine_, cos_offset, hn::Mul(spring_sine_, sin_offset));
    const double* theta = at_.theta + p_.spring.first_parameter;
    SpringTorque spring = SpringAt(theta, sine, cosine);
    spring_stiffness_ = spring.by_angle;  // sign^2 = 1
    if (p_.spring.commanded >= 0) {
      const SpringTorque idle = SpringAt(theta, Datum(p_.spring.commanded), Datum(p_.spring.commanded + 1));
      spring.torque = hn::Sub(spring.torque, idle.torque);
      for (int i = 0; i < 5; ++i) spring.by[i] = hn::Sub(spring.by[i], idle.by[i]);
    }
    torque_[p_.spring.slot] = Fma(sign, spring.torque, torque_[p_.spring.slot]);
    for (int i = 0; i < 5; ++i) by_spring_[i] = hn::Mul(sign, spring.by[i]);
  }

  // A wrench that stays while the base turns by rho changes in the base frame by dF = F x rho, dM = M x rho:
  // sum of x x dF = Q rho - tr(Q) rho.
  void AddTurn(const Sums* sums, int only_slot, V factor) {
    for (int s = 0; s < static_cast<int>(p_.slots.size()); ++s) {
      if (only_slot >= 0 && s != only_slot) continue;
      const Sums& acting = sums[p_.slots[s].level];
      const V weight = only_slot < 0 ? flexibility_[s] : factor;
      for (int axis = 0; axis < 3; ++axis) {
        const V3 turn = StationAxis(axis);
        const V by = Work(twists_[p_.slots[s].twist], Turned(acting, turn) + Cross(acting.pure, turn),
                          Cross(acting.force, turn));
        by_rotation_[3 * s + axis] = Fma(weight, by, by_rotation_[3 * s + axis]);
      }
    }
  }

  const ShotProgram& p_;
  const BatchPoint& at_;
  const M3 base_;
  char* memory_ = nullptr;
  std::size_t used_ = 0;
  const double* data_ = nullptr;
  int lane_ = 0, frame_ = 0;

  TwistLanes* twists_;  // of the undeflected and deflected arm alike: at the current values
  V3* origins_;         // of the slots' transforms
  Frame* frames_;       // kept ones
  Sums *measured_, *in_base_, *own_;
  TwistLanes* beyond_;  // slots x levels: d law / d value of transforms from the slot on
  V3* before_;          // of transforms before the slot
  V *torque_, *flexibility_, *deflection_, *step_, *law_;
  V *matrix_, *response_;
  TwistLanes* imposed_;
  V* by_rotation_;  // slots x 3
  V spring_sine_, spring_cosine_, spring_stiffness_, by_spring_[5];
};

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#endif
