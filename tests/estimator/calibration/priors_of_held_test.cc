// A prior is one more reading of its parameter: what is nominal by default is estimated with it, and where the
// experiment holds the parameter that is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/sagitta.h"
#include "tests/support/in_memory.h"

namespace sagitta::priors_of_held_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

const ParameterEstimate& Row(const Estimate& estimate, const std::string& name) {
  for (const ParameterEstimate& row : estimate.table) {
    if (row.name == name) return row;
  }
  ADD_FAILURE() << name;
  return estimate.table.front();
}

CalibrationProblem WithPrior(Experiment experiment, const std::string& name) {
  experiment.priors[name] = {3.0, 0.2};  // mm
  const Robot arm = test::ArmInMemory();
  return MakeCalibrationProblem(arm, test::ReadingsInMemory(arm), experiment);
}

// Along the flange's axis a link's length and the markers' heights are the same: the prior alone determines how much of
// it is whose, and the points stay.
TEST(PriorsOfHeld, WhatIsRedundantIsEstimatedWithIt) {
  const Robot arm = test::ArmInMemory();
  const Estimate without = EstimateJointly(MakeCalibrationProblem(arm, test::ReadingsInMemory(arm), Experiment()));
  ASSERT_FALSE(Row(without, "geometry/A6.d").free);
  const CalibrationProblem problem = WithPrior(Experiment(), "geometry/A6.d");
  const Estimate with = EstimateJointly(problem);
  EXPECT_THAT(problem.redundant_errors, Not(Contains("A6.d")));
  EXPECT_NEAR(Row(with, "geometry/A6.d").value, 3e-3, 1e-9);
  EXPECT_NEAR(Row(with, "geometry/A6.d").sigma, 2e-4, 1e-8);
  EXPECT_NEAR(with.chi2, without.chi2, 1e-6 * without.chi2);
  for (const char* marker : {"marker/M1/z", "marker/M2/z", "marker/M3/z"}) {
    EXPECT_NEAR(Row(with, marker).value, Row(without, marker).value - 3e-3, 1e-8) << marker;
    EXPECT_NEAR(Row(with, marker).sigma, std::hypot(Row(without, marker).sigma, 2e-4), 1e-6) << marker;
  }
}

TEST(PriorsOfHeld, WhatTheExperimentHoldsStaysAndIsNamed) {
  Experiment experiment;
  experiment.estimate.fixed = {"geometry/A2.a"};
  const CalibrationProblem problem = WithPrior(experiment, "geometry/A2.a");
  EXPECT_THAT(problem.data().warnings,
              Contains(AllOf(HasSubstr("priors.geometry/A2.a"), HasSubstr("counts for nothing"))));
  EXPECT_EQ(Row(EstimateJointly(problem), "geometry/A2.a").value, 0.0);
  EXPECT_THAT(WithPrior(Experiment(), "geometry/A2.a").data().warnings, Not(Contains(HasSubstr("counts for nothing"))));
}

}  // namespace
}  // namespace sagitta::priors_of_held_test
