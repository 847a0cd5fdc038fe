#include "problems/measurement_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <stdexcept>

#include "problems/io/csv_table.h"

namespace sagitta::measurement_rows_test {
namespace {

std::vector<std::string> CellsOf(const MeasurementRows::Row& row) {
  std::vector<std::string> cells;
  for (size_t c = 0; c < row.cells.size(); ++c) cells.emplace_back(row.cells[c]);
  return cells;
}

using Texts = std::vector<std::string>;

TEST(MeasurementRowsTest, HoldsRowsOfAnyLength) {
  MeasurementRows rows = {{2, {"C1", "", "1.5"}}, {4, {}}};
  rows.push_back({9, {"a text with a comma, and \"quotes\""}});
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(CellsOf(rows[0]), (Texts{"C1", "", "1.5"}));
  EXPECT_EQ(rows[1].cells.size(), 0u);
  EXPECT_EQ(CellsOf(rows[2]), (Texts{"a text with a comma, and \"quotes\""}));
  std::vector<int> lines;
  for (const MeasurementRows::Row& row : rows) lines.push_back(row.line);
  EXPECT_EQ(lines, (std::vector<int>{2, 4, 9}));
  EXPECT_EQ(rows.LineOf(2), 9);
  EXPECT_THROW(rows.at(3), std::out_of_range);
  EXPECT_THROW(rows.at(0).cells.at(3), std::out_of_range);
  rows.clear();
  EXPECT_TRUE(rows.empty());
}

TEST(MeasurementRowsTest, ACopyStaysWhenTheOtherChanges) {
  MeasurementRows rows = {{2, {"C1", "x"}}, {3, {"C2", "y"}}};
  const MeasurementRows copy = rows;
  EXPECT_EQ(copy[1].cells[1].data(), rows[1].cells[1].data());  // one text
  rows.SetCell(0, 1, "a longer text");
  rows.push_back({4, {"C3", "z"}});
  EXPECT_EQ(CellsOf(rows[0]), (Texts{"C1", "a longer text"}));
  EXPECT_EQ(CellsOf(rows[1]), (Texts{"C2", "y"}));
  EXPECT_EQ(CellsOf(rows[2]), (Texts{"C3", "z"}));
  ASSERT_EQ(copy.size(), 2u);
  EXPECT_EQ(CellsOf(copy[0]), (Texts{"C1", "x"}));
}

TEST(MeasurementRowsTest, TakesARowOfItself) {
  MeasurementRows rows = {{2, {"C1", "x"}}};
  for (int i = 0; i < 50; ++i) rows.Append(rows[0]);
  EXPECT_EQ(rows.size(), 51u);
  EXPECT_TRUE(rows[50].cells == rows[0].cells);
  rows.SetCell(50, 1, "y");
  EXPECT_FALSE(rows[50].cells == rows[0].cells);
}

// A file with one guarded cell is cut by another loop than one without: both give the same cells.
// A line that is cut at its separators, against its cells one by one; lengths about those that are looked at together.
TEST(MeasurementRowsTest, LinesAreCutAtEverySeparator) {
  std::mt19937_64 random(5);
  MeasurementRows lines;
  std::vector<Texts> expected;
  for (int i = 0; i < 400; ++i) {
    Texts own(1 + random() % (i % 10 == 0 ? 600 : 12));
    for (std::string& cell : own) {
      cell.assign(random() % (i % 4 == 0 ? 2 : 12), static_cast<char>('!' + random() % 10));
      std::replace(cell.begin(), cell.end(), ',', '\xAC');  // a comma with its highest bit
    }
    std::string line = own[0];
    for (size_t c = 1; c < own.size(); ++c) line += "," + own[c];
    lines.BeginRow(i);
    lines.AddCells(line);
    expected.push_back(std::move(own));
  }
  ASSERT_EQ(lines.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(CellsOf(lines[i]), expected[i]) << i;
}

TEST(MeasurementRowsTest, PlainAndQuotedFilesHaveTheSameCells) {
  const std::string plain = "a,b,c\n 1 ,,x y\t\r\n2,, \n#no row\n\n,,\n";
  const CsvTable direct = ParseCsvTable(plain, "t.csv");
  const CsvTable guarded = ParseCsvTable(plain + "'=1,\"q\",\"\"\n", "t.csv");
  ASSERT_EQ(direct.file.rows.size(), 3u);
  ASSERT_EQ(guarded.file.rows.size(), 4u);
  for (size_t r = 0; r < 3; ++r) {
    EXPECT_EQ(CellsOf(direct.file.rows[r]), CellsOf(guarded.file.rows[r])) << r;
    EXPECT_EQ(direct.file.rows.LineOf(r), guarded.file.rows.LineOf(r));
  }
  EXPECT_EQ(CellsOf(direct.file.rows[0]), (Texts{"1", "", "x y"}));
  EXPECT_EQ(CellsOf(guarded.file.rows[3]), (Texts{"=1", "q", ""}));
}

}  // namespace
}  // namespace sagitta::measurement_rows_test
