#include "estimator/validation/pose_accuracy.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <tuple>

namespace sagitta {
namespace {

// Of points about a first one: differences of metres are lost in the squares of a far frame's coordinates.
struct Mean {
  Vector3<double> first = Vector3<double>::Zero(), sum = Vector3<double>::Zero();
  double squares = 0.0;
  int count = 0;
  void Add(const Vector3<double>& point) {
    if (count++ == 0) first = point;
    sum += point - first;
    squares += (point - first).squaredNorm();
  }
  Vector3<double> value() const { return first + sum / count; }
  // Squared distances from the mean, summed.
  double scatter() const { return std::max(0.0, squares - sum.squaredNorm() / count); }
};

using Arrivals = std::vector<Mean>;  // one per visit

// Calls visit(configuration, arrivals) for each commanded position: configuration, marker, station, load and approach.
void ForEachPosition(const CalibrationProblem& problem, const std::vector<int>& observations,
                     const Eigen::Matrix3Xd& positions,
                     const std::function<void(int configuration, const Arrivals& arrivals)>& visit) {
  const auto row = [&](size_t k) -> const Observation& { return problem.data().observations[observations[k]]; };
  const auto position = [&](size_t k) {
    const Shot& shot = problem.data().shots[row(k).shot];
    return std::tie(shot.configuration, row(k).marker, shot.station, shot.load, shot.approach);
  };
  const auto arrival = [&](size_t k) -> const std::string& { return problem.data().shots[row(k).shot].visit; };
  std::vector<size_t> order(observations.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto is_before = [&](size_t a, size_t b) {
    if (position(a) != position(b)) return position(a) < position(b);
    return arrival(a) < arrival(b);
  };
  if (!std::is_sorted(order.begin(), order.end(), is_before)) std::stable_sort(order.begin(), order.end(), is_before);
  Arrivals arrivals;
  for (size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && position(order[i - 1]) == position(order[i]);
    if (!is_same && i > 0) {
      visit(std::get<0>(position(order[i - 1])), arrivals);
      arrivals.clear();
    }
    if (!is_same || arrival(order[i - 1]) != arrival(order[i])) arrivals.emplace_back();
    arrivals.back().Add(positions.col(static_cast<Eigen::Index>(order[i])));
  }
  if (!arrivals.empty()) visit(std::get<0>(position(order.back())), arrivals);
}

Vector3<double> Barycentre(const Arrivals& arrivals) {
  Mean mean;
  for (const Mean& position : arrivals) mean.Add(position.value());
  return mean.value();
}

// RP_l of kFewestArrivals or more.
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
  int last = -1, repeated = 0;  // positions come by configuration
  double squares = 0.0;
  ForEachPosition(problem, observations, errors, [&](int configuration, const Arrivals& arrivals) {
    const double distance = Barycentre(arrivals).norm();
    accuracy.largest = std::max(accuracy.largest, distance);
    accuracy.mean += distance;
    ++accuracy.positions;
    if (configuration != last) ++accuracy.poses;
    last = configuration;
    for (const Mean& arrival : arrivals) {
      if (arrival.count == 1) continue;
      squares += arrival.scatter();
      repeated += arrival.count;
    }
  });
  accuracy.mean /= std::max(1, accuracy.positions);
  accuracy.scatter = std::sqrt(squares / std::max(1, repeated));
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
  int last = -1;
  ForEachPosition(problem, observations, positions, [&](int configuration, const Arrivals& arrivals) {
    const auto n = static_cast<int>(arrivals.size());
    repeatability.most = std::max(repeatability.most, n);
    if (n < kFewestArrivals) return;
    const double own = Repeatability(arrivals);
    repeatability.fewest = repeatability.positions == 0 ? n : std::min(repeatability.fewest, n);
    repeatability.largest = std::max(repeatability.largest, own);
    repeatability.mean += own;
    ++repeatability.positions;
    if (configuration != last) ++repeatability.poses;
    last = configuration;
  });
  repeatability.mean /= std::max(1, repeatability.positions);
  return repeatability;
}

}  // namespace sagitta
