#include "problems/io/import/time_column.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

#include "problems/interruption.h"
#include "problems/io/import/header_words.h"
#include "problems/io/pattern.h"
#include "problems/io/units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Days from 0000-03-01, in years that begin in March, less those to 1970-01-01.
int DaysSince1970(int year, int month, int day) {
  const int shifted_year = month > 2 ? year : year - 1, shifted_month = (month + 9) % 12;
  return 365 * shifted_year + shifted_year / 4 - shifted_year / 100 + shifted_year / 400 +
         (153 * shifted_month + 2) / 5 + day - 719469;
}

// s, of what a header calls the unit of a time.
std::optional<double> SecondsOfUnit(const std::string& word) {
  static const std::map<std::string, double> kUnits = {
      {"s", 1.0},     {"sec", 1.0},      {"seconds", 1.0}, {"ms", 1e-3},     {"msec", 1e-3},    {"us", 1e-6},
      {"µs", 1e-6},   {"usec", 1e-6},    {"ns", 1e-9},     {"min", 60.0},    {"minutes", 60.0}, {"h", 3600.0},
      {"hr", 3600.0}, {"hours", 3600.0}, {"d", 86400.0},   {"days", 86400.0}};
  const auto found = kUnits.find(word);
  return found == kUnits.end() ? std::nullopt : std::optional<double>(found->second);
}

// ms, us or ns since 1970, by which all times are of this century; "" where none is. In s a number is one anyway.
std::string UnitSince1970(double first, double last) {
  constexpr double kFrom = 946684800.0, kTo = 4102444800.0;  // 2000 and 2100
  for (const char* unit : {"ms", "us", "ns"}) {
    const double seconds = *SecondsOfUnit(unit);
    if (first * seconds >= kFrom && last * seconds <= kTo) return unit;
  }
  return "";
}

// What stands in brackets at the end, or is a unit behind the last bar or blank; "" where there is none.
std::string WrittenUnit(const std::string& header) {
  static const std::regex bracketed = MakePattern("[\\[(]\\s*([^\\])]*?)\\s*[\\])]\\s*$");
  const std::string lower = LowerCaseOf(header);
  std::smatch match;
  if (SearchPattern(lower, &match, bracketed)) return match.str(1);
  const size_t at = lower.find_last_of("_ ");
  const std::string last = at == std::string::npos ? "" : lower.substr(at + 1);
  return SecondsOfUnit(last) || IsUnit(last) ? last : "";
}

}  // namespace

std::optional<double> SecondsOfStamp(const std::string& cell) {
  static const std::regex year_first = MakePattern(
      "^(\\d{4})([-/.]?)(\\d{2})\\2(\\d{2})(?:[T ]+|)(\\d{2})(:?)(\\d{2})\\6(\\d{2})(?:[.,](\\d{1,9}))?Z?$");
  static const std::regex day_first =
      MakePattern("^(\\d{1,2})\\.(\\d{1,2})\\.(\\d{4})[T ]+(\\d{1,2}):(\\d{2}):(\\d{2})(?:[.,](\\d{1,9}))?$");
  constexpr size_t kLongest = 32;  // of what is matched at all
  std::smatch match;
  if (cell.size() > kLongest) return std::nullopt;
  std::array<int, 6> places = {1, 3, 4, 5, 7, 8};
  int fraction = 9;
  if (!SearchPattern(cell, &match, year_first)) {
    if (!SearchPattern(cell, &match, day_first)) return std::nullopt;
    places = {3, 2, 1, 4, 5, 6};
    fraction = 7;
  }
  std::array<int, 6> n{};
  for (size_t i = 0; i < n.size(); ++i) n[i] = std::stoi(match[static_cast<size_t>(places[i])]);
  const auto [year, month, day, hour, minute, second] = n;
  if (year < 1980 || year > 2100 || month < 1 || month > 12 || day < 1 || day > 31) return std::nullopt;
  if (hour > 23 || minute > 59 || second > 60) return std::nullopt;
  const auto& digits = match[static_cast<size_t>(fraction)];
  const double part = digits.matched ? ParseNumber("0." + digits.str()).value_or(0.0) : 0.0;
  return 86400.0 * DaysSince1970(year, month, day) + 3600.0 * hour + 60.0 * minute + second + part;
}

size_t CountShots(const TextTable& table, const ImportPlan& plan) {
  std::string before;
  size_t shots = 0;
  for (const TextTable::Row& row : table.rows) {
    std::string shot;
    for (const PlannedColumn& column : plan.columns) {
      const bool is_joint = column.stem[0] == 'q' && column.stem != "q";
      if (is_joint || column.stem == "config" || column.stem == "station" || column.stem == "visit")
        shot += PartOfName(row.cells[static_cast<size_t>(column.source)], column.part) + ";";
    }
    shots += shots == 0 || shot != before;
    before = std::move(shot);
  }
  return shots;
}

void DecideTimes(const TextTable& table, std::vector<ImportPlan>* plans) {
  for (ImportPlan& plan : *plans) {
    const auto is_time = [](const PlannedColumn& column) { return column.stem == "time"; };
    const auto column = std::find_if(plan.columns.begin(), plan.columns.end(), is_time);
    if (column == plan.columns.end()) continue;
    const TimeColumn time = LookAtTime(table, column->source, CountShots(table, plan));
    if (!time.why_not.empty()) {
      plan.unused.emplace_back(column->header, time.why_not);
      plan.columns.erase(column);
    } else if (time.since_1970) {
      plan.guesses.push_back("'" + column->header + "' is in " + time.unit +
                             " since 1970, by its size: the header does not say");
    } else if (!time.stamps && !time.seconds_per_unit) {
      plan.guesses.push_back("'" + column->header + "' is in s: the header does not say");
    }
  }
}

TimeColumn LookAtTime(const TextTable& table, int column, size_t shots) {
  TimeColumn time;
  std::set<std::string> different;
  bool numbers = true;
  double first = std::numeric_limits<double>::infinity(), last = 0.0;
  time.stamps = true;
  for (const TextTable::Row& row : table.rows) {
    CheckInterruption();
    const std::string& cell = row.cells[static_cast<size_t>(column)];
    if (IsLostCell(cell)) continue;
    if (!different.insert(cell).second) continue;
    time.stamps = time.stamps && SecondsOfStamp(cell).has_value();
    const std::optional<double> number = table.Number(cell);
    numbers = numbers && number;
    first = std::min(first, number.value_or(0.0)), last = std::max(last, number.value_or(0.0));
  }
  if (different.size() < 2) {
    time.why_not = "the time is the same in every row";
  } else if (!time.stamps && !numbers) {
    time.why_not = "the times are no seconds and no stamps like 2020-07-14 16:39:04 or 20200714163904";
  } else if (!time.stamps && 2 * different.size() < shots) {
    time.why_not = "the times are rounded: " + std::to_string(different.size()) + " different ones of " +
                   std::to_string(shots) + " shots";
  }
  std::string unit = table.has_header() ? WrittenUnit(table.header[static_cast<size_t>(column)]) : "";
  if (unit.empty() && numbers && !time.stamps) {
    unit = UnitSince1970(first, last);
    time.since_1970 = !unit.empty();
  }
  time.seconds_per_unit = SecondsOfUnit(unit);
  time.unit = time.seconds_per_unit && !time.stamps ? unit : "s";
  if (time.why_not.empty() && !time.stamps && !unit.empty() && !time.seconds_per_unit)
    time.why_not = "'" + unit + "' is no unit that time is read in: s, ms, us, ns, min, h or days";
  return time;
}

}  // namespace sagitta
