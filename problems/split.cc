#include "problems/split.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>

#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/ids_by_text.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr long kLargestNumber = 1000000000;  // that a name is continued after

std::string FirstFile(const Measurements& data) { return data.files.empty() ? "" : data.files.front().path; }

[[noreturn]] void RefuseSplit(const Measurements& data, const std::string& what, const std::string& hint = "") {
  throw InputError({FirstFile(data), 0, "validation"}, what, hint);
}

int CountHeldOut(const Measurements& data) {
  return static_cast<int>(std::count_if(data.configurations.begin(), data.configurations.end(),
                                        [](const Configuration& c) { return c.is_validation; }));
}

void RefuseEverything(const Measurements& data) {
  if (CountHeldOut(data) < static_cast<int>(data.configurations.size())) return;
  const bool alike = data.configurations.size() > 1 && GroupsOfEqualJointValues(data).size() == 1;
  RefuseSplit(
      data, "every configuration is held out, nothing is left to calibrate with",
      alike ? "all configurations are alike (equal joint values) and count as one: measure different ones" : "");
}

void RefuseNothing(const Measurements& data, const std::string& hint) {
  if (CountHeldOut(data) == 0) RefuseSplit(data, "no configuration is held out", hint);
}

// The observation's configuration is held out where the column has one of the
// values; all its rows have to agree.
void SplitByColumn(const std::string& column, const std::set<std::string>& values, Measurements* data) {
  std::set<std::string> absent = values;
  std::vector<const Observation*> first(data->configurations.size(), nullptr);
  std::vector<int> index;
  for (const MeasurementFile& file : data->files) index.push_back(file.FindColumn(column));
  for (const Observation& observation : data->observations) {
    if (observation.file < 0) continue;
    const MeasurementFile::Row row = data->files[observation.file].rows[observation.row];
    const int cell = index[observation.file];
    const std::string value(cell < 0 ? "" : row.cells[cell]);
    const bool held_out = cell >= 0 && values.count(value) > 0;
    if (held_out) absent.erase(value);
    const int c = data->shots[observation.shot].configuration;
    Configuration& configuration = data->configurations[c];
    if (first[c] == nullptr) {
      first[c] = &observation;
      configuration.is_validation = held_out;
    } else if (configuration.is_validation != held_out) {
      throw InputError({data->files[observation.file].path, row.line, column},
                       "configuration '" + configuration.id + "' is for calibration and for validation, see " +
                           data->SourceOf(*first[c]),
                       "one configuration is one or the other");
    }
  }
  if (absent.empty() || absent.size() == values.size()) return;  // all: nothing is held out, which is refused
  RefuseSplit(*data, "no row has '" + *absent.begin() + "' in the column '" + column + "'",
              "values are compared as text: 2.0 is not 2");
}

void RequireColumn(const std::string& column, const Measurements& data) {
  for (const MeasurementFile& file : data.files) {
    if (file.FindColumn(column) >= 0) continue;
    throw InputError({file.path, 0, column}, "the validation column '" + column + "' is not in this file",
                     SpellingHint(column, file.header));
  }
}

// Files without it are of calibration.
void RequireColumnAnywhere(const std::string& column, const Measurements& data) {
  const auto has_it = [&column](const MeasurementFile& file) { return file.FindColumn(column) >= 0; };
  if (std::none_of(data.files.begin(), data.files.end(), has_it)) RequireColumn(column, data);
}

// Hex SHA-256 of "<seed>:<config>".
std::string HashKey(unsigned long long seed, const std::string& id) { return Sha256(std::to_string(seed) + ":" + id); }

// Of each group's first configuration.
std::vector<std::string> HashKeys(const std::vector<std::vector<int>>& groups, unsigned long long seed,
                                  const Measurements& data) {
  std::vector<std::string> keys;
  for (const std::vector<int>& group : groups) {
    keys.push_back(HashKey(seed, data.configurations[group.front()].id));
  }
  return keys;
}

// Minus the time of each group's first shot, so that the last sort first.
std::vector<double> TimeKeys(const std::vector<std::vector<int>>& groups, const Measurements& data) {
  std::vector<double> time(data.configurations.size(), std::numeric_limits<double>::infinity());
  for (const Shot& shot : data.shots) {
    if (!shot.has_time) {
      RefuseSplit(data, "a split by time needs the time of every row", "column time_s; or validation by config");
    }
    time[shot.configuration] = std::min(time[shot.configuration], shot.time);
  }
  std::vector<double> keys;
  for (const std::vector<int>& group : groups) {
    double earliest = std::numeric_limits<double>::infinity();
    for (const int c : group) earliest = std::min(earliest, time[c]);
    keys.push_back(-earliest);
  }
  return keys;
}

// Of so many groups.
double NumberHeldOut(double fraction, size_t groups) { return std::ceil(fraction * static_cast<double>(groups)); }

// Of the numbers behind the stem in the names of configurations; 0: there is none.
long LargestNumber(const Measurements& data, const std::string& stem) {
  long largest = 0;
  for (const Configuration& configuration : data.configurations) {
    const std::string& id = configuration.id;
    if (id.compare(0, stem.size(), stem) != 0) continue;
    long number = 0;
    const char* end_of_id = id.data() + id.size();
    const auto [end, error] = std::from_chars(id.data() + stem.size(), end_of_id, number);
    if (error == std::errc() && end == end_of_id && number < kLargestNumber) largest = std::max(largest, number);
  }
  return largest;
}

// Marks the first ceil(fraction * n) groups in the order of their keys.
template <typename KeyType>
void HoldOutFirst(const std::vector<std::vector<int>>& groups, const std::vector<KeyType>& keys, double fraction,
                  Measurements* data) {
  std::vector<size_t> order(groups.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return keys[a] < keys[b]; });
  const double count = NumberHeldOut(fraction, groups.size());
  for (size_t i = 0; i < order.size() && static_cast<double>(i) < count; ++i) {
    for (const int c : groups[order[i]]) data->configurations[c].is_validation = true;
  }
}

void SplitByFraction(const ValidationSpec& spec, Measurements* data) {
  if (!(spec.fraction > 0.0 && spec.fraction < 1.0)) {
    RefuseSplit(*data, "the fraction held out has to be between 0 and 1, it is " + FormatNumber(spec.fraction));
  }
  const std::vector<std::vector<int>> groups = GroupsOfEqualJointValues(*data);
  if (spec.by_time) {
    HoldOutFirst(groups, TimeKeys(groups, *data), spec.fraction, data);
  } else {
    HoldOutFirst(groups, HashKeys(groups, spec.seed, *data), spec.fraction, data);
  }
}

std::uint64_t HashOf(const Eigen::VectorXd& q) {
  auto hash = static_cast<std::uint64_t>(q.size());
  for (const double value : q) hash = HashWith(value, hash);
  return hash;
}

}  // namespace

std::vector<int> GroupsOfConfigurations(const Measurements& data) {
  const size_t count = data.configurations.size();
  PlacesByHash firsts;  // the first configuration of each group
  firsts.Reserve(count);
  std::vector<int> group_of(count);
  int groups = 0;
  for (size_t c = 0; c < count; ++c) {
    const Eigen::VectorXd& q = data.configurations[c].q;
    const int first = firsts.FindOrPut(HashOf(q), static_cast<int>(c), [&](int other) {
      const Eigen::VectorXd& values = data.configurations[static_cast<size_t>(other)].q;
      return q.size() == values.size() && q == values;
    });
    group_of[c] = first == static_cast<int>(c) ? groups++ : group_of[static_cast<size_t>(first)];
  }
  return group_of;
}

std::vector<std::vector<int>> GroupsOfEqualJointValues(const Measurements& data) {
  std::vector<std::vector<int>> groups;
  const std::vector<int> group_of = GroupsOfConfigurations(data);
  for (size_t c = 0; c < group_of.size(); ++c) {
    if (static_cast<size_t>(group_of[c]) == groups.size()) groups.emplace_back();
    groups[static_cast<size_t>(group_of[c])].push_back(static_cast<int>(c));
  }
  return groups;
}

std::vector<std::string> NamesThatAreFitted(const ValidationSpec& spec, const Measurements& data,
                                            const std::string& stem, int count) {
  // With all of them measured this key of the others is the last that is held out: they have to come behind it.
  std::string last;
  if (spec.kind == ValidationSpec::Kind::kFraction && !spec.by_time && !data.configurations.empty()) {
    const std::vector<std::vector<int>> groups = GroupsOfEqualJointValues(data);
    std::vector<std::string> keys = HashKeys(groups, spec.seed, data);
    const double held_out = NumberHeldOut(spec.fraction, groups.size() + static_cast<size_t>(count));
    std::sort(keys.begin(), keys.end());
    last = keys[static_cast<size_t>(std::clamp(held_out, 1.0, static_cast<double>(keys.size()))) - 1];
  }
  std::vector<std::string> names;
  for (long number = LargestNumber(data, stem) + 1; names.size() < static_cast<size_t>(count); ++number) {
    const std::string name = stem + std::to_string(number);
    if (last.empty() || HashKey(spec.seed, name) > last) names.push_back(name);
  }
  return names;
}

void SplitConfigurations(const ValidationSpec& spec, Measurements* data) {
  for (Configuration& configuration : data->configurations) configuration.is_validation = false;
  switch (spec.kind) {
    case ValidationSpec::Kind::kNone:
      return;
    case ValidationSpec::Kind::kSetColumn:
      if (spec.needs_column) RequireColumnAnywhere("set", *data);
      SplitByColumn("set", {"validation"}, data);
      break;
    case ValidationSpec::Kind::kColumn:
      RequireColumn(spec.column, *data);
      data->unread_columns.erase(std::remove(data->unread_columns.begin(), data->unread_columns.end(), spec.column),
                                 data->unread_columns.end());
      SplitByColumn(spec.column, {spec.values.begin(), spec.values.end()}, data);
      RefuseNothing(*data, "no row has this value in column '" + spec.column + "'");
      break;
    case ValidationSpec::Kind::kFraction:
      SplitByFraction(spec, data);
      RefuseNothing(*data, "");
      break;
  }
  RefuseEverything(*data);
}

}  // namespace sagitta
