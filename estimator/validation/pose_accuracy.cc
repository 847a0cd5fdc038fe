#include "estimator/validation/pose_accuracy.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

namespace sagitta {
namespace {

// Configuration, marker, station, load, approach; then the arrival.
using PoseKey = std::tuple<int, int, int, std::string, std::vector<int>>;

struct Mean {
  Vector3<double> sum = Vector3<double>::Zero();
  int count = 0;
  void Add(const Vector3<double>& point) {
    sum += point;
    ++count;
  }
  Vector3<double> value() const { return sum / count; }
};

using Arrivals = std::map<std::string, Mean>;  // by visit

std::map<PoseKey, Arrivals> ByPose(const CalibrationProblem& problem, const std::vector<int>& observations,
                                   const Eigen::Matrix3Xd& positions) {
  std::map<PoseKey, Arrivals> poses;
  for (size_t k = 0; k < observations.size(); ++k) {
    const Observation& observation = problem.data().observations[observations[k]];
    const Shot& shot = problem.data().shots[observation.shot];
    const PoseKey key{shot.configuration, observation.marker, shot.station, shot.load, shot.approach};
    poses[key][shot.visit].Add(positions.col(static_cast<Eigen::Index>(k)));
  }
  return poses;
}

Vector3<double> Barycentre(const Arrivals& arrivals) {
  Mean mean;
  for (const auto& [visit, position] : arrivals) mean.Add(position.value());
  return mean.value();
}

// RP_l of two arrivals or more.
double Repeatability(const Arrivals& arrivals) {
  const Vector3<double> barycentre = Barycentre(arrivals);
  const auto n = static_cast<double>(arrivals.size());
  double sum = 0.0, squares = 0.0;
  for (const auto& [visit, position] : arrivals) sum += (position.value() - barycentre).norm();
  for (const auto& [visit, position] : arrivals) {
    squares += std::pow((position.value() - barycentre).norm() - sum / n, 2);
  }
  // ISO 9283: RP = mean l + 3 S_l, l the distance of an arrival from the barycentre.
  return sum / n + 3.0 * std::sqrt(squares / (n - 1.0));
}

}  // namespace

PoseAccuracy MeasurePoseAccuracy(const CalibrationProblem& problem, const std::vector<int>& observations,
                                 const Eigen::Matrix3Xd& errors) {
  PoseAccuracy accuracy;
  for (const auto& [pose, arrivals] : ByPose(problem, observations, errors)) {
    const double distance = Barycentre(arrivals).norm();
    accuracy.largest = std::max(accuracy.largest, distance);
    accuracy.mean += distance;
    ++accuracy.poses;
  }
  accuracy.mean /= std::max(1, accuracy.poses);
  return accuracy;
}

PoseRepeatability MeasurePoseRepeatability(const CalibrationProblem& problem) {
  std::vector<int> observations;
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    const Observation& observation = problem.data().observations[i];
    if (observation.is_point() && !observation.excluded) observations.push_back(static_cast<int>(i));
  }
  Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(observations.size()));
  for (size_t k = 0; k < observations.size(); ++k) {
    positions.col(static_cast<Eigen::Index>(k)) = problem.data().observations[observations[k]].point_in_station;
  }
  PoseRepeatability repeatability;
  for (const auto& [pose, arrivals] : ByPose(problem, observations, positions)) {
    const auto n = static_cast<int>(arrivals.size());
    if (n < 2) continue;
    const double own = Repeatability(arrivals);
    repeatability.fewest = repeatability.poses == 0 ? n : std::min(repeatability.fewest, n);
    repeatability.most = std::max(repeatability.most, n);
    repeatability.largest = std::max(repeatability.largest, own);
    repeatability.mean += own;
    ++repeatability.poses;
  }
  repeatability.mean /= std::max(1, repeatability.poses);
  return repeatability;
}

}  // namespace sagitta
