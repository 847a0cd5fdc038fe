// Times in two columns, with offsets, and numbers that are no seconds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "problems/io/import/import_plan.h"
#include "problems/io/import/time_column.h"

namespace sagitta::time_columns_test {
namespace {

using ::testing::HasSubstr;

TextTable TableOf(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows) {
  TextTable table;
  table.header = header;
  table.header_line = 1;
  for (const auto& cells : rows) table.rows.push_back({static_cast<int>(table.rows.size()) + 2, cells});
  return table;
}

// Columns of times: `second` with the rest of the time, -1 none.
PlannedColumn Columns(int first, int second = -1) {
  PlannedColumn column;
  column.stem = "time";
  column.header = "column " + std::to_string(first);
  column.source = first;
  column.second = second;
  return column;
}

// Each row a shot of its own.
TimeColumn Look(const TextTable& table, const PlannedColumn& column = Columns(0)) {
  std::vector<size_t> shots(table.rows.size());
  std::iota(shots.begin(), shots.end(), 0);
  return LookAtTime(table, column, shots);
}

// s between the first row and the last.
double Lasts(const TextTable& table, int first, int second) {
  const PlannedColumn column = Columns(first, second);
  const TimeColumn time = Look(table, column);
  EXPECT_EQ(time.why_not, "");
  return SecondsOfRow(table, table.rows.back(), column, time).value() -
         SecondsOfRow(table, table.rows.front(), column, time).value();
}

TEST(TimeStamps, MayHaveAnOffset) {
  const double nine = 1710234011.0;  // date -u -d '2024-03-12 09:00:11' +%s
  EXPECT_EQ(SecondsOfStamp("2024-03-12T10:00:11+01:00"), nine);
  EXPECT_EQ(SecondsOfStamp("2024-03-12T03:30:11.5-0530"), nine + 0.5);
  EXPECT_EQ(SecondsOfStamp("2024-03-12T09:00:11.123456789+00:00"), nine + 0.123456789);
  EXPECT_FALSE(SecondsOfStamp("2024-03-12T09:00:11+1"));
}

TEST(TimesInTwoColumns, ADateAndATimeOfDay) {
  const std::vector<std::vector<std::vector<std::string>>> midnights = {
      {{"2024-03-05", "23:59:30"}, {"2024-03-06", "00:00:30"}},
      {{"05.03.2024", "23:59:30"}, {"06.03.2024", "0:00:30"}},
      {{"20240305", "235930"}, {"20240306", "30"}},
      {{"20240305", "235930.5"}, {"20240306", "000030.5"}}};
  for (const auto& rows : midnights) {
    for (const bool time_first : {false, true}) {
      std::vector<std::vector<std::string>> cells = rows;
      if (time_first) {
        for (auto& row : cells) std::swap(row[0], row[1]);
      }
      const TextTable table = TableOf({"a", "b"}, cells);
      const auto found = FindColumnsOfOneTime(table, {0, 1});
      ASSERT_TRUE(found) << rows[0][0];
      EXPECT_EQ(found->first, time_first ? 1 : 0);
      EXPECT_DOUBLE_EQ(Lasts(table, found->first, found->second), 60.0) << rows[0][0];
    }
  }
  EXPECT_FALSE(FindColumnsOfOneTime(TableOf({"Date", "Time"}, {{"03/05/2024", "23:59:30"}, {"03/06/2024", "00:00:30"}}),
                                    {0, 1}));
  EXPECT_FALSE(FindColumnsOfOneTime(TableOf({"Time", "Zeit"}, {{"1.5", "2.5"}, {"3.5", "4.5"}}), {0, 1}));
}

TEST(TimesInTwoColumns, SecondsAndNanoseconds) {
  for (const auto& [seconds, rest] : {std::pair<const char*, const char*>("secs", "nsecs"),
                                      {"header.stamp.sec", "header.stamp.nanosec"},
                                      {"stamp_secs", "stamp_nsecs"}}) {
    const TextTable table = TableOf({rest, seconds}, {{"900000000", "1709676000"}, {"100000000", "1709676061"}});
    const auto found = FindColumnsOfOneTime(table, {});
    ASSERT_TRUE(found) << seconds;
    EXPECT_EQ(found->first, 1);
    EXPECT_EQ(found->second, 0);
    EXPECT_NEAR(Lasts(table, 1, 0), 60.2, 1e-6);
  }
  EXPECT_FALSE(FindColumnsOfOneTime(TableOf({"start.sec", "end.nsec"}, {{"1", "2"}, {"3", "4"}}), {}));
}

// Read as seconds they would be a drift that nobody has.
TEST(TimeColumns, NumbersThatAreNoSecondsAreNotUsed) {
  std::vector<std::vector<std::string>> clock, dates, days, seconds, steps;
  for (int r = 0; r < 12; ++r) {
    clock.push_back({std::to_string(220000 + 200 * r / 60 * 100 + 7 * r % 60)});
    dates.push_back({std::to_string(20240305 + r)});
    days.push_back({std::to_string(45356.916 + 0.0035 * r)});
    seconds.push_back({std::to_string(45356 + 37 * r)});
    steps.push_back({std::to_string(10000 + 300 * r)});
  }
  EXPECT_THAT(Look(TableOf({"Time"}, clock)).why_not, HasSubstr("times of day like 220501"));
  EXPECT_THAT(Look(TableOf({"Date"}, dates)).why_not, HasSubstr("dates like 20240305"));
  const TimeColumn spreadsheet = Look(TableOf({"Time"}, days));
  EXPECT_TRUE(spreadsheet.counts_days);
  EXPECT_EQ(spreadsheet.seconds_per_unit, 86400.0);
  EXPECT_NEAR(Lasts(TableOf({"Time"}, days), 0, -1), 86400.0 * 0.0035 * 11, 0.1);
  for (const auto& rows : {seconds, steps}) {
    const TimeColumn plain = Look(TableOf({"Time"}, rows));
    EXPECT_EQ(plain.why_not, "");
    EXPECT_FALSE(plain.counts_days);
    EXPECT_FALSE(plain.seconds_per_unit);
  }
  // What the header states holds.
  EXPECT_EQ(Look(TableOf({"Time [s]"}, clock)).why_not, "");
  EXPECT_FALSE(Look(TableOf({"Time [s]"}, days)).counts_days);
}

TEST(TimeColumns, DatesOfWhichTheDayIsNotKnownAreNamed) {
  const TextTable table = TableOf({"Timestamp"}, {{"03/05/2024 10:00:00"}, {"03/05/2024 10:05:00"}});
  EXPECT_THAT(Look(table).why_not, HasSubstr("which number is the day"));
}

// A date and a time since a start are no date and time of day: 0, 100, 200 s would be 0, 60, 120 s, and 9.25 h nine
// seconds.
TEST(TimesInTwoColumns, ADateAndATimeSinceAStartAreTwo) {
  const auto pair = [](const std::string& header, const std::vector<std::string>& times) {
    std::vector<std::vector<std::string>> rows;
    for (const std::string& time : times) rows.push_back({"20240305", time});
    return FindColumnsOfOneTime(TableOf({"Date", header}, rows), {0, 1});
  };
  for (const char* header : {"time [s]", "Time"}) {
    EXPECT_FALSE(pair(header, {"0", "100", "200"})) << header;
    EXPECT_FALSE(pair(header, {"9.25", "9.275", "9.3"})) << header;
    EXPECT_FALSE(pair(header, {"0.0", "15.5", "31.0"})) << header;
  }
  EXPECT_FALSE(pair("Time [h]", {"9.2500", "9.2750"}));
  EXPECT_FALSE(pair("time_s", {"100000", "100100"}));  // what the header states holds
  EXPECT_TRUE(pair("Time", {"100000", "100100"}));
  EXPECT_TRUE(pair("Time", {"91501", "91601", "101501"}));
  EXPECT_TRUE(pair("Time", {"091501.5", "091601.25"}));
  EXPECT_TRUE(pair("Time [h]", {"9:15:01", "9:16:01"}));  // hours, minutes, seconds
  // --map=time_s=Date+Time of such columns is no stamp either.
  const TextTable hours = TableOf({"Date", "Time [h]"}, {{"20240305", "9.25"}, {"20240305", "9.275"}});
  EXPECT_THAT(Look(hours, Columns(0, 1)).why_not, HasSubstr("no stamps"));
}

TEST(TimeColumns, WhatTheMapCallsSecondsIsSeconds) {
  PlannedColumn mapped = Columns(0);
  mapped.is_mapped = true;
  std::vector<std::vector<std::string>> of_day, steps, parts;
  for (int r = 0; r < 30; ++r) {
    of_day.push_back({std::to_string(40000.0 + 0.05 * r)});
    steps.push_back({std::to_string(10000 + 50 * (r < 12 ? r : 2 * r))});
    parts.push_back({std::to_string(0.01 * r)});
  }
  EXPECT_TRUE(Look(TableOf({"t"}, of_day)).counts_days);
  EXPECT_NE(Look(TableOf({"t"}, parts)).why_not, "");
  for (const auto& rows : {of_day, steps, parts}) {
    const TimeColumn time = Look(TableOf({"t"}, rows), mapped);
    EXPECT_EQ(time.why_not, "");
    EXPECT_EQ(time.seconds_per_unit, 1.0);
    EXPECT_FALSE(time.counts_days);
  }
  // Stamps stay stamps.
  EXPECT_TRUE(Look(TableOf({"t"}, {{"2024-03-05 10:00:00"}, {"2024-03-05 10:00:09"}}), mapped).stamps);
}

// Nights are long gaps, and few.
TEST(TimeColumns, DaysOfSpreadsheetsMayBeOfSeveralDays) {
  for (const int per_day : {20, 10, 4}) {
    std::vector<std::vector<std::string>> days, seconds;
    for (int r = 0; r < 20; ++r) {
      const double day = r / per_day + 0.001 * (r % per_day);
      days.push_back({std::to_string(45356.4 + day)});
      seconds.push_back({std::to_string(45356.4 + 86400.0 * day)});
    }
    const TimeColumn time = Look(TableOf({"Time"}, days));
    EXPECT_TRUE(time.counts_days) << per_day;
    EXPECT_EQ(time.seconds_per_unit, 86400.0);
    EXPECT_EQ(time.origin, TimeOrigin::kSince1900);
    EXPECT_FALSE(Look(TableOf({"Time"}, seconds)).counts_days) << per_day;
  }
  // Ten readings of each shot at 50 Hz are one shot.
  std::vector<std::vector<std::string>> fast;
  std::vector<size_t> shots;
  for (int r = 0; r < 60; ++r) {
    if (r % 10 == 0) shots.push_back(static_cast<size_t>(r));
    fast.push_back({std::to_string(45356.0 + 30.0 * (r / 10) + 0.02 * (r % 10))});
  }
  EXPECT_FALSE(LookAtTime(TableOf({"Time"}, fast), Columns(0), shots).counts_days);
}

TEST(TimeColumns, PartsOfADayAreNoSeconds) {
  const TextTable table = TableOf({"Time"}, {{"0.3850"}, {"0.3860"}, {"0.4214"}});
  EXPECT_THAT(Look(table).why_not, HasSubstr("parts of a day"));
  EXPECT_EQ(Look(TableOf({"Time [days]"}, {{"0.3850"}, {"0.3860"}})).seconds_per_unit, 86400.0);
}

TEST(TimeColumns, SevenTimesOfDayAreNoSeconds) {
  std::vector<std::vector<std::string>> clock, seconds;
  for (int r = 0; r < 7; ++r) {
    clock.push_back({std::to_string(100015 + 300 * r)});
    seconds.push_back({std::to_string(15 + 300 * r)});
  }
  EXPECT_THAT(Look(TableOf({"Time"}, clock)).why_not, HasSubstr("times of day"));
  EXPECT_EQ(Look(TableOf({"Time"}, seconds)).why_not, "");
}

TEST(TimeColumns, SayFromWhenTheyCount) {
  EXPECT_EQ(Look(TableOf({"Time"}, {{"2024-03-05 10:00:00"}, {"2024-03-05 10:01:00"}})).origin, TimeOrigin::kSince1970);
  EXPECT_EQ(Look(TableOf({"t"}, {{"1700000000000"}, {"1700000060000"}})).origin, TimeOrigin::kSince1970);
  EXPECT_EQ(Look(TableOf({"time [s]"}, {{"1700000000"}, {"1700000060"}})).origin, TimeOrigin::kSince1970);
  EXPECT_EQ(Look(TableOf({"time [s]"}, {{"0"}, {"60"}})).origin, TimeOrigin::kUnknown);
  EXPECT_EQ(Look(TableOf({"time [s]"}, {{"45356"}, {"45416"}})).origin, TimeOrigin::kUnknown);
  EXPECT_EQ(Look(TableOf({"time [days]"}, {{"45356.5"}, {"45356.6"}})).origin, TimeOrigin::kSince1900);
}

// The plan with two columns of times, the first of which comes first.
TEST(TimeColumns, ATimeThatCanBeUsedIsUsedInPlaceOfOneThatCannot) {
  const auto decided = [](const TextTable& table) {
    ImportPlan plan;
    plan.columns = {Columns(0)};
    plan.other_times = {Columns(1)};
    for (const char* stem : {"q1", "x"}) plan.Add(stem, "", 2, stem, stem);
    std::vector<ImportPlan> plans = {plan};
    DecideTimes(table, &plans);
    return plans[0];
  };
  const std::vector<std::string> header = {"Timestamp", "Elapsed time [s]", "q1"};
  const std::pair<std::vector<std::string>, std::string> unusable[] = {
      {{"3/5/2024 10:00:00 AM", "3/5/2024 10:01:00 AM", "3/5/2024 10:02:00 AM", "3/5/2024 10:03:00 AM"}, "strokes"},
      {{"05.03.2024", "05.03.2024", "05.03.2024", "05.03.2024"}, "same in every row"},
      {{"600", "660", "600", "600"}, "another column says it"}};
  for (const auto& [cells, why] : unusable) {
    std::vector<std::vector<std::string>> rows;
    for (size_t r = 0; r < cells.size(); ++r) rows.push_back({cells[r], std::to_string(60 * r), std::to_string(r)});
    const bool is_usable = &cells == &unusable[2].first;
    const ImportPlan plan = decided(TableOf(header, rows));
    ASSERT_NE(plan.Find("time"), nullptr) << why;
    EXPECT_EQ(plan.Find("time")->source, is_usable ? 0 : 1) << why;
    ASSERT_EQ(plan.unused.size(), 1U);
    EXPECT_EQ(plan.unused[0].first, is_usable ? "column 1" : "column 0");
    EXPECT_THAT(plan.unused[0].second, HasSubstr(why));
    EXPECT_EQ(plan.guesses.size(), is_usable ? 2U : 0U) << why;  // which of two, and its unit
  }
}

}  // namespace
}  // namespace sagitta::time_columns_test
