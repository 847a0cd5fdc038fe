// Weights that pull another way than gravity is stated, on arms that a generator of its own loads and measures
// (tests/support/loaded_kr270.h): a frame that is not levelled is named with its angle and its remedy, and arms on
// walls, slopes and ceilings in levelled frames are not.
#include "estimator/inspection/load_direction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/inspection/inspect.h"
#include "estimator/sagitta.h"
#include "models/constants.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::load_direction_test {
namespace {

using ::testing::HasSubstr;

// One station whose instrument measures in a frame where weights pull along `gravity`; stated as a mass, and `stated`
// as the direction.
CalibrationProblem ProblemOf(const Vector3<double>& gravity, const Vector3<double>& base_rotvec, std::uint64_t seed,
                             const Vector3<double>& stated = {0, 0, -1}) {
  test::LoadedTruth truth;
  truth.base_rotvec = {base_rotvec, base_rotvec};
  truth.loads["V250"].force = test::kWeightOf250Kg * gravity;
  test::LoadedDesign design;
  design.seed = seed;
  design.stations = 1;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), design.sigma, seed, &data);
  for (Shot& shot : data.shots) shot.wrench = {};
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.experiment.loads["V250"].mass = 250.0;
  setup.experiment.gravity_direction = stated;
  return MakeCalibrationProblem(setup.robot, data, setup.experiment);
}

TEST(LoadDirection, AFrameThatIsNotLevelledIsNamed) {
  for (const double tilt : {10.0, 30.0, 90.0}) {
    for (const std::uint64_t seed : {1, 2}) {
      const double s = std::sin(tilt * kDegree), c = std::cos(tilt * kDegree);
      const Vector3<double> gravity = seed == 1 ? Vector3<double>(0, s, -c) : Vector3<double>(-s, 0, -c);
      const Vector3<double> turned(0.02, -0.01, 0.6);
      const CalibrationProblem problem = ProblemOf(gravity, turned, seed);
      const std::optional<LoadDirection> found = FindLoadDirection(problem);
      ASSERT_TRUE(found) << tilt;
      EXPECT_NEAR(found->angle / kDegree, tilt, 1.0);
      EXPECT_GT(found->fitted_in_frame.dot(gravity), std::cos(1.0 * kDegree));
      EXPECT_GT(found->fitted.dot(RotationFromVector(turned).transpose() * gravity), std::cos(1.0 * kDegree));
      const Inspection inspection = Inspect(problem);
      EXPECT_EQ(inspection.Count(Severity::kSerious), 1);  // and no row is accused
      EXPECT_EQ(inspection.findings.front().code, "load_direction");
      EXPECT_FALSE(FindLoadDirection(ProblemOf(gravity, turned, seed, gravity))) << tilt;
    }
  }
}

TEST(LoadDirection, WallsSlopesAndCeilingsAreHealthy) {
  for (const Vector3<double>& turned :
       {Vector3<double>(0, 0, 0.7), Vector3<double>(0, kPi / 2, 0), Vector3<double>(kPi / 4, 0, 0),
        Vector3<double>(0.3, -0.6, 0.2), Vector3<double>(kPi, 0, 0)}) {
    for (const std::uint64_t seed : {3, 4}) {
      const CalibrationProblem problem = ProblemOf({0, 0, -1}, turned, seed);
      EXPECT_FALSE(FindLoadDirection(problem)) << turned.transpose();
      EXPECT_EQ(Inspect(problem).Count(Severity::kSerious), 0);
    }
  }
}

TEST(LoadDirection, ACalibrationWithAnotherGravityIsNotTrusted) {
  const Calibration tilted = Calibrate(ProblemOf({0, 1, 0}, {0.02, -0.01, 0.6}, 5));
  EXPECT_FALSE(tilted.trust.verdict.trusted);
  EXPECT_THAT(tilted.trust.verdict.reasons, ::testing::Contains(HasSubstr("90 degrees away from the stated gravity")));
  EXPECT_THAT(tilted.estimate.warnings, ::testing::Contains(HasSubstr("state gravity: {direction: [")));
  const Calibration stated = Calibrate(ProblemOf({0, 1, 0}, {0.02, -0.01, 0.6}, 5, {0, 1, 0}));
  EXPECT_TRUE(stated.trust.verdict.trusted) << stated.trust.verdict.words;
}

// Forces in the rows do not turn with gravity: to state another one would change nothing.
TEST(LoadDirection, ForcesInColumnsAreCheckedThere) {
  test::LoadedTruth truth;
  test::LoadedDesign design;
  design.stations = 1;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), design.sigma, 6, &data);
  for (Shot& shot : data.shots) shot.wrench.force *= -1.0;
  const test::LoadedSetup setup = test::SetupFor(truth);
  const auto found = FindLoadDirection(MakeCalibrationProblem(setup.robot, data, setup.experiment));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->angle / kDegree, 180.0, 1.0);
  EXPECT_THAT(LoadDirectionInWords(*found).remedy, HasSubstr("check signs and axes of fx_N, fy_N, fz_N"));
}

}  // namespace
}  // namespace sagitta::load_direction_test
