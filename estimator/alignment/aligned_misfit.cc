#include "estimator/alignment/aligned_misfit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "estimator/alignment/starting_values.h"
#include "estimator/least_squares/linearization.h"
#include "models/matrix_functions.h"
#include "problems/problem_checks.h"

namespace sagitta {
namespace {

constexpr int kRowsPerPair = 40;  // of a station and marker: enough to reveal a wrong unit
constexpr double kTravel = 1.0;   // m, of a sliding joint without limits: half a metre to either side of its zero

}  // namespace

double Reach(const Chain& chain) {
  double lengths = 0.0, travel = 0.0;
  for (const ElementaryTransform& transform : chain.transforms) {
    if (!transform.is_rotation()) lengths += std::abs(transform.nominal);
  }
  for (const Joint& joint : chain.joints) {
    if (joint.type == JointType::kRevolute) continue;
    travel += joint.min && joint.max ? *joint.max - *joint.min : kTravel;
  }
  return std::max(lengths, travel);
}

double Reach(const CalibrationProblem& problem) {
  Chain chain = problem.robot().chain;
  const std::vector<Configuration>& configurations = problem.data().configurations;
  for (int j = 0; j < chain.num_joints() && !configurations.empty(); ++j) {
    Joint& joint = chain.joints[j];
    if (joint.min && joint.max) continue;
    const auto by_joint = [j](const Configuration& a, const Configuration& b) { return a.q[j] < b.q[j]; };
    const auto [least, most] = std::minmax_element(configurations.begin(), configurations.end(), by_joint);
    joint.min = least->q[j], joint.max = most->q[j];
  }
  return Reach(chain);
}

std::vector<int> SampleOfRows(const CalibrationProblem& problem) {
  std::map<std::pair<int, int>, std::vector<int>> pairs;
  for (const int i : problem.CalibrationObservations()) {
    const Observation& observation = problem.data().observations[i];
    if (observation.is_point())
      pairs[{problem.data().shots[observation.shot].station, observation.marker}].push_back(i);
  }
  std::vector<int> sample;
  for (const auto& [pair, all] : pairs) {
    const size_t n = std::min<size_t>(kRowsPerPair, all.size());
    for (size_t k = 0; k < n; ++k) {
      const int point = all[k * all.size() / n], rotation = problem.data().observations[point].partner;
      sample.push_back(point);
      if (rotation >= 0) sample.push_back(rotation);
    }
  }
  std::sort(sample.begin(), sample.end());
  return sample;
}

namespace {

double AlignTo(const CalibrationProblem& problem, const std::vector<int>& rows, ParameterSet* parameters) {
  const double rigid = FindStartingValues(problem, rows, parameters);
  const std::vector<int> points = problem.data().PointsAmong(rows);
  if (points.empty()) return rigid;
  const Eigen::Matrix3Xd errors = ResidualsOf(problem.data(), points, PredictPoints(problem, *parameters, points));
  const double deflected = std::sqrt(errors.squaredNorm() / static_cast<double>(points.size()));
  return std::isfinite(deflected) ? std::min(rigid, deflected) : rigid;
}

// Where the unloaded arm has the points, shot by shot.
Eigen::Matrix3Xd RigidPoints(const CalibrationProblem& problem, const ParameterSet& parameters,
                             const std::vector<int>& points) {
  const std::vector<double> theta = parameters.ModelValues();
  Eigen::Matrix3Xd predicted(3, static_cast<Eigen::Index>(points.size()));
  ChainState<double> state;
  Pose<double> base;
  int latest = -1;
  for (size_t k = 0; k < points.size(); ++k) {
    const Observation& row = problem.data().observations[points[k]];
    if (std::exchange(latest, row.shot) != row.shot) {
      const ShotInput& input = problem.shot_inputs()[row.shot];
      EvaluateChain(problem.model().chain(), problem.model().TransformValues(input, theta.data()).data(), &state);
      base = parameters.BaseInStation(problem.data().shots[row.shot].station);
    }
    predicted.col(static_cast<Eigen::Index>(k)) =
        base * (state.frames[problem.marker_frames()[row.marker]] * parameters.MarkerPoint(row.marker));
  }
  return predicted;
}

}  // namespace

double AlignedMisfit(const CalibrationProblem& problem, const std::vector<int>& rows) {
  ParameterSet parameters = problem.parameters;
  return AlignTo(problem, rows, &parameters);
}

AlignedSample::AlignedSample(const CalibrationProblem& problem)
    : rows(SampleOfRows(problem)), parameters(problem.parameters) {
  CheckRowsAreRead(problem);
  misfit = AlignTo(problem, rows, &parameters);
}

bool MissesRows(const CalibrationProblem& problem, const AlignedSample& aligned, const std::vector<int>& points,
                double limit) {
  const auto misfit_of = [&](const Eigen::Matrix3Xd& predicted) {
    double squares = 0.0;
    for (size_t k = 0; k < points.size(); ++k) {
      const Vector3<double>& measured = problem.data().observations[points[k]].point_in_station;
      squares += (measured - predicted.col(static_cast<Eigen::Index>(k))).squaredNorm();
    }
    return std::sqrt(squares / static_cast<double>(std::max<size_t>(1, points.size())));
  };
  // Rows that are far off are so from the unloaded arm too, and that costs a third.
  return misfit_of(RigidPoints(problem, aligned.parameters, points)) > 0.5 * limit &&
         misfit_of(PredictPoints(problem, aligned.parameters, points)) > limit;
}

std::vector<Matrix3<double>> AlignedOrientations(const CalibrationProblem& problem) {
  ParameterSet parameters = problem.parameters;
  FindStartingValues(problem, SampleOfRows(problem), &parameters);
  std::vector<int> all(problem.data().observations.size());
  std::iota(all.begin(), all.end(), 0);
  return OrientationsAt(problem, parameters, problem.data().PointsAmong(all));
}

std::vector<Matrix3<double>> OrientationsAt(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            const std::vector<int>& observations) {
  const std::vector<double> theta = parameters.ModelValues();
  std::vector<Matrix3<double>> orientations;
  ChainState<double> state;
  for (const int i : observations) {
    const Observation& observation = problem.data().observations[i];
    const ShotInput& input = problem.shot_inputs()[observation.shot];
    EvaluateChain(problem.model().chain(), problem.model().TransformValues(input, theta.data()).data(), &state);
    const Pose<double>& frame = state.frames[problem.marker_frames()[observation.marker]];
    orientations.push_back(parameters.BaseInStation(problem.data().shots[observation.shot].station).rotation *
                           frame.rotation);
  }
  return orientations;
}

double RotationMisfit(const std::vector<TargetRotation>& readings) {
  std::map<int, Matrix3<double>> sums;
  for (const TargetRotation& reading : readings) {
    Matrix3<double>& sum = sums.emplace(reading.marker, Matrix3<double>::Zero()).first->second;
    sum += reading.station_from_frame.transpose() * reading.station_from_target;
  }
  // The rotation that is nearest to the sum is the least-squares mean (Moakher 2002).
  for (auto& [marker, sum] : sums) sum = NearestRotation(sum);
  double squares = 0.0;
  for (const TargetRotation& reading : readings) {
    const Matrix3<double> expected = reading.station_from_frame * sums.at(reading.marker);
    squares += RotationVector(Matrix3<double>(reading.station_from_target * expected.transpose())).squaredNorm();
  }
  if (readings.empty()) return std::numeric_limits<double>::infinity();
  return std::sqrt(squares / static_cast<double>(readings.size()));
}

}  // namespace sagitta
