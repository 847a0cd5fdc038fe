#include "estimator/noise/outliers.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "estimator/report/noise_words.h"
#include "estimator/statistics/distributions.h"
#include "models/constants.h"

namespace sagitta {
namespace {

constexpr double kExchanged = 0.2;          // distance left after exchanging two readings, over before: a fifth, as of
                                            // other readings (tried_readings.h)
constexpr double kMostOutlierShare = 0.25;  // of the points: more is no minority
constexpr int kFewestEvents = 3;            // events that can show a pattern: two may agree by chance

// Readings that are off together for a reason of the readings themselves count once.
std::vector<int> Events(const std::vector<Outlier>& outliers) {
  std::vector<int> events;
  for (const Outlier& outlier : outliers) {
    if (outlier.swapped_with < 0 || outlier.observation < outlier.swapped_with) events.push_back(outlier.observation);
  }
  return events;
}

// One category holds more of the events than its share of the rows explains.
void TestCategory(const std::string& what, const std::vector<int>& events, const std::vector<int>& all,
                  const std::function<std::string(int)>& key, double level, std::vector<std::string>* words) {
  std::map<std::string, int> rows, hits;
  for (const int i : all) ++rows[key(i)];
  for (const int i : events) ++hits[key(i)];
  if (rows.size() < 2) return;
  for (const auto& [name, count] : hits) {
    if (count < kFewestEvents) continue;
    const double share = rows[name] / static_cast<double>(all.size());
    const int n = static_cast<int>(events.size());
    if (BinomialSurvival(count, n, share) * static_cast<double>(rows.size()) >= level) continue;
    words->push_back(OutliersAreOf(count, n, what + " " + name, share));
  }
}

// Two-sample Kolmogorov-Smirnov on a number of every row; the range that holds the surplus.
void TestNumber(const std::string& what, const std::string& unit, double scale, const std::vector<int>& events,
                const std::vector<int>& all, const std::function<double(int)>& number, double level,
                std::vector<std::string>* words) {
  std::vector<double> rows, hits;
  for (const int i : all) rows.push_back(number(i));
  for (const int i : events) hits.push_back(number(i));
  std::sort(rows.begin(), rows.end());
  std::sort(hits.begin(), hits.end());
  if (rows.front() == rows.back() || static_cast<int>(hits.size()) < kFewestEvents) return;
  double distance = 0.0;
  for (const double x : rows) {
    const auto below = [x](const std::vector<double>& sorted) {
      return (std::upper_bound(sorted.begin(), sorted.end(), x) - sorted.begin()) / static_cast<double>(sorted.size());
    };
    distance = std::max(distance, std::abs(below(hits) - below(rows)));
  }
  const double n = static_cast<double>(hits.size()) * rows.size() / (hits.size() + rows.size());
  if (KolmogorovSurvival(distance, n) >= level) return;
  const size_t eighth = hits.size() / 8;
  words->push_back(OutliersLieAt(what, scale * hits[eighth], scale * hits[hits.size() - 1 - eighth], unit));
}

void MarkExchanges(const CalibrationProblem& problem, const ParameterSet& parameters, std::vector<Outlier>* outliers) {
  std::vector<int> rows;
  for (const Outlier& outlier : *outliers) rows.push_back(outlier.observation);
  std::sort(rows.begin(), rows.end());
  const Eigen::Matrix3Xd sorted = PredictPoints(problem, parameters, rows);
  const auto predicted = [&](int observation) -> Vector3<double> {
    return sorted.col(std::lower_bound(rows.begin(), rows.end(), observation) - rows.begin());
  };
  const std::vector<Observation>& all = problem.data().observations;
  for (Outlier& a : *outliers) {
    for (Outlier& b : *outliers) {
      if (a.size == 0.0 || b.size == 0.0) continue;
      if (a.observation >= b.observation || all[a.observation].shot != all[b.observation].shot) continue;
      const Vector3<double> pa = all[a.observation].point_in_station, pb = all[b.observation].point_in_station;
      const Vector3<double> ma = predicted(a.observation), mb = predicted(b.observation);
      const double before = std::hypot((pa - ma).norm(), (pb - mb).norm());
      const double after = std::hypot((pa - mb).norm(), (pb - ma).norm());
      if (after > kExchanged * before) continue;
      a.swapped_with = b.observation;
      b.swapped_with = a.observation;
    }
  }
}

// A row that reads a pose is one outlier, whichever of its readings is off.
Outlier& OutlierOfRow(const Measurements& data, int observation, std::vector<Outlier>* outliers) {
  const Observation& reading = data.observations[observation];
  const int row = reading.is_point() || reading.partner < 0 ? observation : reading.partner;
  const auto found = std::find_if(outliers->begin(), outliers->end(),
                                  [row](const Outlier& outlier) { return outlier.observation == row; });
  if (found != outliers->end()) return *found;
  outliers->emplace_back();
  outliers->back().observation = row;
  return outliers->back();
}

}  // namespace

std::vector<Outlier> FlagOutliers(const CalibrationProblem& problem, const PointCheck& check,
                                  const ParameterSet& parameters, double significance) {
  const double limit = ChiSquareLimitOfMany(static_cast<double>(check.observations.size()), significance, 3.0);
  std::vector<Outlier> outliers;
  for (size_t k = 0; k < check.observations.size(); ++k) {
    if (check.leave_one_out[k] <= limit) continue;
    const int i = check.observations[k];
    Outlier& outlier = OutlierOfRow(problem.data(), i, &outliers);
    (problem.data().observations[i].is_point() ? outlier.size : outlier.angle) = check.error.col(k).norm();
    outlier.whitened = std::max(outlier.whitened, std::sqrt(check.leave_one_out[k]));
  }
  MarkExchanges(problem, parameters, &outliers);
  std::stable_sort(outliers.begin(), outliers.end(),
                   [](const auto& a, const auto& b) { return a.whitened > b.whitened; });
  return outliers;
}

std::vector<std::string> WhatTheyShare(const CalibrationProblem& problem, const ParameterSet& parameters,
                                       const std::vector<Outlier>& outliers, double significance) {
  const Measurements& data = problem.data();
  const std::vector<int> all = problem.CalibrationObservations();
  const std::vector<int> events = Events(outliers);
  std::vector<std::string> words;
  if (static_cast<double>(events.size()) > kMostOutlierShare * static_cast<double>(all.size())) {
    words.push_back(AreNoMinority(events.size() / static_cast<double>(all.size())));
  }
  const auto shot_of = [&](int i) -> const Shot& { return data.shots[data.observations[i].shot]; };
  const int joints = problem.robot().num_joints();
  const double level = significance / (8 + joints);  // all tests together
  TestCategory(
      "configuration", events, all, [&](int i) { return data.configurations[shot_of(i).configuration].id; }, level,
      &words);
  TestCategory(
      "marker", events, all, [&](int i) { return data.markers[data.observations[i].marker]; }, level, &words);
  TestCategory(
      "load", events, all, [&](int i) { return shot_of(i).load; }, level, &words);
  TestCategory(
      "station", events, all, [&](int i) { return data.stations[shot_of(i).station]; }, level, &words);
  if (std::all_of(all.begin(), all.end(), [&](int i) { return shot_of(i).has_time; })) {
    TestNumber(
        "times", "s", 1.0, events, all, [&](int i) { return shot_of(i).time; }, level, &words);
  }
  for (int j = 0; j < joints; ++j) {
    const Joint& joint = problem.robot().chain.joints[j];
    const bool turns = joint.type != JointType::kPrismatic;
    TestNumber(
        "joint " + joint.name, turns ? "deg" : "mm", turns ? 1.0 / kDegree : 1e3, events, all,
        [&](int i) { return data.configurations[shot_of(i).configuration].q[j]; }, level, &words);
  }
  const auto in_base = [&](int i) -> Vector3<double> {
    const Pose<double> base = parameters.BaseInStation(shot_of(i).station);
    return base.rotation.transpose() * (data.observations[i].point_in_station - base.translation);
  };
  for (int axis = 0; axis < 3; ++axis) {
    TestNumber(
        std::string("base ") + "xyz"[axis], "mm", 1e3, events, all, [&](int i) { return in_base(i)[axis]; }, level,
        &words);
  }
  return words;
}

}  // namespace sagitta
