// Rows that can be read and that nobody means: what is said of them, and what is not said of honest ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "problems/io/measurement_file.h"
#include "problems/text.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::measurement_warnings_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct Row {
  int pose = 0, repeat = 0;
  std::array<double, 3> point_mm = {};
  double time = 0.0, temperature = 21.0;
};

// 40 poses read three times, a minute apart, each with noise of 20 um.
std::vector<Row> Honest(double resolution_mm) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.02);
  std::vector<Row> rows;
  for (int pose = 0; pose < 40; ++pose) {
    for (int repeat = 0; repeat < 3; ++repeat) {
      Row row{pose, repeat, {}, 60.0 * static_cast<double>(rows.size()), 21.0};
      for (int a = 0; a < 3; ++a) {
        row.point_mm[a] = resolution_mm * std::round((1000.0 + 7.0 * pose + 31.0 * a + noise(random)) / resolution_mm);
      }
      rows.push_back(row);
    }
  }
  return rows;
}

class MeasurementWarnings : public FileTest {
 protected:
  std::vector<std::string> WarningsOf(const std::vector<Row>& rows) {
    std::string text = "config,repeat,marker,q1_deg,x_mm,y_mm,z_mm,time_s,temperature_degC\n";
    for (const Row& row : rows) {
      text += "c" + std::to_string(row.pose) + "," + std::to_string(row.repeat) + ",M1," + FormatNumber(row.pose);
      for (const double x : row.point_mm) text += "," + Fixed(x, 4);
      text += "," + FormatNumber(row.time) + "," + FormatNumber(row.temperature) + "\n";
    }
    return ReadMeasurements({Write("m.csv", text)}, {"A1"}, {false}, {}).warnings;
  }
};

TEST_F(MeasurementWarnings, HonestRowsHaveNone) {
  for (const double resolution_mm : {1e-4, 1e-2, 1e-1}) {
    EXPECT_THAT(WarningsOf(Honest(resolution_mm)), IsEmpty()) << resolution_mm;
  }
}

TEST_F(MeasurementWarnings, ReadingsThatWerePastedAreNoRepeats) {
  std::vector<Row> rows = Honest(1e-4);
  for (size_t r = 0; r < rows.size(); ++r) rows[r].point_mm = rows[r - r % 3].point_mm;
  EXPECT_THAT(WarningsOf(rows), Contains(HasSubstr("80 readings equal an earlier one")));
  rows = Honest(1e-4);
  for (size_t r = 0; r < 12; ++r) rows[r].point_mm = rows[r - r % 3].point_mm;  // four poses of forty
  EXPECT_THAT(WarningsOf(rows), Contains(HasSubstr("8 readings equal an earlier one")));
  EXPECT_THAT(WarningsOf(rows), Contains(HasSubstr("m.csv:3, that of")));
  rows = Honest(1e-4);
  for (size_t r = 0; r < rows.size(); ++r) rows[r].point_mm = rows[r % 3].point_mm;  // a marker that does not move
  EXPECT_THAT(WarningsOf(rows), IsEmpty());
}

TEST_F(MeasurementWarnings, AClockThatGoesBackIsSaid) {
  std::vector<Row> rows = Honest(1e-4);
  for (size_t r = 60; r < rows.size(); ++r) rows[r].time -= 3600.0;
  EXPECT_THAT(WarningsOf(rows), Contains(HasSubstr("time_s goes back 1 time")));
  // Rows that are sorted by pose, of three rounds.
  rows = Honest(1e-4);
  for (Row& row : rows) row.time = 60.0 * row.pose + 2400.0 * row.repeat;
  EXPECT_THAT(WarningsOf(rows), IsEmpty());
}

TEST_F(MeasurementWarnings, MillisecondsAndFahrenheitAreAskedAbout) {
  std::vector<Row> rows = Honest(1e-4);
  for (Row& row : rows) row.time *= 1000.0;
  EXPECT_THAT(WarningsOf(rows), Contains(HasSubstr("milliseconds")));
  rows = Honest(1e-4);
  for (Row& row : rows) row.temperature = 70.0 + 0.05 * row.pose;
  EXPECT_THAT(WarningsOf(rows), Contains(HasSubstr("Fahrenheit")));
}

}  // namespace
}  // namespace sagitta::measurement_warnings_test
