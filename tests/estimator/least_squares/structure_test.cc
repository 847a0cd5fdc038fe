// Which factorisation a problem gets, and that it does not matter for what comes out.
#include "estimator/least_squares/structure.h"

#include <gtest/gtest.h>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/condensed_cost.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::structure_test {
namespace {

// The arm seen from as many places, which all call themselves by another name but stand where the first one does.
CalibrationProblem SeenFrom(int stations, int configurations) {
  test::LoadedTruth truth;
  test::LoadedDesign design;
  design.configurations = configurations;
  Measurements data = test::LoadedRows(design, truth);
  for (Shot& shot : data.shots) shot.station = 0;
  test::Measure(test::ExactPoints(truth, data), design.sigma, 5, &data);
  data.stations.clear();
  for (int s = 0; s < stations; ++s) data.stations.push_back("S" + std::to_string(s));
  const auto shots = static_cast<int>(data.shots.size());
  for (int s = 0; s < shots; ++s) data.shots[s].station = s * stations / shots;
  const test::LoadedSetup setup = test::SetupFor(truth);
  return MakeCalibrationProblem(setup.robot, data, setup.experiment);
}

Structure Of(const CalibrationProblem& problem) {
  return StructureOf(problem, CalibrationResiduals(problem), problem.parameters);
}

TEST(Structure, CountsWhatAReadingTouches) {
  const CalibrationProblem problem = SeenFrom(20, 40);
  const Structure structure = Of(problem);
  const int markers = 3, model = structure.unknowns - 20 * 6 - markers * 3;
  EXPECT_GT(model, 20);  // geometry and six compliances
  EXPECT_EQ(structure.rows, 40 * 2 * markers * 3);
  EXPECT_NEAR(structure.touched, (model + 6 + 3.0) / structure.unknowns, 1e-12);
  EXPECT_TRUE(structure.IsSparse());
  EXPECT_FALSE(Of(SeenFrom(2, 40)).IsSparse());
  EXPECT_TRUE(structure.IsSparserThanSums());
  Structure long_one = structure;
  long_one.rows *= 100;  // sums cost next to nothing per row
  EXPECT_FALSE(long_one.IsSparserThanSums());
}

TEST(Structure, SparseFactorsAndSumsHaveOneOptimum) {
  const CalibrationProblem problem = SeenFrom(20, 40);
  ASSERT_TRUE(Of(problem).IsSparserThanSums());
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  ParameterSet parameters = problem.parameters;
  AlignNominal(problem, &parameters);
  const ResidualSelection rows = CalibrationResiduals(problem);
  const NormalEquations equations(problem, rows.observations, rows.noise, LatentTreatment::kMarginalise, 1);
  const MinimizeSummary summary = MinimizeSums(equations, MinimizeOptions(), &parameters);
  ASSERT_TRUE(summary.converged) << summary.message;
  EXPECT_NEAR(summary.final_cost / estimate.cost, 1.0, 1e-8);
  for (size_t c = 0; c < estimate.estimated.size(); ++c) {
    const ParameterEstimate& row = estimate.table[estimate.estimated[c]];
    if (row.quantity == Quantity::kRotationVector) continue;  // their values are not additive
    EXPECT_NEAR(parameters.Value(estimate.estimated[c]), row.value, 0.01 * row.sigma) << row.name;
  }
}

}  // namespace
}  // namespace sagitta::structure_test
