// What a column of times says: seconds, or stamps of date and time.
#pragma once

#include <optional>
#include <string>

#include "problems/io/import/import_plan.h"
#include "problems/io/import/text_table.h"

namespace sagitta {

// Seconds since 1970 of 20240312090011, "2024-03-12 09:00:11" (T, fractions and Z too) or "12.03.2024 09:00:11", day
// first as the points say; only differences matter, the calendar is the proleptic Gregorian one. Nothing: it is none.
std::optional<double> SecondsOfStamp(const std::string& cell);

// Rows with other joint values, station or visit than the row before: markers of one shot share its time.
size_t CountShots(const TextTable& table, const ImportPlan& plan);

// How a column of times is read, or why it cannot be used: it is the same everywhere, rounded (shots: how many are
// apart), no time, or in a unit that is none of times. Of stamps the header's unit says nothing.
struct TimeColumn {
  bool stamps = false;
  std::optional<double> seconds_per_unit;  // of numbers; nothing: the header does not say
  bool since_1970 = false;  // the header does not say, and the numbers are of this century in one unit only
  std::string unit;         // of it, as written
  std::string why_not;      // "": it can
};
TimeColumn LookAtTime(const TextTable& table, int column, size_t shots);

// Leaves out a time that was rounded away, once it is known which rows are one shot; where it stays, a unit that no
// header states is a guess.
void DecideTimes(const TextTable& table, std::vector<ImportPlan>* plans);

}  // namespace sagitta
