#include "estimator/baselines/differencing.h"

#include <gtest/gtest.h>

#include "estimator/baselines/compare_methods.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::differencing_test {
namespace {

// Two loads on every configuration share its unloaded shots; axis 1 is pulled too.
test::LoadedTruth TwoLoads() {
  test::LoadedTruth truth;
  truth.loads["V120"] = {{0, 0, -120 * 9.80665}};
  truth.loads["PULL"] = {{300, 400, 0}};
  return truth;
}

test::LoadedDesign TwoLoadDesign() {
  test::LoadedDesign design;
  design.loads = {"V250", "V120"};
  design.pulls = {"PULL"};
  return design;
}

std::vector<int> Compliances(const Estimate& estimate) {
  std::vector<int> found;
  for (int i = 0; i < estimate.parameters.num_coordinates(); ++i) {
    const Coordinate& coordinate = estimate.parameters.coordinates()[i];
    if (coordinate.name.rfind("compliance/", 0) == 0 && coordinate.estimated()) found.push_back(i);
  }
  return found;
}

TEST(Differencing, ExactPointsGiveTheExactCompliances) {
  const test::LoadedTruth truth = TwoLoads();
  Measurements data = test::LoadedRows(TwoLoadDesign(), truth);
  test::Measure(test::ExactPoints(truth, data), 0.0, 1, &data);
  const test::LoadedSetup setup = test::SetupFor(truth);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  const MethodResult result = RunMethod(problem, Method::kDifferencing, EstimateJointly(problem));
  ASSERT_EQ(result.estimate.status, Status::kConverged) << result.estimate.message;
  const std::vector<int> compliances = Compliances(result.estimate);
  ASSERT_EQ(compliances.size(), 6u);
  for (const int i : compliances) {
    EXPECT_NEAR(test::ErrorOf(result.estimate, truth, i) / truth.k[0], 0.0, 1e-6) << result.estimate.table[i].name;
  }
}

// With the geometry known, the scatter is what is claimed: the unloaded mean that two loads share, and the joint
// deviation that all shots of a visit share (it nearly cancels).
TEST(Differencing, ScattersAsItSays) {
  const test::LoadedTruth truth = TwoLoads();
  const test::LoadedDesign design = TwoLoadDesign();
  Measurements data = test::LoadedRows(design, truth);
  const std::vector<Vector3<double>> exact = test::ExactPoints(truth, data);
  test::LoadedSetup setup = test::SetupFor(truth);
  constexpr int kTrials = 60;
  double sum = 0.0, of_all = 0.0;
  int count = 0, unknowns = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    test::Measure(exact, design.sigma, 500 + trial, &data);
    CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
    const Estimate estimate = EstimateByDifferencing(problem);
    ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
    for (const int i : Compliances(estimate)) {
      sum += std::pow(test::ErrorOf(estimate, truth, i) / estimate.table[i].sigma, 2);
      ++count;
    }
    of_all += test::SquaredDistanceToTruth(estimate, truth);
    unknowns += static_cast<int>(estimate.estimated.size());
  }
  // What does not bend is known from the unloaded rows, a third of all. chi-square of that many unknowns.
  EXPECT_NEAR(of_all / unknowns, 1.0, 4 * std::sqrt(2.0 / unknowns));
  // 6 nearly uncorrelated errors per trial; a covariance without the shared unloaded mean is off by a quarter.
  EXPECT_NEAR(sum / count, 1.0, 4 * std::sqrt(2.0 / count));
}

TEST(Differencing, RepeatabilityCancelsInDifferences) {
  const test::LoadedTruth truth = TwoLoads();
  const test::LoadedDesign design = TwoLoadDesign();
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), design.sigma, 3, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  const Estimate without = EstimateByDifferencing(MakeCalibrationProblem(setup.robot, data, setup.experiment));
  setup.experiment.repeatability.angle.common = 40e-6;
  const Estimate with = EstimateByDifferencing(MakeCalibrationProblem(setup.robot, data, setup.experiment));
  for (const int i : Compliances(with)) {
    EXPECT_NEAR(with.table[i].sigma / without.table[i].sigma, 1.0, 0.01) << with.table[i].name;
  }
}

TEST(Differencing, SaysWhyItDoesNotRun) {
  test::LoadedTruth truth;
  test::LoadedDesign design;
  design.unloaded = false;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), design.sigma, 1, &data);
  const test::LoadedSetup setup = test::SetupFor(truth);
  const Estimate estimate = EstimateByDifferencing(MakeCalibrationProblem(setup.robot, data, setup.experiment));
  EXPECT_FALSE(IsUsable(estimate.status));
  EXPECT_NE(estimate.message.find("no difference"), std::string::npos) << estimate.message;
}

}  // namespace
}  // namespace sagitta::differencing_test
