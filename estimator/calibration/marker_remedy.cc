#include "estimator/calibration/marker_remedy.h"

#include <algorithm>

#include "estimator/report/calibration_words.h"
#include "models/kinematics.h"

namespace sagitta {
namespace {

// m: a turn by 1 rad moves such a marker by less than what a direction that is not determined is held for.
constexpr double kOnAxis = 5e-3;

}  // namespace

std::optional<int> AxisOfAllMarkers(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const Chain& chain = problem.model().chain();
  int last = -1;
  for (int j = 0; j < chain.num_joints(); ++j) {
    const bool is_later = last < 0 || chain.JointTransform(j) > chain.JointTransform(last);
    if (chain.joints[j].type == JointType::kRevolute && is_later) last = j;
  }
  if (last < 0 || problem.shot_inputs().empty()) return std::nullopt;
  ChainState<double> state;
  const std::vector<double> values =
      problem.model().TransformValues(problem.shot_inputs()[0], parameters.ModelValues().data());
  EvaluateChain(chain, values.data(), &state);
  const int axis = chain.JointTransform(last);
  bool any = false;
  for (size_t m = 0; m < problem.data().markers.size(); ++m) {
    const int frame = problem.marker_frames()[m];
    if (frame <= axis) continue;
    const Vector3<double> arm = state.frames[frame] * parameters.MarkerPoint(static_cast<int>(m)) - state.origin[axis];
    if (state.axis[axis].cross(arm).norm() > kOnAxis) return std::nullopt;
    any = true;
  }
  return any ? std::optional<int>(last) : std::nullopt;
}

void AddMarkerRemedies(const CalibrationProblem& problem, Estimate* estimate) {
  const bool any_pose = std::any_of(problem.data().observations.begin(), problem.data().observations.end(),
                                    [](const Observation& row) { return !row.is_point(); });
  if (any_pose || estimate->identifiability.unidentifiable.empty()) return;
  const std::optional<int> joint = AxisOfAllMarkers(problem, estimate->parameters);
  if (!joint) return;
  for (Direction& direction : estimate->identifiability.unidentifiable) {
    const bool is_geometry = std::all_of(
        direction.components.begin(), direction.components.end(),
        [](const auto& component) { return CoordinateKindOf(component.first) == CoordinateKind::kGeometry; });
    if (is_geometry) direction.remedy = MarkersAreOnTheAxis(problem.robot().chain.joints[*joint].name);
  }
}

}  // namespace sagitta
