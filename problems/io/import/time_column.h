// What a column of times says: seconds, or stamps of date and time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "problems/io/import/import_plan.h"
#include "problems/io/import/text_table.h"

namespace sagitta {

// Seconds since 1970 of 20240312090011, "2024-03-12 09:00:11" (T, fractions, Z and offsets like +01:00 too) or
// "12.03.2024 09:00:11", day first as the points say; only differences matter, the calendar is the proleptic Gregorian
// one. Nothing: it is none.
std::optional<double> SecondsOfStamp(const std::string& cell);

// s, what a header calls the unit of its times; nothing where it states none.
std::optional<double> SecondsOfHeader(const std::string& header);

// Rows with other joint values, station or visit than the row before: markers of one shot share its time.
std::vector<size_t> FirstRowsOfShots(const TextTable& table, const ImportPlan& plan);

// From when times are counted. Those of two files with different ones are no times of one campaign.
enum class TimeOrigin { kUnknown, kSince1970, kSince1900 };

// How a column of times is read, or why it cannot be used: it is the same everywhere, rounded, no time, or in a unit
// that is none of times. Of stamps the header's unit says nothing.
struct TimeColumn {
  bool stamps = false;
  bool adds_nanoseconds = false;           // a second column has them, the first whole seconds
  std::optional<double> seconds_per_unit;  // of numbers; nothing: the header does not say
  bool since_1970 = false;   // the header does not say, and the numbers are of this century in one unit only
  bool counts_days = false;  // the header does not say, and as seconds the readings would follow each other too fast
  std::string unit;          // of it, as written
  TimeOrigin origin = TimeOrigin::kUnknown;
  std::string why_not;  // "": it can
};
// column: of times, in which `second` states the rest of the time (ColumnsOfOneTime). Of one that --map calls seconds
// the numbers are these, whatever they look like. shots: FirstRowsOfShots.
TimeColumn LookAtTime(const TextTable& table, const PlannedColumn& column, const std::vector<size_t>& shots);

// s, of a row; nothing where it is lost.
std::optional<double> SecondsOfRow(const TextTable& table, const TextTable::Row& row, const PlannedColumn& column,
                                   const TimeColumn& time);

// Two columns that state one time together: a date and a time of day (of `times`, columns whose names say that they are
// times), or whole seconds and nanoseconds, as ROS has them.
struct ColumnsOfOneTime {
  int first = -1, second = -1;
};
std::optional<ColumnsOfOneTime> FindColumnsOfOneTime(const TextTable& table, const std::vector<int>& times);

// Of the columns that may be the time the first that can be used, once it is known which rows are one shot; the others
// are left out with the reason. A unit that no header states is a guess, and so is the choice among several.
void DecideTimes(const TextTable& table, std::vector<ImportPlan>* plans);

}  // namespace sagitta
