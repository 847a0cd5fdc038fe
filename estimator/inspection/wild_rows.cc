#include "estimator/inspection/wild_rows.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "estimator/alignment/starting_values.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/least_squares/linearization.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

constexpr int kMostTrimmingSteps = 20;  // a guard: each lowers the sum of squares of the half
constexpr size_t kFewestRows = 3;       // rows of a marker at a station
constexpr size_t kMostShown = 1000;     // rows
// Random starts, for all rows together may lead to a half that fits and is not the robot's: a third of the rows are
// wrong and four of each of two groups are drawn: (2/3)^8 = 0.04, and one of 100 starts is free of wrong rows with
// probability 1 - 0.96^100 = 0.98.
constexpr int kRandomStarts = 100;
constexpr size_t kDrawn = 4;     // of each marker at each station: 12 numbers to nine unknowns
constexpr size_t kFollowed = 3;  // of the starts, the best ones: a choice of time
// The good half is looked for among so many rows of each marker at each station, and then followed on all: of 200 drawn
// rows a share of good ones stands within 7 percent of its own in 95 of 100 draws. Drawn and not every so many-th: rows
// that are wrong may come as regularly.
constexpr size_t kSearched = 200;

// Places in the list of points of every marker at every station.
std::map<std::pair<int, int>, std::vector<int>> RowsByMarkerAndStation(const CalibrationProblem& problem,
                                                                       const std::vector<int>& points) {
  std::map<std::pair<int, int>, std::vector<int>> groups;
  for (size_t k = 0; k < points.size(); ++k) {
    const Observation& row = problem.data().observations[points[k]];
    groups[{row.marker, problem.data().shots[row.shot].station}].push_back(static_cast<int>(k));
  }
  return groups;
}

// The nearer half of each group.
std::vector<int> NearerHalf(const CalibrationProblem& problem, const std::vector<int>& points,
                            const std::vector<double>& distances) {
  std::vector<int> half;
  for (auto& [key, own] : RowsByMarkerAndStation(problem, points)) {
    std::sort(own.begin(), own.end(),
              [&](int a, int b) { return std::make_pair(distances[a], a) < std::make_pair(distances[b], b); });
    const size_t count = std::min(own.size(), std::max(kFewestRows, (own.size() + 1) / 2));
    half.insert(half.end(), own.begin(), own.begin() + static_cast<std::ptrdiff_t>(count));
  }
  std::sort(half.begin(), half.end());
  return half;
}

double RmsOf(const std::vector<double>& distances, const std::vector<int>& places) {
  double sum = 0.0;
  for (const int k : places) sum += distances[k] * distances[k];
  return std::sqrt(sum / static_cast<double>(std::max<size_t>(1, places.size())));
}

struct Concentrated {
  ParameterSet parameters;
  std::vector<double> distances;  // of all points, m
  std::vector<int> half;          // places in the list of points
  double rms = 0.0;               // of the half, m
};

std::vector<int> RowsOf(const std::vector<int>& places, const std::vector<int>& points) {
  std::vector<int> rows;
  rows.reserve(places.size());
  for (const int k : places) rows.push_back(points[k]);
  return rows;
}

// Concentration steps from a fit to the listed rows.
Concentrated Concentrate(const CalibrationProblem& problem, const std::vector<int>& points, std::vector<int> listed,
                         int steps) {
  Concentrated found;
  for (int step = 0; step < steps; ++step) {
    found.parameters = problem.parameters;
    FindStartingValues(problem, listed, &found.parameters);
    found.distances = DistancesFromPoints(problem, points, found.parameters);
    const std::vector<int> next = NearerHalf(problem, points, found.distances);
    if (next == found.half) break;
    found.half = next;
    listed = RowsOf(found.half, points);
  }
  found.rms = RmsOf(found.distances, found.half);
  return found;
}

// `count` rows of every group, or all.
std::vector<int> Draw(const std::map<std::pair<int, int>, std::vector<int>>& groups, const std::vector<int>& points,
                      size_t count, std::mt19937_64* random) {
  std::vector<int> drawn;
  for (const auto& [key, own] : groups) {
    std::set<int> places;
    if (own.size() <= count) places.insert(own.begin(), own.end());
    while (places.size() < std::min(count, own.size())) places.insert(own[(*random)() % own.size()]);
    for (const int k : places) drawn.push_back(points[k]);
  }
  std::sort(drawn.begin(), drawn.end());
  return drawn;
}

// The best of many fits to few rows, the best of them followed to their end.
Concentrated FromRandomStarts(const CalibrationProblem& problem, const std::vector<int>& points, Concentrated best) {
  const auto groups = RowsByMarkerAndStation(problem, points);
  std::mt19937_64 random(1);
  std::vector<Concentrated> starts;
  for (int k = 0; k < kRandomStarts; ++k)
    starts.push_back(Concentrate(problem, points, Draw(groups, points, kDrawn, &random), 1));
  std::stable_sort(starts.begin(), starts.end(), [](const auto& a, const auto& b) { return a.rms < b.rms; });
  starts.resize(kFollowed);
  for (const Concentrated& start : starts) {
    Concentrated end = Concentrate(problem, points, RowsOf(start.half, points), kMostTrimmingSteps);
    if (end.rms < best.rms) best = std::move(end);
  }
  return best;
}

Concentrated BestHalf(const CalibrationProblem& problem, const std::vector<int>& points) {
  std::mt19937_64 random(2);
  const std::vector<int> searched = Draw(RowsByMarkerAndStation(problem, points), points, kSearched, &random);
  Concentrated best = FromRandomStarts(problem, searched, Concentrate(problem, searched, searched, kMostTrimmingSteps));
  if (searched.size() == points.size()) return best;
  return Concentrate(problem, points, RowsOf(best.half, searched), kMostTrimmingSteps);
}

Finding DescribeFarRows(const CalibrationProblem& problem, const FarRows& rows) {
  const size_t count = rows.far.size(), all = count + rows.near.size();
  const std::string first = problem.data().SourceOf(problem.data().observations[rows.far.front()]);
  Finding finding =
      Found(Severity::kSerious, "wild_rows", RowsAreWild(count, all, rows.far_median, rows.near_rms, first));
  for (size_t k = 0; k < std::min(kMostShown, count); ++k) {
    finding.rows.push_back(problem.data().SourceOf(problem.data().observations[rows.far[k]]));
  }
  return finding;
}

}  // namespace

std::set<int> MarkersOfRows(const Measurements& data, const std::vector<int>& rows) {
  std::set<int> markers;
  for (const int i : rows) markers.insert(data.observations[i].marker);
  return markers;
}

std::map<int, std::vector<int>> ByStation(const Measurements& data, const std::vector<int>& rows) {
  std::map<int, std::vector<int>> of_station;
  for (const int i : rows) of_station[data.shots[data.observations[i].shot].station].push_back(i);
  return of_station;
}

std::vector<double> DistancesFromPoints(const CalibrationProblem& problem, const std::vector<int>& points,
                                        const ParameterSet& parameters) {
  const Eigen::Matrix3Xd predicted = PredictPoints(problem, parameters, points);
  std::vector<double> distances;
  for (size_t k = 0; k < points.size(); ++k) {
    const double distance = (problem.data().observations[points[k]].point_in_station - predicted.col(k)).norm();
    distances.push_back(std::isfinite(distance) ? distance : 1e300);
  }
  return distances;
}

FarRows SplitByDistance(const std::vector<int>& rows, const std::vector<double>& distances, double limit,
                        ParameterSet parameters) {
  FarRows split;
  split.limit = limit;
  split.parameters = std::move(parameters);
  double squares = 0.0;
  for (size_t k = 0; k < rows.size(); ++k) {
    const bool is_far = distances[k] > limit;
    (is_far ? split.far : split.near).push_back(rows[k]);
    if (is_far) split.far_distances.push_back(distances[k]);
    if (!is_far) squares += distances[k] * distances[k];
  }
  split.near_rms = std::sqrt(squares / static_cast<double>(std::max<size_t>(1, split.near.size())));
  split.far_median = Median(split.far_distances);
  return split;
}

std::optional<FarRows> FindFarRows(const CalibrationProblem& problem) {
  const std::vector<int> points = problem.data().PointsAmong(problem.CalibrationObservations());
  if (points.empty()) return std::nullopt;
  const Concentrated best = BestHalf(problem, points);
  FarRows rows = SplitByDistance(points, best.distances, kNearHalf * best.rms, best.parameters);
  if (rows.far.empty() || rows.near.size() <= rows.far.size()) return std::nullopt;
  return rows;
}

FarRows OnlyThoseApart(FarRows rows) {
  std::vector<int> far;
  std::vector<double> distances;
  for (size_t k = 0; k < rows.far.size(); ++k) {
    const bool is_apart = rows.far_distances[k] > kFarApart * rows.near_rms;
    (is_apart ? far : rows.near).push_back(rows.far[k]);
    if (is_apart) distances.push_back(rows.far_distances[k]);
  }
  rows.far = far;
  rows.far_distances = distances;
  if (!far.empty()) rows.far_median = Median(distances);
  return rows;
}

bool AreApart(const FarRows& rows, const CalibrationProblem& problem) {
  return rows.near_rms <= SuspiciousMisfit(problem) && rows.far_median >= kFarApart * rows.near_rms;
}

std::optional<Finding> FindWildRows(const CalibrationProblem& problem, const FarRows& rows) {
  if (!AreApart(rows, problem)) return std::nullopt;
  return DescribeFarRows(problem, rows);
}

}  // namespace sagitta
