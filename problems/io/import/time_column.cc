#include "problems/io/import/time_column.h"

#include <array>
#include <set>

#include "problems/interruption.h"
#include "problems/io/pattern.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

// Days from 0000-03-01, in years that begin in March, less those to 1970-01-01.
int DaysSince1970(int year, int month, int day) {
  const int shifted_year = month > 2 ? year : year - 1, shifted_month = (month + 9) % 12;
  return 365 * shifted_year + shifted_year / 4 - shifted_year / 100 + shifted_year / 400 +
         (153 * shifted_month + 2) / 5 + day - 719469;
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

TimeColumn LookAtTime(const TextTable& table, int column) {
  TimeColumn time;
  std::set<std::string> different;
  bool numbers = true;
  time.stamps = true;
  for (const TextTable::Row& row : table.rows) {
    CheckInterruption();
    const std::string& cell = row.cells[static_cast<size_t>(column)];
    if (IsLostCell(cell)) continue;
    if (!different.insert(cell).second) continue;
    time.stamps = time.stamps && SecondsOfStamp(cell).has_value();
    numbers = numbers && table.Number(cell).has_value();
  }
  if (different.size() < 2) {
    time.why_not = "the time is the same in every row";
  } else if (!time.stamps && !numbers) {
    time.why_not = "the times are no seconds and no stamps like 2020-07-14 16:39:04 or 20200714163904";
  } else if (!time.stamps && 2 * different.size() < table.rows.size()) {
    time.why_not = "the times are rounded: " + std::to_string(different.size()) + " different ones in " +
                   std::to_string(table.rows.size()) + " rows";
  }
  return time;
}

}  // namespace sagitta
