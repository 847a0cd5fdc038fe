// Errors of readings (models/sight.h) in one register's worth of shots: lane by lane, as the reference has them.
// Compiled once per instruction set.
#if defined(SAGITTA_MODELS_BATCH_LANE_SIGHTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SAGITTA_MODELS_BATCH_LANE_SIGHTS_INL_H_
#undef SAGITTA_MODELS_BATCH_LANE_SIGHTS_INL_H_
#else
#define SAGITTA_MODELS_BATCH_LANE_SIGHTS_INL_H_
#endif

#include "models/batch/lanes-inl.h"
#include "models/batch/shot_program.h"
#include "models/sight.h"

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {

// Numbers of each lane, one after the other.
struct SpreadLanes {
  HWY_ALIGN double numbers[3][kBatchLanes];

  explicit SpreadLanes(V3 v) {
    Put(v.x, numbers[0]);
    Put(v.y, numbers[1]);
    Put(v.z, numbers[2]);
  }
  Vector3<double> Of(size_t lane) const { return {numbers[0][lane], numbers[1][lane], numbers[2][lane]}; }
  void Set(size_t lane, const Vector3<double>& v) {
    for (int i = 0; i < 3; ++i) numbers[i][lane] = v[i];
  }
  V3 Lanes() const { return {At(numbers[0]), At(numbers[1]), At(numbers[2])}; }
};

// data: of the register's first lane. rotation: of the marker's frame, in axes of the station.
inline V3 SightAxis(const ShotProgram::Sight& sight, const double* data, const M3& rotation) {
  return rotation * At3(data, sight.data + 4, 0);
}

// What one unit of the parameter does to points seen there.
inline V3 DisplacementBySight(const ShotProgram::Sight& sight, const double* data, V3 truth, V3 axis) {
  const SpreadLanes points(truth), axes(axis);
  SpreadLanes moved(Zero3());
  for (size_t i = 0; i < hn::Lanes(Tag()); ++i) {
    moved.Set(i, SightDisplacement<double>(sight.In(data + i), points.Of(i), axes.Of(i)));
  }
  return moved.Lanes();
}

struct SightGradientLanes {
  V3 displacement;
  M3 by_point, by_axis;
};
inline SightGradientLanes GradientOfSight(const ShotProgram::Sight& sight, const double* data, V3 truth, V3 axis) {
  const SpreadLanes points(truth), axes(axis), none(Zero3());
  SpreadLanes moved = none, by_point[3] = {none, none, none}, by_axis[3] = {none, none, none};
  for (size_t i = 0; i < hn::Lanes(Tag()); ++i) {
    const SightGradient own = DifferentiateSight(sight.In(data + i), points.Of(i), axes.Of(i));
    moved.Set(i, own.displacement);
    for (int c = 0; c < 3; ++c) {
      by_point[c].Set(i, own.by_point.col(c));
      by_axis[c].Set(i, own.by_axis.col(c));
    }
  }
  SightGradientLanes gradient = {moved.Lanes(), Zero33(), Zero33()};
  for (int c = 0; c < 3; ++c) {
    gradient.by_point.column[c] = by_point[c].Lanes();
    gradient.by_axis.column[c] = by_axis[c].Lanes();
  }
  return gradient;
}

// An axis turned by omega moves by omega x axis: B [axis]x
inline M3 ByTurnOfAxis(const M3& by_axis, V3 axis) {
  const V zero = Of(0.0);
  return by_axis *
         M3{{{zero, axis.z, hn::Neg(axis.y)}, {hn::Neg(axis.z), zero, axis.x}, {axis.y, hn::Neg(axis.x), zero}}};
}

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#endif
