// Whether the robot can have made the readings of a table, has made them, and which rows alone it did not make.
#include "tests/tools/import_tables.h"

#ifdef SAGITTA_HAVE_KDL

namespace sagitta::import_misfit_test {
namespace {

using test::MakeReadings;
using test::Reading;
using test::Readings;
using test::Table;

class ImportMisfit : public test::Import {};

double Rounded(double value, double step) { return step * std::round(value / step); }

// The points of a controller, and its joint values with the digits that it shows.
std::vector<Reading> ControllersPoints(double angle_step, double length_step) {
  std::vector<Reading> readings = MakeReadings(true);
  for (Reading& reading : readings) {
    for (double& q : reading.q_deg) q = Rounded(q, angle_step);
    for (double& x : reading.xyz_mm) x = Rounded(x, length_step);
  }
  return readings;
}

TEST_F(ImportMisfit, PointsOfJointValuesThatAreRoundedAreComputed) {
  ExpectRefused(Table(ControllersPoints(0.01, 0.01)).ToText(), {"they were computed, not measured", "digits"});
  ExpectRefused(Table(ControllersPoints(0.01, 1e-4)).ToText(), {"they were computed, not measured"});
  ExpectRefused(Table(ControllersPoints(0.002, 0.001)).ToText(), {"they were computed, not measured"});
  // Who says that they are measured is believed.
  EXPECT_EQ(ImportText(Table(ControllersPoints(0.01, 0.01)).ToText(), {"--map=x_mm=x_mm,y_mm=y_mm,z_mm=z_mm"}).status,
            0);
}

// Poses of whole degrees were driven to as written: their digits are no rounding.
TEST_F(ImportMisfit, MeasuredPointsAtPosesOfFewDigitsAreMeasured) {
  ExpectRight(Table(Readings()).ToText(), Readings());
  std::vector<Reading> coarse = ControllersPoints(1.0, 0.001);
  const Table table(coarse);
  const test::Outcome outcome = ImportText(table.ToText());
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err.find("computed"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace sagitta::import_misfit_test

#endif  // SAGITTA_HAVE_KDL
