#include "estimator/diagnosis/unstated_rows.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <set>

#include "estimator/report/diagnosis_caution_words.h"
#include "models/effects/effect.h"

namespace sagitta {
namespace {

// Of the shots that are read: without a quarter of them intervals are 15 % wider, 1 / sqrt(3/4), and without the column
// what it drives is not seen at all.
constexpr double kFewShots = 0.25;

std::vector<int> ReadShots(const Measurements& data) {
  std::set<int> shots;
  for (const Observation& row : data.observations) {
    if (!row.excluded) shots.insert(row.shot);
  }
  return {shots.begin(), shots.end()};
}

// What a shot leaves open is that of the nearest one that states all: it is left out, and no row depends on it.
void StateAsNearest(const std::vector<int>& complete, int s, std::vector<Shot>* shots) {
  const auto is_nearer = [s](int a, int b) { return std::abs(a - s) < std::abs(b - s); };
  const Shot& nearest = (*shots)[*std::min_element(complete.begin(), complete.end(), is_nearer)];
  Shot& shot = (*shots)[s];
  if (!shot.has_time) shot.has_time = nearest.has_time, shot.time = nearest.time;
  if (!shot.has_temperature) shot.has_temperature = nearest.has_temperature, shot.temperature = nearest.temperature;
  if (shot.approach.empty()) shot.approach = nearest.approach;
  for (size_t j = 0; j < nearest.approach.size(); ++j) {
    if (shot.approach[j] == kApproachNotStated) shot.approach[j] = nearest.approach[j];
  }
}

}  // namespace

std::vector<DrivingColumn> DrivingColumns(int joints) {
  std::vector<DrivingColumn> columns = {
      {"time_s", [](const ShotConditions& shot) { return shot.has_time; }},
      {"temperature_degC", [](const ShotConditions& shot) { return shot.has_temperature; }}};
  for (int j = 0; j < joints; ++j) {
    columns.push_back(
        {"approach" + std::to_string(j + 1), [j](const ShotConditions& shot) { return shot.StatesApproachOf(j); }});
  }
  return columns;
}

std::optional<CalibrationProblem> WithoutUnstatedRows(const CalibrationProblem& problem,
                                                      std::vector<std::string>* cautions) {
  const std::vector<int> read = ReadShots(problem.data());
  std::set<int> lacking;
  std::vector<std::string> columns;
  for (const DrivingColumn& column : DrivingColumns(problem.robot().num_joints())) {
    std::vector<int> own;
    for (const int s : read) {
      if (!column.is_stated(problem.shot_inputs()[s].conditions)) own.push_back(s);
    }
    if (own.empty() || static_cast<double>(own.size()) > kFewShots * static_cast<double>(read.size())) continue;
    lacking.insert(own.begin(), own.end());
    columns.push_back(column.name);
  }
  if (lacking.empty() || static_cast<double>(lacking.size()) > kFewShots * static_cast<double>(read.size())) return {};
  CalibrationProblem without = problem;
  Measurements& data = *without.mutable_data();
  for (Observation& row : data.observations) row.excluded = row.excluded || lacking.count(row.shot) > 0;
  std::vector<int> complete;
  std::copy_if(read.begin(), read.end(), std::back_inserter(complete), [&](int s) { return lacking.count(s) == 0; });
  for (const int s : lacking) StateAsNearest(complete, s, &data.shots);
  without.RenewShots();
  cautions->push_back(RowsThatStateLessAreLeftOut(lacking.size(), read.size(), columns));
  return without;
}

}  // namespace sagitta
