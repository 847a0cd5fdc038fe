#include "models/batch/batch_rows.h"

// The order of these is Highway's.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "models/batch/batch_rows.cc"
#include "models/batch/targets.h"

#include <hwy/foreach_target.h>  // must come before highway.h

#include <cmath>
#include <utility>

#include <hwy/aligned_allocator.h>
#include <hwy/highway.h>

#include "models/batch/lane_motions-inl.h"
#include "models/batch/lane_shots-inl.h"
// clang-format on

#if HWY_ONCE
namespace sagitta {

HWY_EXPORT(EvaluateLanes);
HWY_EXPORT(MotionsOfLanes);
HWY_EXPORT(TargetOfLanes);
HWY_EXPORT(TorquesOfLanes);

BatchPoint::BatchPoint(const ShotProgram& program, const double* theta_in, const Pose<double>& base_in_station_in,
                       std::vector<Vector3<double>> marker_points_in)
    : theta(theta_in), base_in_station(base_in_station_in), marker_points(std::move(marker_points_in)) {
  for (const ShotProgram::Transform& transform : program.transforms) {
    double value = transform.geometry >= 0 ? theta[transform.geometry] : 0.0;
    if (transform.lane_value < 0) value += transform.nominal;
    const bool is_turn = transform.is_fixed() && transform.is_rotation;
    fixed.push_back(is_turn ? std::sin(value) : value);
    fixed.push_back(is_turn ? std::cos(value) : 0.0);
  }
}

BatchPlan::BatchPlan(const ShotProgram& program, BatchLayout layout_in) : layout(std::move(layout_in)) {
  using PartOf = ShotProgram::PartOf;
  std::vector<char> is_needed(program.twists.size(), 0);
  for (int i = 0; i < program.num_parameters; ++i) {
    if (layout.theta[i] < 0) continue;
    const int first = program.first_part[i], last = program.first_part[i + 1];
    for (int p = first; p < last; ++p) {
      if (program.parts[p].of == PartOf::kTransform) is_needed[program.parts[p].index] = 1;
    }
    if (last - first == 1 && program.parts[first].of == PartOf::kTransform && program.parts[first].data < 0) {
      by_transform.push_back({program.parts[first].index, layout.theta[i]});
    } else {
      sums.push_back({first, last, layout.theta[i]});
    }
  }
  // The program of what only the model evaluates is empty.
  for (const int j : layout.latent_joints) {
    if (!is_needed.empty()) is_needed[program.joint_twists[j]] = 1;
  }
  for (std::size_t k = 0; k < is_needed.size(); ++k) {
    if (is_needed[k] != 0) twists.push_back(static_cast<int>(k));
  }
}

struct BatchScratch::Memory {
  hwy::AlignedFreeUniquePtr<double[]> doubles;
  std::size_t size = 0;
};

BatchScratch::BatchScratch() : memory_(std::make_unique<Memory>()) {}
BatchScratch::~BatchScratch() = default;

double* BatchScratch::Reserve(std::size_t doubles) {
  if (memory_->size < doubles) {
    memory_->doubles = hwy::AllocateAligned<double>(doubles);
    memory_->size = doubles;
  }
  return memory_->doubles.get();
}

unsigned EvaluateBatch(const ShotProgram& program, const BatchPoint& at, const BatchPlan& plan, const double* data,
                       BatchScratch* scratch, double* rows) {
  return HWY_DYNAMIC_DISPATCH(EvaluateLanes)(program, at, plan, data, scratch, rows);
}

unsigned RaiseMotions(const ShotProgram& program, const BatchPoint& at, const double* data, BatchScratch* scratch,
                      double* motions) {
  return HWY_DYNAMIC_DISPATCH(MotionsOfLanes)(program, at, data, scratch, motions);
}

unsigned WrenchTorques(const ShotProgram& program, const BatchPoint& at, const double* data, BatchScratch* scratch,
                       double* torques) {
  return HWY_DYNAMIC_DISPATCH(TorquesOfLanes)(program, at, data, scratch, torques);
}

const char* BatchInstructions() { return HWY_DYNAMIC_DISPATCH(TargetOfLanes)(); }

}  // namespace sagitta
#endif
