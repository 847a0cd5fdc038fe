#include "problems/io/import/time_column.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "models/quantiles.h"
#include "problems/interruption.h"
#include "problems/io/import/header_words.h"
#include "problems/io/pattern.h"
#include "problems/io/units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kFrom2000 = 946684800.0, kTo2100 = 4102444800.0;  // s since 1970: of this century

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
  for (const char* unit : {"ms", "us", "ns"}) {
    const double seconds = *SecondsOfUnit(unit);
    if (first * seconds >= kFrom2000 && last * seconds <= kTo2100) return unit;
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

// Whole numbers in a row that are dates like 20240305.
bool AreDates(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double number) {
    const double month = std::fmod(std::floor(number / 100.0), 100.0), day = std::fmod(number, 100.0);
    const bool is_year = number >= 19800101.0 && number <= 21001231.0;
    return number == std::round(number) && is_year && month >= 1.0 && month <= 12.0 && day >= 1.0 && day <= 31.0;
  });
}

// Times of day like 220501, 22:05:01. Of numbers that count something else the last two and the two before are below 60
// in a third of all: of eight hardly ever, and of four that all have an hour in front, as no seconds from a start have.
bool AreTimesOfDay(const std::vector<double>& numbers) {
  constexpr size_t kFewest = 8, kFewestWithHours = 4, kFewestMinutes = 4;
  if (numbers.size() < kFewestWithHours) return false;
  const auto [least, most] = std::minmax_element(numbers.begin(), numbers.end());
  if ((numbers.size() < kFewest ? *least : *most) < 10000.0) return false;
  std::set<double> minutes;
  for (const double number : numbers) minutes.insert(std::floor(number / 100.0));
  if (minutes.size() < kFewestMinutes) return false;  // seconds of less than a few minutes
  const auto is_hundred = [](double number) { return std::fmod(number, 100.0) == 0.0; };
  if (std::all_of(numbers.begin(), numbers.end(), is_hundred)) return false;  // a step, rather
  return std::all_of(numbers.begin(), numbers.end(), [](double number) {
    const double second = std::fmod(number, 100.0), minute = std::fmod(std::floor(number / 100.0), 100.0);
    return number >= 0.0 && number < 240000.0 && minute < 60.0 && second < 60.0;
  });
}

// Days since 1900, as spreadsheets count them, of this century.
bool AreDaysSince1900(const std::vector<double>& numbers) {
  constexpr double kFrom = 36526.0, kTo = 73051.0;  // 2000 and 2100
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return number >= kFrom && number <= kTo; });
}

// The same where no header says so: as seconds, half of the shots follow each other in less than a tenth of one, faster
// than any arm goes from pose to pose. Pauses, nights among them, count as one gap each.
bool AreDays(const std::vector<double>& numbers, std::vector<double> shots) {
  std::sort(shots.begin(), shots.end());
  shots.erase(std::unique(shots.begin(), shots.end()), shots.end());
  std::vector<double> gaps;
  for (size_t i = 1; i < shots.size(); ++i) gaps.push_back(shots[i] - shots[i - 1]);
  return !gaps.empty() && AreDaysSince1900(numbers) && Median(std::move(gaps)) < 0.1;
}

// Of numbers that the header gives no unit: why they are no seconds; "" where they may be.
std::string WhyNoSeconds(const std::vector<double>& numbers) {
  if (AreDates(numbers)) return "the numbers are dates like 20240305, and no column has the time of day";
  if (AreTimesOfDay(numbers))
    return "the numbers are times of day like 220501 for 22:05:01, and no column has the date";
  const bool are_parts = std::all_of(numbers.begin(), numbers.end(), [](double n) { return n >= 0.0 && n < 1.0; });
  if (are_parts) return "as seconds all lie within one: parts of a day, or in a unit that 'Time [min]' would state";
  return "";
}

// What the cells of a date and of a time of day state together; zeros that a number lost in front are put back.
std::string StampOfTwo(const std::string& date, std::string time) {
  const size_t digits = std::min(time.find_first_not_of("0123456789"), time.size());
  const bool is_number = digits == time.size() || time[digits] == '.' || time[digits] == ',';
  if (is_number && digits < 6) time.insert(0, 6 - digits, '0');
  if (!is_number && digits == 1) time.insert(0, 1, '0');
  return date + " " + time;
}

std::string CellOfTime(const TextTable::Row& row, int column, int second) {
  const std::string& cell = row.cells[static_cast<size_t>(column)];
  if (second < 0 || IsLostCell(cell)) return cell;
  const std::string& other = row.cells[static_cast<size_t>(second)];
  return IsLostCell(other) ? other : StampOfTwo(cell, other);
}

// Whether two columns are a date and a time of day. Numbers like 91501 state one only where most have an hour, with all
// its digits or with the zero in front lost: 100 and 200 are no minutes, nor is what the header calls seconds.
bool AreDateAndTimeOfDay(const TextTable& table, int date, int time) {
  size_t numbers = 0, with_hours = 0;
  for (const TextTable::Row& row : table.rows) {
    const std::string cell = CellOfTime(row, date, time);
    if (IsLostCell(cell)) continue;
    if (!SecondsOfStamp(cell)) return false;
    const std::string& of_day = row.cells[static_cast<size_t>(time)];
    const size_t digits = std::min(of_day.find_first_not_of("0123456789"), of_day.size());
    if (digits < of_day.size() && of_day[digits] == ':') continue;
    ++numbers;
    with_hours += digits >= 5;
  }
  return numbers == 0 || (2 * with_hours >= numbers && !SecondsOfHeader(table.header[static_cast<size_t>(time)]));
}

// Words of "header.stamp.sec" without the last where that is one of these; empty where it is not.
std::optional<std::vector<std::string>> WordsBefore(const std::string& header, const std::set<std::string>& last) {
  std::vector<std::string> words = WordsOf(header);
  if (words.empty() || last.count(words.back()) == 0) return std::nullopt;
  words.pop_back();
  return words;
}

const std::set<std::string>& WordsForNanoseconds() {
  static const std::set<std::string> kNanoseconds = {"nsec", "nsecs", "nanosec", "nanosecs", "nanoseconds"};
  return kNanoseconds;
}

bool HasNanoseconds(const TextTable& table, int column) {
  return column >= 0 && WordsBefore(table.header[static_cast<size_t>(column)], WordsForNanoseconds()).has_value();
}

}  // namespace

std::optional<ColumnsOfOneTime> FindColumnsOfOneTime(const TextTable& table, const std::vector<int>& times) {
  static const std::set<std::string> kSeconds = {"sec", "secs", "seconds"};
  for (int a = 0; a < table.columns(); ++a) {
    const auto before = WordsBefore(table.header[static_cast<size_t>(a)], kSeconds);
    for (int b = 0; before && b < table.columns(); ++b) {
      if (WordsBefore(table.header[static_cast<size_t>(b)], WordsForNanoseconds()) == before)
        return ColumnsOfOneTime{a, b};
    }
  }
  for (const int a : times) {
    for (const int b : times) {
      if (a != b && AreDateAndTimeOfDay(table, a, b)) return ColumnsOfOneTime{a, b};
    }
  }
  return std::nullopt;
}

std::optional<double> SecondsOfRow(const TextTable& table, const TextTable::Row& row, const PlannedColumn& column,
                                   const TimeColumn& time) {
  const std::string& first = row.cells[static_cast<size_t>(column.source)];
  if (time.adds_nanoseconds) {
    const std::optional<double> seconds = table.Number(first);
    const std::optional<double> rest = table.Number(row.cells[static_cast<size_t>(column.second)]);
    return seconds && rest ? std::optional<double>(*seconds + 1e-9 * *rest) : std::nullopt;
  }
  const std::string cell = CellOfTime(row, column.source, column.second);
  if (IsLostCell(cell)) return std::nullopt;
  if (time.stamps) return SecondsOfStamp(cell);
  const std::optional<double> number = table.Number(cell);
  return number ? std::optional<double>(time.seconds_per_unit.value_or(1.0) * *number) : std::nullopt;
}

std::optional<double> SecondsOfStamp(const std::string& cell) {
  static const std::regex year_first = MakePattern(
      "^(\\d{4})([-/.]?)(\\d{2})\\2(\\d{2})(?:[T "
      "]+|)(\\d{2})(:?)(\\d{2})\\6(\\d{2})(?:[.,](\\d{1,9}))?(?:Z|([+-])(\\d{2}):?(\\d{2}))?$");
  static const std::regex day_first =
      MakePattern("^(\\d{1,2})\\.(\\d{1,2})\\.(\\d{4})[T ]+(\\d{1,2}):(\\d{2}):(\\d{2})(?:[.,](\\d{1,9}))?$");
  constexpr size_t kLongest = 40;  // of what is matched at all
  std::smatch match;
  if (cell.size() > kLongest) return std::nullopt;
  std::array<int, 6> places = {1, 3, 4, 5, 7, 8};
  int fraction = 9;
  double offset = 0.0;  // s, from UTC
  if (!SearchPattern(cell, &match, year_first)) {
    if (!SearchPattern(cell, &match, day_first)) return std::nullopt;
    places = {3, 2, 1, 4, 5, 6};
    fraction = 7;
  } else if (match[10].matched) {
    const bool is_west = match.str(10).front() == '-';
    offset = (is_west ? -60.0 : 60.0) * (60.0 * std::stoi(match[11]) + std::stoi(match[12]));
  }
  std::array<int, 6> n{};
  for (size_t i = 0; i < n.size(); ++i) n[i] = std::stoi(match[static_cast<size_t>(places[i])]);
  const auto [year, month, day, hour, minute, second] = n;
  if (year < 1980 || year > 2100 || month < 1 || month > 12 || day < 1 || day > 31) return std::nullopt;
  if (hour > 23 || minute > 59 || second > 60) return std::nullopt;
  const auto& digits = match[static_cast<size_t>(fraction)];
  const double part = digits.matched ? ParseNumber("0." + digits.str()).value_or(0.0) : 0.0;
  return 86400.0 * DaysSince1970(year, month, day) + 3600.0 * hour + 60.0 * minute + second + part - offset;
}

std::optional<double> SecondsOfHeader(const std::string& header) { return SecondsOfUnit(WrittenUnit(header)); }

std::vector<size_t> FirstRowsOfShots(const TextTable& table, const ImportPlan& plan) {
  std::string before;
  std::vector<size_t> shots;
  for (size_t r = 0; r < table.rows.size(); ++r) {
    const TextTable::Row& row = table.rows[r];
    std::string shot;
    for (const PlannedColumn& column : plan.columns) {
      const bool is_joint = column.stem[0] == 'q' && column.stem != "q";
      if (is_joint || column.stem == "config" || column.stem == "station" || column.stem == "visit")
        shot += PartOfName(row.cells[static_cast<size_t>(column.source)], column.part) + ";";
    }
    if (shots.empty() || shot != before) shots.push_back(r);
    before = std::move(shot);
  }
  return shots;
}

namespace {

void GuessUnit(const PlannedColumn& column, const TimeColumn& time, ImportPlan* plan) {
  if (time.since_1970) {
    plan->guesses.push_back("'" + column.header + "' is in " + time.unit +
                            " since 1970, by its size: the header does not say");
  } else if (time.counts_days) {
    plan->guesses.push_back("'" + column.header +
                            "' is in days, as spreadsheets count them: as seconds the readings "
                            "would follow each other in less than a tenth of one");
  } else if (!time.stamps && !time.seconds_per_unit) {
    plan->guesses.push_back("'" + column.header + "' is in s: the header does not say");
  }
}

}  // namespace

void DecideTimes(const TextTable& table, std::vector<ImportPlan>* plans) {
  for (ImportPlan& plan : *plans) {
    const auto is_time = [](const PlannedColumn& column) { return column.stem == "time"; };
    const auto column = std::find_if(plan.columns.begin(), plan.columns.end(), is_time);
    if (column == plan.columns.end() || column->is_mapped) continue;
    const std::vector<size_t> shots = FirstRowsOfShots(table, plan);
    std::vector<PlannedColumn> columns = {*column};
    columns.insert(columns.end(), plan.other_times.begin(), plan.other_times.end());
    std::optional<size_t> used;
    for (size_t k = 0; k < columns.size(); ++k) {
      const TimeColumn time = LookAtTime(table, columns[k], shots);
      columns[k].unit = time.unit;
      if (!time.why_not.empty() || used) {
        plan.unused.emplace_back(columns[k].header, time.why_not.empty() ? "another column says it" : time.why_not);
      }
      if (!time.why_not.empty()) continue;
      // A date with its time of day leaves no choice.
      if (used && columns[*used].second < 0) {
        plan.guesses.push_back("'" + columns[*used].header + "' is the time of the readings, not '" +
                               columns[k].header + "'");
      }
      if (used) continue;
      used = k;
      GuessUnit(columns[k], time, &plan);
    }
    if (used) *column = columns[*used];
    if (!used) plan.columns.erase(column);
  }
}

namespace {

// Whether these numbers are seconds since 1970, of this century.
bool AreSince1970(const std::vector<double>& numbers, double seconds_per_unit) {
  return std::all_of(numbers.begin(), numbers.end(), [&](double number) {
    return number * seconds_per_unit >= kFrom2000 && number * seconds_per_unit <= kTo2100;
  });
}

TimeOrigin OriginOf(const TimeColumn& time, const std::vector<double>& numbers) {
  if (time.stamps) return TimeOrigin::kSince1970;
  const double unit = time.seconds_per_unit.value_or(1.0);
  if (unit == *SecondsOfUnit("days") && AreDaysSince1900(numbers)) return TimeOrigin::kSince1900;
  return AreSince1970(numbers, unit) ? TimeOrigin::kSince1970 : TimeOrigin::kUnknown;
}

}  // namespace

TimeColumn LookAtTime(const TextTable& table, const PlannedColumn& column, const std::vector<size_t>& shots) {
  TimeColumn time;
  time.adds_nanoseconds = HasNanoseconds(table, column.second);
  const auto source = static_cast<size_t>(column.source), second = static_cast<size_t>(column.second);
  std::set<std::string> different;
  bool numbers = true, has_slashes = false;
  std::vector<double> values;
  time.stamps =
      !time.adds_nanoseconds && (column.second < 0 || AreDateAndTimeOfDay(table, column.source, column.second));
  for (const TextTable::Row& row : table.rows) {
    CheckInterruption();
    const std::string cell = time.adds_nanoseconds ? row.cells[source] + "," + row.cells[second]
                                                   : CellOfTime(row, column.source, column.second);
    if (IsLostCell(cell)) continue;
    if (!different.insert(cell).second) continue;
    time.stamps = time.stamps && SecondsOfStamp(cell).has_value();
    has_slashes = has_slashes || std::count(cell.begin(), cell.end(), '/') == 2;
    const std::optional<double> number =
        time.adds_nanoseconds ? SecondsOfRow(table, row, column, time) : table.Number(cell);
    numbers = numbers && number;
    values.push_back(number.value_or(0.0));
  }
  if (different.size() < 2) {
    time.why_not = "the time is the same in every row";
  } else if (!time.stamps && !numbers) {
    time.why_not = has_slashes ? "of dates with strokes nothing says which number is the day: 2020-07-14 16:39:04 does"
                               : "the times are no seconds and no stamps like 2020-07-14 16:39:04 or 20200714163904";
  } else if (!time.stamps && 2 * different.size() < shots.size()) {
    time.why_not = "the times are rounded: " + std::to_string(different.size()) + " different ones of " +
                   std::to_string(shots.size()) + " shots";
  }
  std::string unit = time.adds_nanoseconds || column.is_mapped ? "s" : "";
  if (unit.empty() && table.has_header()) unit = WrittenUnit(table.header[source]);
  if (unit.empty() && numbers && !time.stamps && !values.empty()) {
    const auto [first, last] = std::minmax_element(values.begin(), values.end());
    unit = UnitSince1970(*first, *last);
    time.since_1970 = !unit.empty();
    std::vector<double> of_shots;
    for (const size_t r : shots) {
      const std::string& cell = table.rows[r].cells[source];
      if (!IsLostCell(cell)) of_shots.push_back(*table.Number(cell));
    }
    time.counts_days = unit.empty() && AreDays(values, std::move(of_shots));
    if (time.counts_days) unit = "days";
    if (unit.empty() && time.why_not.empty()) time.why_not = WhyNoSeconds(values);
  }
  time.seconds_per_unit = SecondsOfUnit(unit);
  time.unit = time.seconds_per_unit && !time.stamps ? unit : "s";
  time.origin = OriginOf(time, values);
  if (time.why_not.empty() && !time.stamps && !unit.empty() && !time.seconds_per_unit)
    time.why_not = "'" + unit + "' is no unit that time is read in: s, ms, us, ns, min, h or days";
  return time;
}

}  // namespace sagitta
