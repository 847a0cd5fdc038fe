#include "problems/io/import/other_columns.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "problems/input_error.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/joint_columns.h"
#include "problems/io/import/time_column.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// What a row states of load, time and temperature, and names.
class OtherColumns {
 public:
  OtherColumns(const TextTable& table, const std::vector<ColumnMeaning>& meanings, const std::set<int>& taken,
               ImportPlan* plan)
      : table_(table), meanings_(meanings), taken_(taken), plan_(*plan) {}

  void Add() {
    times_are_mapped_ = IsMapped("time");
    const bool is_of_two = !times_are_mapped_ && AddTimeOfTwoColumns();
    for (const int c : ByWords(Role::kTime)) {
      if (c != time_.first && c != time_.second) times_.push_back(c);
    }
    if (!is_of_two && !times_.empty()) time_column_ = times_[0];
    temperature_column_ = IsMapped("temperature") ? -1 : PlainestOf(Role::kTemperature, "temperature");
    for (int c = 0; c < table_.columns(); ++c) {
      if (taken_.count(c) == 0 && c != time_.first && c != time_.second) AddColumn(c);
    }
    for (const int c : times_) {
      if (!times_are_mapped_ && c != time_column_) plan_.other_times.push_back(TimeIn(c));
    }
  }

 private:
  bool IsMapped(const std::string& stem) const { return plan_.Find(stem) != nullptr; }
  std::string HeaderOf(int c) const { return HeaderOfColumn(table_, c); }
  void LeaveOut(int c, const std::string& why) { plan_.unused.emplace_back(HeaderOf(c), why); }

  std::vector<int> ColumnsOf(Role role) const {
    std::vector<int> columns;
    for (int c = 0; c < table_.columns(); ++c) {
      if (meanings_[static_cast<size_t>(c)].role == role && taken_.count(c) == 0) columns.push_back(c);
    }
    return columns;
  }

  // A date and a time of day, or seconds and nanoseconds; whether there are such.
  bool AddTimeOfTwoColumns() {
    const std::optional<ColumnsOfOneTime> found = FindColumnsOfOneTime(table_, ColumnsOf(Role::kTime));
    if (!found || taken_.count(found->first) + taken_.count(found->second) > 0) return false;
    time_ = *found;
    plan_.Add("time", "s", found->first, HeaderOf(found->first) + " + " + HeaderOf(found->second), "time");
    plan_.columns.back().second = found->second;
    return true;
  }

  PlannedColumn TimeIn(int c) const {
    ImportPlan plan;
    plan.Add("time", "s", c, HeaderOf(c), "time");
    return plan.columns[0];
  }

  // Columns that could be it, those with the fewest words first.
  std::vector<int> ByWords(Role role) const {
    std::vector<int> columns = ColumnsOf(role);
    const auto words = [this](int c) { return WordsOf(StemOf(HeaderOf(c))).size(); };
    std::stable_sort(columns.begin(), columns.end(), [&](int a, int b) { return words(a) < words(b); });
    return columns;
  }

  bool IsOtherTemperature(int c) const {
    const ColumnMeaning& meaning = meanings_[static_cast<size_t>(c)];
    return meaning.role == Role::kTemperature && !meaning.unit.empty() && meaning.unit != "degC";
  }

  // The first of them that can be used; -1: none.
  int PlainestOf(Role role, const std::string& what) {
    std::vector<int> columns = ByWords(role);
    columns.erase(std::remove_if(columns.begin(), columns.end(), [this](int c) { return IsOtherTemperature(c); }),
                  columns.end());
    for (size_t k = 1; k < columns.size(); ++k) {
      plan_.guesses.push_back("'" + HeaderOf(columns[0]) + "' is the " + what + ", not '" + HeaderOf(columns[k]) + "'");
    }
    return columns.empty() ? -1 : columns[0];
  }

  // The name of the column in measurements.csv; "": it has none for it.
  static std::string StemFor(const ColumnMeaning& meaning) {
    if (meaning.role == Role::kText) return meaning.name;
    if (meaning.role == Role::kWrench && meaning.unit == (meaning.index < 3 ? "N" : "Nm")) {
      return WrenchNames()[static_cast<size_t>(meaning.index)];
    }
    if (meaning.role == Role::kApproach) return "approach" + std::to_string(meaning.index + 1);
    if (meaning.role == Role::kTemperature) return "temperature";
    return "";
  }

  void AddColumn(int c) {
    const ColumnMeaning& meaning = meanings_[static_cast<size_t>(c)];
    if (IsOtherTemperature(c)) return LeaveOut(c, "a temperature that is not in degC");
    // Which of several can be used DecideTimes finds out.
    if (meaning.role == Role::kTime && c == time_column_) return plan_.columns.push_back(TimeIn(c));
    if (meaning.role == Role::kTime && !times_are_mapped_) return;
    if (meaning.role == Role::kTime || (meaning.role == Role::kTemperature && c != temperature_column_))
      return LeaveOut(c, "another column says it");
    if (meaning.role == Role::kTorque) return LeaveOut(c, "torques in N m of all joints are used, or none");
    const std::string stem = StemFor(meaning);
    if (stem.empty()) {
      bool moved = false;
      LeaveOut(c, WhyNotUsed(table_, c, meaning, &moved));
      if (moved) plan_.moved_axes.push_back(HeaderOf(c));
      return;
    }
    if (IsMapped(stem)) return LeaveOut(c, meaning.why.empty() ? "stands twice" : meaning.why);
    std::string unit = meaning.unit;
    if (meaning.role == Role::kText || meaning.role == Role::kApproach) unit = "";
    if (meaning.role == Role::kTemperature) {
      if (unit.empty()) plan_.guesses.push_back("'" + HeaderOf(c) + "' is in degC: the header does not say");
      unit = "degC";
    }
    plan_.Add(stem, unit, c, HeaderOf(c), stem);
    if (stem == "load") AddLoad(meaning.unit, c);
  }

  // The unit is that of the masses by which loads are called; 0 is no load then.
  void AddLoad(const std::string& unit, int c) {
    plan_.columns.back().text_unit = unit;
    const bool has_zero = std::any_of(table_.rows.begin(), table_.rows.end(), [&](const TextTable::Row& row) {
      return table_.Number(row.cells[static_cast<size_t>(c)]) == 0.0;
    });
    if (!unit.empty() || !has_zero) return;
    plan_.guesses.push_back("'" + HeaderOf(c) +
                            "' is 0 where there is no load: the header does not say what it counts");
  }

  const TextTable& table_;
  const std::vector<ColumnMeaning>& meanings_;
  const std::set<int>& taken_;
  ImportPlan& plan_;
  ColumnsOfOneTime time_;
  std::vector<int> times_;  // that stand alone, in the order in which they are tried
  bool times_are_mapped_ = false;
  int time_column_ = -1, temperature_column_ = -1;
};

}  // namespace

std::string HeaderOfColumn(const TextTable& table, int column) {
  const std::string& header = table.header[static_cast<size_t>(column)];
  return header.empty() ? "column " + std::to_string(column + 1) : header;
}

void AddOtherColumns(const TextTable& table, const std::vector<ColumnMeaning>& meanings, const std::set<int>& taken,
                     ImportPlan* plan) {
  OtherColumns(table, meanings, taken, plan).Add();
}

void AddColumnsNotJoined(const TextTable& table, ImportPlan* plan) {
  for (const TextTable::NotJoined& column : table.not_joined) {
    plan->unused.emplace_back(column.header, column.why);
    if (column.moved) plan->moved_axes.push_back(column.header);
  }
}

std::string WhyNotUsed(const TextTable& table, int column, const ColumnMeaning& meaning, bool* moved) {
  const bool is_axis = meaning.role == Role::kOther && NamesExternalAxis(HeaderOfColumn(table, column));
  if (!is_axis) return meaning.why.empty() ? "not complete, or in no unit of it" : meaning.why;
  std::optional<double> least, most;
  for (const TextTable::Row& row : table.rows) {
    const std::optional<double> number = table.Number(row.cells[static_cast<size_t>(column)]);
    if (!number || *number == kLostReading) continue;
    least = std::min(least.value_or(*number), *number), most = std::max(most.value_or(*number), *number);
  }
  const std::string words = "an axis that this robot has not";
  *moved = least && *least < *most;
  if (!least) return words;
  return words + (*moved ? ", from " + FormatNumber(*least) + " to " + FormatNumber(*most)
                         : ", always at " + FormatNumber(*least));
}

std::string HintOfSphericalReadings(const std::vector<std::string>& headers) {
  static const std::set<std::string> kKinds[] = {{"az", "azimuth", "azimut", "hz"},
                                                 {"ze", "zenith", "zenit", "v", "el", "elevation"},
                                                 {"range", "distance", "dist", "d", "distanz", "sd"}};
  for (const std::set<std::string>& kind : kKinds) {
    const auto is_of_kind = [&kind](const std::string& header) {
      const std::vector<std::string> words = WordsOf(StemOf(header));
      return !words.empty() && kind.count(words[0]) > 0;
    };
    if (std::none_of(headers.begin(), headers.end(), is_of_kind)) return "";
  }
  return "azimuth, zenith angle and distance are not read: export x, y, z, or convert them, x = d sin(zenith) "
         "cos(azimuth), y = d sin(zenith) sin(azimuth), z = d cos(zenith), with the instrument's sense of the azimuth";
}

void RefusePulses(const TextTable& table, const ImportPlan& plan, const std::vector<Joint>& joints) {
  constexpr double kMostDegrees = 3600.0;
  const PlannedColumn* largest = nullptr;
  double most = kMostDegrees;
  for (size_t j = 0; j < joints.size(); ++j) {
    const PlannedColumn& column = *plan.Find("q" + std::to_string(j + 1));
    if (joints[j].type != JointType::kRevolute || column.second >= 0) continue;
    for (const TextTable::Row& row : table.rows) {
      const std::optional<double> number = table.Number(row.cells[static_cast<size_t>(column.source)]);
      if (!number || *number == kLostReading) continue;
      if (*number != std::round(*number)) return;
      if (std::abs(*number) > most) most = std::abs(*number), largest = &column;
    }
  }
  if (largest == nullptr) return;
  throw InputError({table.path, table.header_line, largest->header},
                   "joint values are whole numbers up to " + FormatNumber(most) + ": pulses of encoders, no angles",
                   "convert them to degrees by the pulses per degree of each axis, or export joint values in degrees");
}

}  // namespace sagitta
