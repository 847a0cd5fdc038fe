// Times in two columns, with offsets, and numbers that are no seconds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

// s between the first row and the last.
double Lasts(const TextTable& table, int first, int second) {
  const TimeColumn time = LookAtTime(table, first, table.rows.size(), second);
  EXPECT_EQ(time.why_not, "");
  PlannedColumn column;
  column.source = first;
  column.second = second;
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
  EXPECT_THAT(LookAtTime(TableOf({"Time"}, clock), 0, 12).why_not, HasSubstr("times of day like 220501"));
  EXPECT_THAT(LookAtTime(TableOf({"Date"}, dates), 0, 12).why_not, HasSubstr("dates like 20240305"));
  const TimeColumn spreadsheet = LookAtTime(TableOf({"Time"}, days), 0, 12);
  EXPECT_TRUE(spreadsheet.counts_days);
  EXPECT_EQ(spreadsheet.seconds_per_unit, 86400.0);
  EXPECT_NEAR(Lasts(TableOf({"Time"}, days), 0, -1), 86400.0 * 0.0035 * 11, 0.1);
  for (const auto& rows : {seconds, steps}) {
    const TimeColumn plain = LookAtTime(TableOf({"Time"}, rows), 0, 12);
    EXPECT_EQ(plain.why_not, "");
    EXPECT_FALSE(plain.counts_days);
    EXPECT_FALSE(plain.seconds_per_unit);
  }
  // What the header states holds.
  EXPECT_EQ(LookAtTime(TableOf({"Time [s]"}, clock), 0, 12).why_not, "");
  EXPECT_FALSE(LookAtTime(TableOf({"Time [s]"}, days), 0, 12).counts_days);
}

TEST(TimeColumns, DatesOfWhichTheDayIsNotKnownAreNamed) {
  const TextTable table = TableOf({"Timestamp"}, {{"03/05/2024 10:00:00"}, {"03/05/2024 10:05:00"}});
  EXPECT_THAT(LookAtTime(table, 0, 2).why_not, HasSubstr("which number is the day"));
}

}  // namespace
}  // namespace sagitta::time_columns_test
