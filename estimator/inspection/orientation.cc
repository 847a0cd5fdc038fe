#include "estimator/inspection/orientation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "models/kinematics.h"
#include "models/matrix_functions.h"
#include "problems/interruption.h"

namespace sagitta {
namespace {

// Stations connected by markers seen from both: the lowest index of each group.
std::vector<int> StationGroups(const CalibrationProblem& problem) {
  std::vector<int> group(problem.data().stations.size());
  for (size_t s = 0; s < group.size(); ++s) group[s] = static_cast<int>(s);
  std::vector<int> station_of_marker(problem.data().markers.size(), -1);
  for (const int i : problem.CalibrationObservations()) {
    const Observation& observation = problem.data().observations[i];
    const int own = problem.data().shots[observation.shot].station;
    int& other = station_of_marker[observation.marker];
    if (other < 0) other = own;
    const int low = std::min(group[own], group[other]), high = std::max(group[own], group[other]);
    if (low != high) std::replace(group.begin(), group.end(), high, low);
  }
  return group;
}

// configurations: each with one of its rows.
OrientationVariety VarietyOf(const CalibrationProblem& problem, const std::map<int, int>& configurations) {
  const std::vector<double> theta = problem.parameters.ModelValues();
  const Chain& chain = problem.model().chain();
  std::vector<Matrix3<double>> rotations;
  ChainState<double> state;
  for (const auto& [c, row] : configurations) {
    CheckInterruption();
    const ShotInput& input = problem.shot_inputs()[problem.data().observations[row].shot];
    EvaluateChain(chain, problem.model().TransformValues(input, theta.data()).data(), &state);
    rotations.push_back(state.frames[chain.FlangeFrame()].rotation);
  }
  Matrix3<double> mean = Matrix3<double>::Zero(), scatter = Matrix3<double>::Zero();
  for (const Matrix3<double>& rotation : rotations) mean += rotation / rotations.size();
  for (const Matrix3<double>& rotation : rotations)
    scatter += (rotation - mean).transpose() * (rotation - mean) / rotations.size();
  const PrincipalAxes own = PrincipalAxesOf(scatter);
  OrientationVariety variety;
  variety.least = std::sqrt(std::max(0.0, own.values[0]));
  variety.most = std::sqrt(std::max(0.0, own.values[2]));
  variety.still = own.axes.col(0);
  return variety;
}

}  // namespace

OrientationVariety OrientationVarietyOf(const CalibrationProblem& problem) {
  const std::vector<int> group = StationGroups(problem);
  const std::vector<std::string>& stations = problem.data().stations;
  OrientationVariety poorest;
  poorest.least = poorest.most = 2.0;  // more than any
  for (int g = 0; g < static_cast<int>(stations.size()); ++g) {
    std::map<int, int> configurations;
    for (const int i : problem.CalibrationObservations()) {
      const Observation& observation = problem.data().observations[i];
      const Shot& shot = problem.data().shots[observation.shot];
      const bool on_flange = problem.marker_frames()[observation.marker] == problem.robot().chain.FlangeFrame();
      if (on_flange && group[shot.station] == g) configurations.try_emplace(shot.configuration, i);
    }
    if (configurations.empty()) continue;
    const OrientationVariety variety = VarietyOf(problem, configurations);
    if (variety.least >= poorest.least) continue;
    poorest = variety;
    for (size_t s = 0; s < stations.size(); ++s) {
      if (group[s] == g) poorest.stations += (poorest.stations.empty() ? "" : ", ") + stations[s];
    }
    if (std::count(group.begin(), group.end(), g) == static_cast<long>(stations.size())) poorest.stations.clear();
  }
  return poorest;
}

}  // namespace sagitta
