// Whoever interrupts a reader of long tables waits for no more than a row.
#include <gtest/gtest.h>

#include "problems/io/csv_table.h"
#include "problems/io/import/import_plan.h"
#include "problems/io/import/imported_rows.h"
#include "problems/io/import/text_table.h"
#include "problems/io/measurement_file.h"
#include "tests/support/interruptible.h"
#include "tests/support/kr270.h"

namespace sagitta::interruption_test {
namespace {

using test::ExpectInterruptible;

const char* const kTable =
    "config,marker,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm\n"
    "C1,P1,0,-90,90,0,10,0,1500,0,1700\n"
    "C2,P1,20,-80,80,10,20,0,1500,300,1700\n";

class InterruptionOf : public ::testing::Test {
 protected:
  InterruptionOf() { robot_.chain = test::Kr270Chain(); }

  Robot robot_;
};

TEST_F(InterruptionOf, CsvTables) {
  ExpectInterruptible([] { ParseCsvTable(kTable, "rows.csv"); });
}

TEST_F(InterruptionOf, MeasurementRows) {
  const CsvTable table = ParseCsvTable(kTable, "rows.csv");
  ExpectInterruptible([&] { MeasurementsFromTables({table}, robot_, {}); });
}

TEST_F(InterruptionOf, TextTables) {
  ExpectInterruptible([] { ParseTextTable(kTable, "rows.csv"); });
}

TEST_F(InterruptionOf, ImportedRows) {
  const TextTable table = ParseTextTable(kTable, "rows.csv");
  const std::vector<ImportPlan> plans = PossiblePlans(table, robot_.chain.joints, {});
  ASSERT_FALSE(plans.empty());
  ExpectInterruptible([&] { sagitta::ImportedRows().Add(table, plans[0], {}); });
  sagitta::ImportedRows rows;
  rows.Add(table, plans[0], {});
  ExpectInterruptible([&] { rows.ToCsv(6); });
}

}  // namespace
}  // namespace sagitta::interruption_test
