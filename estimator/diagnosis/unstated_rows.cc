#include "estimator/diagnosis/unstated_rows.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <map>
#include <set>

#include "estimator/report/diagnosis_caution_words.h"
#include "models/effects/effect.h"

namespace sagitta {
namespace {

// Of the shots that are read: without a quarter of them intervals are 15 % wider, 1 / sqrt(3/4), and without the column
// what it drives is not seen at all.
constexpr double kFewShots = 0.25;
// Of the shots of a station, a load, a marker or the hold-out: what these alone determine would have intervals wider by
// more than sqrt(2).
constexpr double kFewOfPart = 0.5;

// What a row is of: each of these has parameters or figures of its own.
std::vector<std::string> PartsOf(const Measurements& data, const Observation& row) {
  const Shot& shot = data.shots[row.shot];
  std::vector<std::string> parts = {"station " + data.stations[shot.station], "marker " + data.markers[row.marker],
                                    "load " + shot.load};
  if (data.configurations[shot.configuration].is_validation) parts.push_back("hold-out");
  return parts;
}

// The shots that are read, of all rows and of each part.
struct ReadShots {
  std::set<int> all;
  std::map<std::string, std::set<int>> of_part;

  explicit ReadShots(const Measurements& data) {
    for (const Observation& row : data.observations) {
      if (row.excluded) continue;
      all.insert(row.shot);
      for (const std::string& part : PartsOf(data, row)) of_part[part].insert(row.shot);
    }
  }

  // Whether enough is left of everything without them.
  bool AreFew(const std::set<int>& lacking) const {
    return !IsMoreThan(kFewShots, lacking, all) && std::none_of(of_part.begin(), of_part.end(), [&](const auto& part) {
      return IsMoreThan(kFewOfPart, lacking, part.second);
    });
  }

 private:
  static bool IsMoreThan(double share, const std::set<int>& lacking, const std::set<int>& shots) {
    const auto count = std::count_if(shots.begin(), shots.end(), [&](int s) { return lacking.count(s) > 0; });
    return static_cast<double>(count) > share * static_cast<double>(shots.size());
  }
};

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
  const ReadShots read(problem.data());
  std::set<int> lacking;
  std::vector<std::string> columns;
  for (const DrivingColumn& column : DrivingColumns(problem.robot().num_joints())) {
    std::set<int> own;
    for (const int s : read.all) {
      if (!column.is_stated(problem.shot_inputs()[s].conditions)) own.insert(s);
    }
    if (own.empty() || !read.AreFew(own)) continue;
    lacking.insert(own.begin(), own.end());
    columns.push_back(column.name);
  }
  if (lacking.empty() || !read.AreFew(lacking)) return {};
  CalibrationProblem without = problem;
  Measurements& data = *without.mutable_data();
  for (Observation& row : data.observations) row.excluded = row.excluded || lacking.count(row.shot) > 0;
  std::vector<int> complete;
  std::set_difference(read.all.begin(), read.all.end(), lacking.begin(), lacking.end(), std::back_inserter(complete));
  for (const int s : lacking) StateAsNearest(complete, s, &data.shots);
  without.RenewShots();
  cautions->push_back(RowsThatStateLessAreLeftOut(lacking.size(), read.all.size(), columns));
  return without;
}

}  // namespace sagitta
