// What one unit of each parameter moves in one register's worth of shots (models/excitation.h), and what their wrenches
// ask of the joints. Compiled once per
// instruction set; see batch_rows.h.
#if defined(SAGITTA_MODELS_BATCH_LANE_MOTIONS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SAGITTA_MODELS_BATCH_LANE_MOTIONS_INL_H_
#undef SAGITTA_MODELS_BATCH_LANE_MOTIONS_INL_H_
#else
#define SAGITTA_MODELS_BATCH_LANE_MOTIONS_INL_H_
#endif

#include "models/batch/batch_rows.h"
#include "models/batch/lane_sights-inl.h"
#include "models/batch/lane_statics-inl.h"
#include "models/batch/lanes-inl.h"
#include "models/excitation.h"

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {

class LaneMotions {
 public:
  LaneMotions(const ShotProgram& program, const BatchPoint& at, LaneMemory* memory, double* motions)
      : p_(program), at_(at), statics_(program, at, memory), motions_(motions) {}

  // All lanes where one of them does not settle.
  unsigned Raise(const double* data, int lane) {
    if (statics_.Settle(data, lane) != 0) return (1u << hn::Lanes(Tag())) - 1;
    for (const ShotProgram::Transform& transform : p_.transforms) {
      for (const ShotProgram::Scaled& term : transform.terms) Raise(term.parameter, statics_.Datum(term.data));
    }
    if (p_.is_elastic()) RaiseByTorques();
    for (size_t m = 0; m < p_.markers.size(); ++m) RaiseByPoint(static_cast<int>(m), data, lane);
    return 0;
  }

 private:
  void Raise(int parameter, V value) {
    motions_[parameter] = std::max(motions_[parameter], hn::GetLane(hn::MaxOfLanes(Tag(), hn::Abs(value))));
  }
  static V Norm(V3 v) { return hn::Sqrt(Dot(v, v)); }

  void RaiseByTorques() {
    const V none = hn::Mul(Of(kNoLever), statics_.LargestForce());
    for (const ShotProgram::Elastic& term : p_.elastic) {
      if (term.slot < 0) continue;
      const V value = hn::Mul(statics_.Datum(term.data), statics_.Phi(term));
      Raise(term.parameter, hn::IfThenElseZero(hn::Lt(none, hn::Abs(statics_.TorqueOn(term.slot))), value));
    }
    for (const ShotProgram::Loads& sag : p_.sags) Raise(sag.parameter, statics_.TorqueOf(sag, sag.slot));
    for (size_t i = 1; i < p_.loads.size(); ++i) {
      Raise(p_.loads[i].parameter, statics_.LargestDeflection(p_.loads[i]));
    }
    for (int i = 0; i < 5 && p_.has_spring; ++i) {
      Raise(p_.spring.first_parameter + i, statics_.LargestDeflectionBySpring(i));
    }
  }

  void RaiseByPoint(int m, const double* data, int lane) {
    const ShotProgram::Marker& marker = p_.markers[m];
    if (!p_.MovesDirectly(marker)) return;
    const Vector3<double>& given = at_.marker_points[m];
    const Frame& frame = statics_.chain().KeptFrame(marker.kept_frame);
    const V3 from_base = frame * V3{Of(given.x()), Of(given.y()), Of(given.z())};
    const Vector3<double>& t = at_.base_in_station.translation;
    const V3 seen = from_base + V3{Of(t.x()), Of(t.y()), Of(t.z())};
    for (const ShotProgram::MarkerDirection& term : marker.terms) {
      Raise(term.parameter, Norm(At3(data, term.data, lane)));
    }
    for (const ShotProgram::Scaled& term : p_.growth) {
      if (marker.grows) Raise(term.parameter, hn::Mul(statics_.Datum(term.data), Norm(from_base)));
    }
    for (const ShotProgram::Station& term : p_.station) {
      Raise(term.parameter, Norm(AtMatrix(data, term.data, lane) * seen + At3(data, term.data + 9, lane)));
    }
    for (const ShotProgram::Sight& sight : marker.sights) {
      const V3 axis = SightAxis(sight, data + lane, frame.rotation);
      Raise(sight.term.parameter, Norm(DisplacementBySight(sight, data + lane, seen, axis)));
    }
  }

  const ShotProgram& p_;
  const BatchPoint& at_;
  LaneStatics statics_;
  double* motions_;
};

unsigned MotionsOfLanes(const ShotProgram& program, const BatchPoint& at, const double* data, BatchScratch* scratch,
                        double* motions) {
  LaneMemory memory(scratch->Reserve(LaneStatics::MemoryFor(program) / sizeof(double)));
  LaneMotions shots(program, at, &memory, motions);
  const int stride = static_cast<int>(hn::Lanes(Tag()));
  unsigned unsettled = 0;
  for (int lane = 0; lane < kBatchLanes; lane += stride) unsettled |= shots.Raise(data, lane) << lane;
  return unsettled;
}

unsigned TorquesOfLanes(const ShotProgram& program, const BatchPoint& at, const double* data, BatchScratch* scratch,
                        double* torques) {
  if (program.loads.empty()) return (1u << kBatchLanes) - 1;  // nothing answers to wrenches, and these are not packed
  LaneMemory memory(scratch->Reserve(LaneStatics::MemoryFor(program) / sizeof(double)));
  LaneStatics statics(program, at, &memory);
  unsigned unsettled = 0;
  for (int lane = 0; lane < kBatchLanes; lane += static_cast<int>(hn::Lanes(Tag()))) {
    unsettled |= statics.Settle(data, lane) << lane;
    statics.TakeLastStep();
    for (size_t j = 0; j < program.joint_twists.size(); ++j) {
      hn::StoreU(statics.TorqueAbout(program.loads[0], program.joint_twists[j]), Tag(),
                 torques + j * kBatchLanes + lane);
    }
  }
  return unsettled;
}

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#endif
