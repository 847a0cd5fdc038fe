#include "problems/io/measurement_warnings.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "models/quantiles.h"
#include "problems/io/ids_by_text.h"
#include "problems/split.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr int kMany = 5;               // rows of one label: the file is no list of single points
constexpr double kByChance = 1e-3;     // that so many agree
constexpr double kLongPause = 3600.0;  // s: poses follow each other within minutes; nights are few
constexpr double kRareDrops = 0.05;    // of the shots: rows that are sorted by something else drop every other time
constexpr double kHottest = 45.0;      // degC: of halls and of arms where the coldest row is meant; 20 degC are 68 degF

// "s1" next to "S1": a slip of the hand makes another instrument of it, with a pose of its own.
void WarnOfLetterCase(const std::string& what, const std::vector<std::string>& labels, Measurements* data) {
  std::map<std::string, std::string> seen;  // by the label in small letters
  for (const std::string& label : labels) {
    std::string small = label;
    for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    const auto [entry, is_new] = seen.emplace(small, label);
    if (is_new) continue;
    data->warnings.push_back(what + " '" + entry->second + "' and '" + label +
                             "' differ in letter case alone and count as two: is it one?");
  }
}

// A label in one row alone, where others are in many: unknowns of its own absorb all that the row says.
template <typename LabelOf>
void WarnOfSingleRows(const std::string& what, const std::vector<std::string>& labels, const LabelOf& label_of,
                      Measurements* data) {
  std::vector<int> count(labels.size(), 0), first(labels.size(), -1);
  for (const Observation& row : data->observations) {
    if (!row.is_point()) continue;
    const int label = label_of(row);
    if (count[label]++ == 0) first[label] = static_cast<int>(&row - data->observations.data());
  }
  if (count.empty() || *std::max_element(count.begin(), count.end()) < kMany) return;
  for (size_t k = 0; k < labels.size(); ++k) {
    if (count[k] != 1) continue;
    data->warnings.push_back(what + " '" + labels[k] + "' is in one row alone (" +
                             data->SourceOf(data->observations[first[k]]) +
                             "), which by itself says nothing of the robot: is the label right?");
  }
}

// Pairs (row, the first one that it equals): of one marker and station, at the same joint values, all digits alike.
std::vector<std::pair<int, int>> EqualReadings(const Measurements& data) {
  const std::vector<int> group_of = GroupsOfConfigurations(data);
  const auto labels_of = [&](const Observation& row) {
    const Shot& shot = data.shots[row.shot];
    return std::make_tuple(group_of[shot.configuration], shot.station, row.marker);
  };
  std::vector<std::pair<int, int>> equal;
  PlacesByHash firsts;
  firsts.Reserve(data.observations.size());
  for (int i = 0; i < static_cast<int>(data.observations.size()); ++i) {
    const Observation& row = data.observations[i];
    if (!row.is_point() || !row.point_in_station.allFinite()) continue;  // a plan's row has no point yet
    std::uint64_t hash = static_cast<std::uint64_t>(std::get<0>(labels_of(row)));
    for (const double coordinate : row.point_in_station) hash = HashWith(coordinate, hash);
    const int first = firsts.FindOrPut(hash, i, [&](int other) {
      const Observation& earlier = data.observations[other];
      return earlier.point_in_station == row.point_in_station && labels_of(earlier) == labels_of(row);
    });
    if (first != i) equal.emplace_back(i, first);
  }
  return equal;
}

// Whether so many readings can agree by chance, as where a display has fewer digits than readings scatter by. With p,
// the probability that two readings agree along one axis, the mean number of such axes of pairs that do not agree along
// all three is m = 3 p (1 + p) / (1 + p + p^2). That c of n pairs agree has at most the probability exp(-c ln(c / n
// p^3) + c - n p^3) (Chernoff 1952).
bool AgreeByChance(const Measurements& data, size_t copies) {
  const std::vector<int> group_of = GroupsOfConfigurations(data);
  std::map<std::tuple<int, int, int, std::string>, std::vector<int>> repeats;
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& row = data.observations[i];
    const Shot& shot = data.shots[row.shot];
    if (row.is_point()) {
      repeats[{group_of[shot.configuration], shot.station, row.marker, shot.load}].push_back(static_cast<int>(i));
    }
  }
  double axes = 1.0, apart = 1.0, pairs = 0.0;  // one pair that agrees along one axis is assumed
  for (const auto& [where, rows] : repeats) {
    for (size_t k = 1; k < rows.size(); ++k) {
      const Vector3<double>& now = data.observations[rows[k]].point_in_station;
      const Vector3<double>& before = data.observations[rows[k - 1]].point_in_station;
      const auto alike = static_cast<double>((now.array() == before.array()).count());
      pairs += static_cast<double>(k);
      axes += alike < 3.0 ? alike : 0.0;
      apart += alike < 3.0 ? 1.0 : 0.0;
    }
  }
  const double m = axes / apart, p = 0.5 * (std::sqrt(1.0 + 4.0 * m / (3.0 - m)) - 1.0);
  const double expected = pairs * p * p * p, seen = static_cast<double>(copies);
  return seen <= expected || seen * std::log(seen / expected) - seen + expected < -std::log(kByChance);
}

void WarnOfCopies(Measurements* data) {
  const std::vector<std::pair<int, int>> equal = EqualReadings(*data);
  if (equal.size() < kFewestCopies || AgreeByChance(*data, equal.size())) return;
  const auto source = [data](int row) { return data->SourceOf(data->observations[row]); };
  data->warnings.push_back(std::to_string(equal.size()) +
                           " readings equal an earlier one of the same marker and joint values to the last digit (the "
                           "first: " +
                           source(equal[0].first) + ", that of " + source(equal[0].second) +
                           "): copies, or a display with fewer digits than readings scatter by. Leave copies out: each "
                           "counts as a reading of its own, and makes noise and intervals too small");
}

// Rows of one station and load in the order of the file whose time goes back now and then.
void WarnOfRestarts(Measurements* data) {
  size_t shots = 0, drops = 0;
  std::string first;
  for (size_t s = 1; s < data->shots.size(); ++s) {
    const Shot &before = data->shots[s - 1], &now = data->shots[s];
    if (!before.has_time || !now.has_time || before.station != now.station || before.load != now.load) continue;
    ++shots;
    if (now.time >= before.time) continue;
    if (drops++ > 0) continue;
    first = data->SourceOf(data->observations[now.observations.front()]) + ", from " + FormatNumber(before.time) +
            " to " + FormatNumber(now.time) + " s";
  }
  if (drops == 0 || static_cast<double>(drops) > kRareDrops * static_cast<double>(shots)) return;
  data->warnings.push_back("time_s goes back " + std::to_string(drops) + (drops == 1 ? " time" : " times") +
                           " in the order of the rows (the first: " + first +
                           "): is it one clock? Drifts, slips and warming up are looked for along it");
}

void WarnOfLongPauses(Measurements* data) {
  std::vector<double> times;
  for (const Shot& shot : data->shots) {
    if (shot.has_time) times.push_back(shot.time);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (times.size() < kMany) return;
  std::vector<double> pauses;
  for (size_t k = 1; k < times.size(); ++k) pauses.push_back(times[k] - times[k - 1]);
  const double usual = Median(std::move(pauses));
  if (usual < kLongPause) return;
  data->warnings.push_back("half of the shots follow the one before after " + Fixed(usual / 3600.0, 1) +
                           " hours or more: is time_s in seconds, not in milliseconds?");
}

void WarnOfHeat(Measurements* data) {
  bool any = false;
  double coldest = 0.0;
  for (const Shot& shot : data->shots) {
    if (!shot.has_temperature) continue;
    coldest = any ? std::min(coldest, shot.temperature) : shot.temperature;
    any = true;
  }
  if (!any || coldest < kHottest) return;
  data->warnings.push_back("no row is colder than " + FormatNumber(coldest) +
                           " degC: is temperature_degC in degrees Celsius, not in Fahrenheit or Kelvin?");
}

}  // namespace

void WarnOfRows(Measurements* data) {
  WarnOfLetterCase("stations", data->stations, data);
  WarnOfLetterCase("markers", data->markers, data);
  WarnOfSingleRows(
      "marker", data->markers, [](const Observation& row) { return row.marker; }, data);
  WarnOfSingleRows(
      "station", data->stations, [data](const Observation& row) { return data->shots[row.shot].station; }, data);
  WarnOfCopies(data);
  WarnOfRestarts(data);
  WarnOfLongPauses(data);
  WarnOfHeat(data);
}

}  // namespace sagitta
