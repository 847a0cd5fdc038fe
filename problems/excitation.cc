#include "problems/excitation.h"

#include <algorithm>
#include <cmath>

#include "models/excitation.h"

namespace sagitta {
namespace {

constexpr double kHoldMotion = 5e-3;  // m or rad, FORMATS section 4

// Lengths of the spring move its ends: they are limited as lengths.
bool IsLimitedByMotion(const ModelParameter& parameter) {
  if (parameter.law == ParameterLaw::kCompensator) return parameter.quantity == Quantity::kSpringRate;
  return parameter.law != ParameterLaw::kGeometry;
}

std::vector<double> LargestMotions(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const std::vector<double> theta = parameters.ModelValues();
  std::vector<double> largest(problem.model.num_parameters(), 0.0);
  for (size_t s = 0; s < problem.data.shots.size(); ++s) {
    const Shot& shot = problem.data.shots[s];
    if (problem.data.configurations[shot.configuration].is_validation) continue;
    std::vector<MarkerInFrame> markers;
    for (const int i : shot.observations) {
      const int marker = problem.data.observations[i].marker;
      markers.push_back({problem.marker_frames[marker], parameters.MarkerPoint(marker), marker});
    }
    const std::vector<double> motion = MotionPerUnit(problem.model, problem.shot_inputs[s], theta.data(),
                                                     parameters.BaseInStation(shot.station), markers);
    for (size_t i = 0; i < largest.size(); ++i) largest[i] = std::max(largest[i], motion[i]);
  }
  return largest;
}

}  // namespace

std::vector<double> LargestTrueMotions(const CalibrationProblem& problem, const ParameterSet& parameters) {
  std::vector<double> motions = LargestMotions(problem, parameters);
  for (int axis = 0; axis < 2; ++axis) {
    ParameterSet tilted = parameters;
    for (int s = 0; s < tilted.num_stations(); ++s) {
      Pose<double> pose = tilted.BaseInStation(s);
      const Vector3<double> turn = kHoldMotion * Vector3<double>::Unit(axis);
      pose.rotation = RotationFromVector(turn) * pose.rotation;
      tilted.SetBaseInStation(s, pose);
    }
    const std::vector<double> feigned = LargestMotions(problem, tilted);
    for (size_t i = 0; i < motions.size(); ++i) {
      if (motions[i] < std::abs(feigned[i] - motions[i])) motions[i] = 0.0;
    }
  }
  return motions;
}

void SetHoldLimits(const CalibrationProblem& problem, ParameterSet* parameters) {
  const auto& model_parameters = problem.model.parameters();
  const bool any = std::any_of(model_parameters.begin(), model_parameters.end(), IsLimitedByMotion);
  if (!any) return;
  const std::vector<double> motions = LargestTrueMotions(problem, *parameters);
  for (size_t i = 0; i < motions.size(); ++i) {
    if (!IsLimitedByMotion(model_parameters[i])) continue;
    Coordinate& coordinate = parameters->coordinate(parameters->model_parameter(static_cast<int>(i)).first_coordinate);
    coordinate.hold_limit = motions[i] > 0.0 ? kHoldMotion / motions[i] : TraitsOf(coordinate.quantity).hold_limit;
  }
}

}  // namespace sagitta
