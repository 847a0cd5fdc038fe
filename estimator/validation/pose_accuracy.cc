#include "estimator/validation/pose_accuracy.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <tuple>

namespace sagitta {
namespace {

struct Mean {
  Vector3<double> sum = Vector3<double>::Zero();
  int count = 0;
  void Add(const Vector3<double>& point) {
    sum += point;
    ++count;
  }
  Vector3<double> value() const { return sum / count; }
};

using Arrivals = std::vector<Mean>;  // one per visit

// Calls visit(arrivals) for each pose: configuration, marker, station, load and approach.
void ForEachPose(const CalibrationProblem& problem, const std::vector<int>& observations,
                 const Eigen::Matrix3Xd& positions, const std::function<void(const Arrivals& arrivals)>& visit) {
  const auto row = [&](size_t k) -> const Observation& { return problem.data().observations[observations[k]]; };
  const auto pose = [&](size_t k) {
    const Shot& shot = problem.data().shots[row(k).shot];
    return std::tie(shot.configuration, row(k).marker, shot.station, shot.load, shot.approach);
  };
  const auto arrival = [&](size_t k) -> const std::string& { return problem.data().shots[row(k).shot].visit; };
  std::vector<size_t> order(observations.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto is_before = [&](size_t a, size_t b) {
    if (pose(a) != pose(b)) return pose(a) < pose(b);
    return arrival(a) < arrival(b);
  };
  if (!std::is_sorted(order.begin(), order.end(), is_before)) std::stable_sort(order.begin(), order.end(), is_before);
  Arrivals arrivals;
  for (size_t i = 0; i < order.size(); ++i) {
    const bool same_pose = i > 0 && pose(order[i - 1]) == pose(order[i]);
    if (!same_pose && i > 0) {
      visit(arrivals);
      arrivals.clear();
    }
    if (!same_pose || arrival(order[i - 1]) != arrival(order[i])) arrivals.emplace_back();
    arrivals.back().Add(positions.col(static_cast<Eigen::Index>(order[i])));
  }
  if (!arrivals.empty()) visit(arrivals);
}

Vector3<double> Barycentre(const Arrivals& arrivals) {
  Mean mean;
  for (const Mean& position : arrivals) mean.Add(position.value());
  return mean.value();
}

// RP_l of two arrivals or more.
double Repeatability(const Arrivals& arrivals) {
  const Vector3<double> barycentre = Barycentre(arrivals);
  const auto n = static_cast<double>(arrivals.size());
  double sum = 0.0, squares = 0.0;
  for (const Mean& position : arrivals) sum += (position.value() - barycentre).norm();
  for (const Mean& position : arrivals) {
    squares += std::pow((position.value() - barycentre).norm() - sum / n, 2);
  }
  // ISO 9283: RP = mean l + 3 S_l, l the distance of an arrival from the barycentre.
  return sum / n + 3.0 * std::sqrt(squares / (n - 1.0));
}

}  // namespace

PoseAccuracy MeasurePoseAccuracy(const CalibrationProblem& problem, const std::vector<int>& observations,
                                 const Eigen::Matrix3Xd& errors) {
  PoseAccuracy accuracy;
  ForEachPose(problem, observations, errors, [&accuracy](const Arrivals& arrivals) {
    const double distance = Barycentre(arrivals).norm();
    accuracy.largest = std::max(accuracy.largest, distance);
    accuracy.mean += distance;
    ++accuracy.poses;
  });
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
  ForEachPose(problem, observations, positions, [&repeatability](const Arrivals& arrivals) {
    const auto n = static_cast<int>(arrivals.size());
    if (n < 2) return;
    const double own = Repeatability(arrivals);
    repeatability.fewest = repeatability.poses == 0 ? n : std::min(repeatability.fewest, n);
    repeatability.most = std::max(repeatability.most, n);
    repeatability.largest = std::max(repeatability.largest, own);
    repeatability.mean += own;
    ++repeatability.poses;
  });
  repeatability.mean /= std::max(1, repeatability.poses);
  return repeatability;
}

}  // namespace sagitta
