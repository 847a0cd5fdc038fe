#include "estimator/inspection/sorted_points.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "estimator/alignment/starting_values.h"
#include "estimator/inspection/affine_in_marker.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/report/inspection_part_words.h"
#include "models/geometry.h"
#include "problems/interruption.h"

namespace sagitta {
namespace {

constexpr size_t kFewestSorted = 10;  // shots: in one of 10! = 4e6 orders a coordinate rises, in another it falls
constexpr size_t kMostSorted = 2000;  // shots: of more the search would need minutes
constexpr int kStartDirections = 60;  // starts: one lies within 15 degrees of any direction
constexpr int kRanked = 40;           // fits along the coordinate: a guard, an order that comes again ends them
constexpr int kMatched = 40;          // fits of places: a guard
constexpr int kWithoutGain = 4;       // of places: then a start leads nowhere

// The shots of one station, in the order of the files, in which a marker is seen; a row of each for every marker.
struct SortedShots {
  int station = 0, marker = 0, axis = 0;
  bool falls = false;
  std::vector<std::map<int, int>> shots;  // marker to observation
};

bool IsSorted(const std::vector<double>& values, bool falls) {
  return std::is_sorted(values.begin(), values.end(), [falls](double a, double b) { return falls ? a > b : a < b; });
}

std::optional<SortedShots> FindSortedShots(const Measurements& data) {
  std::map<int, std::map<int, std::map<int, int>>> stations;  // station, shot, marker
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& row = data.observations[i];
    if (row.is_point() && !row.excluded && row.point_in_station.allFinite())
      stations[data.shots[row.shot].station][row.shot][row.marker] = static_cast<int>(i);
  }
  for (const auto& [station, shots] : stations) {
    for (int marker = 0; marker < static_cast<int>(data.markers.size()); ++marker) {
      SortedShots found{station, marker, 0, false, {}};
      for (const auto& [shot, rows] : shots) {
        if (rows.count(marker) > 0) found.shots.push_back(rows);
      }
      if (found.shots.size() < kFewestSorted || found.shots.size() > kMostSorted) continue;
      for (found.axis = 0; found.axis < 3; ++found.axis) {
        std::vector<double> values;
        for (const auto& rows : found.shots)
          values.push_back(data.observations[rows.at(marker)].point_in_station[found.axis]);
        found.falls = values.front() > values.back();
        if (IsSorted(values, found.falls)) return found;
      }
    }
  }
  return std::nullopt;
}

// Directions that lie evenly on the unit sphere.
std::vector<Vector3<double>> EvenDirections(int count) {
  std::vector<Vector3<double>> directions;
  for (int k = 0; k < count; ++k) directions.push_back(OnSpiral(k, 1.0 - (2.0 * k + 1.0) / count));
  return directions;
}

class Matching {
 public:
  Matching(const CalibrationProblem& problem, const SortedShots& sorted)
      : stated_(problem.data()), problem_(problem), sorted_(sorted) {
    Measurements& data = *problem_.mutable_data();
    for (Observation& row : data.observations) row.excluded = true;
    for (const auto& shot : sorted.shots) {
      for (const auto& [marker, i] : shot) {
        bool in_all = true;
        for (const auto& other : sorted.shots) in_all = in_all && other.count(marker) > 0;
        if (!in_all) continue;
        rows_.push_back(i);
        data.observations[i].excluded = false;
      }
      of_marker_.push_back(shot.at(sorted.marker));
    }
    std::sort(rows_.begin(), rows_.end());
    ParameterSet in_base = problem_.parameters;
    in_base.SetBaseInStation(sorted_.station, Pose<double>());
    points_ = AffineInMarker(problem_, in_base, of_marker_, sorted_.marker);
  }

  // m RMS of the best match.
  double Best() {
    std::vector<Ranked> starts;
    for (const Vector3<double>& direction : EvenDirections(kStartDirections)) {
      CheckInterruption();
      starts.push_back(Rank(direction));
    }
    std::stable_sort(starts.begin(), starts.end(), [](const Ranked& a, const Ranked& b) { return a.rms < b.rms; });
    const auto is_same = [](const Ranked& a, const Ranked& b) { return a.order == b.order; };
    starts.erase(std::unique(starts.begin(), starts.end(), is_same), starts.end());
    for (const double up : {-1.0, 1.0}) starts.insert(starts.begin(), Rank(up * Vector3<double>::UnitZ()));
    double least = 1e300;
    for (const Ranked& start : starts) {
      CheckInterruption();
      least = std::min(least, Follow(start.order));
      if (least <= SuspiciousMisfit(problem_)) break;
    }
    return least;
  }

 private:
  struct Ranked {
    std::vector<int> order;
    double rms = 1e300;  // along the coordinate, m
  };

  // The order and, in turns, what the coordinate is then: c = a' (at_zero + sum m_axis along[axis]) + b, linear in the
  // direction a for a point m of the marker, and in m for a.
  Ranked Rank(Vector3<double> a) const {
    const Eigen::Index n = points_.at_zero.cols();
    Vector3<double> m = Vector3<double>::Zero();
    Ranked best;
    Eigen::VectorXd heights = points_.At(m).transpose() * a;
    std::vector<int> before;
    for (int round = 0; round < kRanked; ++round) {
      const std::vector<int> order = OrderOf(heights);
      if (order == before) break;
      before = order;
      Eigen::VectorXd stated(n);
      for (Eigen::Index j = 0; j < n; ++j) stated[j] = Coordinate(order[static_cast<size_t>(j)]);
      Eigen::MatrixX4d columns = Eigen::MatrixX4d::Ones(n, 4);
      columns.leftCols<3>() = points_.At(m).transpose();
      a = Vector3<double>(Eigen::Vector4d(columns.colPivHouseholderQr().solve(stated)).head<3>()).normalized();
      for (int axis = 0; axis < 3; ++axis) columns.col(axis) = points_.along[axis].transpose() * a;
      const Eigen::VectorXd of_marker = stated - points_.at_zero.transpose() * a;
      const Eigen::Vector4d solved = columns.colPivHouseholderQr().solve(of_marker);
      m = solved.head<3>();
      heights = points_.At(m).transpose() * a;
      const double rms = (columns * solved - of_marker).norm() / std::sqrt(static_cast<double>(n));
      if (rms < best.rms) best = {order, rms};
    }
    return best;
  }

  double Coordinate(int shot) const {
    return stated_.observations[of_marker_[static_cast<size_t>(shot)]].point_in_station[sorted_.axis];
  }

  // order[j]: the shot whose points the joint values of shot j have.
  std::vector<int> OrderOf(const Eigen::VectorXd& values) const {
    std::vector<int> sorted(static_cast<size_t>(values.size())), order(sorted.size());
    std::iota(sorted.begin(), sorted.end(), 0);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [&](int a, int b) { return sorted_.falls ? values[a] > values[b] : values[a] < values[b]; });
    for (size_t k = 0; k < sorted.size(); ++k) order[sorted[k]] = static_cast<int>(k);
    return order;
  }

  double Follow(std::vector<int> order) {
    double least = 1e300;
    int best = 0;  // round
    for (int round = 0; round < kMatched && round - best < kWithoutGain; ++round) {
      const double rms = Fit(order);
      if (rms < least) best = round;
      least = std::min(least, rms);
      if (least <= SuspiciousMisfit(problem_)) break;
      const Eigen::Matrix3Xd predicted = PredictPoints(problem_, places_, of_marker_);
      order = Nearest(predicted, OrderOf(predicted.row(sorted_.axis).transpose()));
    }
    return least;
  }

  // Places under that order, m RMS.
  double Fit(const std::vector<int>& order) {
    Measurements& data = *problem_.mutable_data();
    for (size_t j = 0; j < order.size(); ++j) {
      for (const auto& [marker, i] : sorted_.shots[j]) {
        const auto from = sorted_.shots[order[j]].find(marker);
        if (from != sorted_.shots[order[j]].end())
          data.observations[i].point_in_station = stated_.observations[from->second].point_in_station;
      }
    }
    places_ = problem_.parameters;
    return FindStartingValues(problem_, rows_, &places_, StartsTried::kFew);
  }

  // One to one, the nearest pairs first, among shots that stand near each other in the order.
  std::vector<int> Nearest(const Eigen::Matrix3Xd& predicted, const std::vector<int>& order) const {
    const int n = static_cast<int>(order.size()), window = std::max(5, n / 10);
    std::vector<std::tuple<double, int, int>> pairs;
    for (int j = 0; j < n; ++j) {
      for (int k = std::max(0, order[j] - window); k < std::min(n, order[j] + window + 1); ++k) {
        const Vector3<double>& point = stated_.observations[of_marker_[k]].point_in_station;
        pairs.emplace_back((predicted.col(j) - point).norm(), j, k);
      }
    }
    std::sort(pairs.begin(), pairs.end());
    std::vector<int> matched(n, -1);
    std::vector<bool> is_given(n, false);
    for (const auto& [distance, j, k] : pairs) {
      if (matched[j] >= 0 || is_given[k]) continue;
      matched[j] = k;
      is_given[k] = true;
    }
    int next = 0;  // those that no near point is left for
    for (int j = 0; j < n; ++j) {
      if (matched[j] >= 0) continue;
      while (is_given[next]) ++next;
      matched[j] = next;
      is_given[next] = true;
    }
    return matched;
  }

  const Measurements& stated_;
  CalibrationProblem problem_;  // with the points in another order
  const SortedShots& sorted_;
  std::vector<int> rows_, of_marker_;  // rows of all markers, and of the one that they are sorted by
  AffineInMarker points_;              // of that one, in the base
  ParameterSet places_;
};

}  // namespace

std::optional<Finding> FindSortedPoints(const CalibrationProblem& problem) {
  const std::optional<SortedShots> sorted = FindSortedShots(problem.data());
  if (!sorted) return std::nullopt;
  const double misfit = Matching(problem, *sorted).Best();
  if (misfit > SuspiciousMisfit(problem)) return std::nullopt;
  const Measurements& data = problem.data();
  return Found(Severity::kSerious, "row_order",
               PointsAreSorted(sorted->shots.size(), sorted->axis, sorted->falls, data.stations[sorted->station],
                               data.markers[sorted->marker], misfit));
}

}  // namespace sagitta
