// What the size of numbers says of their units, where no fit can: angles beyond 7 are degrees, points beyond 50 mm.
#include "problems/io/import/import_plan.h"

#include <gtest/gtest.h>

namespace sagitta::import_plan_test {
namespace {

PlannedColumn Column(const std::string& stem, const std::string& unit, int source) {
  PlannedColumn column;
  column.stem = stem;
  column.unit = unit;
  column.source = source;
  return column;
}

ImportPlan Plan(const std::string& angle, const std::string& length) {
  ImportPlan plan;
  plan.columns = {Column("q1", angle, 0), Column("x", length, 1)};
  return plan;
}

TEST(PlanBySize, GoesByTheLargestNumbers) {
  const std::vector<ImportPlan> plans = {Plan("deg", "mm"), Plan("rad", "mm"), Plan("deg", "m"), Plan("rad", "m")};
  const auto best = [&](const char* angle, const char* length) {
    TextTable table;
    table.header = {"a", "b"};
    table.rows = {{1, {"0.5", "0.5"}}, {2, {angle, length}}, {3, {"-9999", "-9999"}}, {4, {"lost", ""}}};
    return PlanBySize(table, plans);
  };
  EXPECT_EQ(best("-170", "1250"), 0U);
  EXPECT_EQ(best("-2.9", "1250"), 1U);
  EXPECT_EQ(best("170", "1.25"), 2U);
  EXPECT_EQ(best("2.9", "-1.25"), 3U);
}

}  // namespace
}  // namespace sagitta::import_plan_test
