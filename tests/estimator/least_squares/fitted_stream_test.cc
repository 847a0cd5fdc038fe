// What judges an estimate looks at the rows that were fitted, where they are at hand and where they are not; and what
// it asks of some of many rows.
#include <gtest/gtest.h>

#include "estimator/least_squares/ceres_problem.h"
#include "estimator/least_squares/normal_equations.h"
#include "estimator/least_squares/sample.h"
#include "problems/excitation.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/kr270_poses.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::fitted_stream_test {
namespace {

// One shot of each configuration.
CalibrationProblem Rigid(int configurations) {
  test::Kr270Design design;
  design.configurations = configurations;
  return test::Kr270Problem(design, test::Kr270Truth(), 11);
}

// Several shots of each.
CalibrationProblem Loaded() {
  const test::LoadedTruth truth = test::Everything();
  const test::LoadedDesign design = test::WithPulls();
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), design.sigma, 5, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  return MakeCalibrationProblem(setup.robot, data, setup.experiment);
}

std::vector<int> FreeOf(const CalibrationProblem& problem) { return problem.parameters.EstimatedCoordinates(); }

// Each row once, and those of one configuration in one piece where that is asked for.
void ExpectRowsOfTheFit(const CalibrationProblem& problem, const FittedStream& fitted) {
  const std::vector<int> columns = FreeOf(problem), all = problem.CalibrationObservations();
  const Linearization rows =
      Linearize(problem, problem.parameters, all, columns, FitRoots(problem, all, kFallbackSigma));
  ASSERT_EQ(fitted.observations(), all);
  std::vector<int> seen(all.size(), 0), piece_of(all.size(), -1);
  int pieces = 0;
  const auto look_at = [&](const RowPiece& piece) {
    for (int i = 0; i < piece.num_observations(); ++i) {
      const int k = piece.positions[i];
      ++seen[k];
      piece_of[k] = pieces;
      const auto n = static_cast<Eigen::Index>(columns.size());
      const Eigen::MatrixXd own = piece.rows.middleRows(3 * i, 3);
      EXPECT_LT((own.leftCols(n) - rows.jacobian.middleRows(3 * k, 3)).norm(), 1e-9 * own.leftCols(n).norm());
      EXPECT_LT((own.col(n) - rows.residual.segment<3>(3 * k)).norm(), 1e-9 * rows.residual.norm());
    }
    ++pieces;
  };
  ASSERT_TRUE(fitted.ForEach(problem.parameters, columns, look_at));
  for (int& times : seen) EXPECT_EQ(std::exchange(times, 0), 1);
  ASSERT_TRUE(fitted.ForEachOfClusters(problem.parameters, columns,
                                       [&](const RowPiece& piece, const Share&) { look_at(piece); }));
  std::vector<int> piece_of_cluster(all.size(), -1);
  for (size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(seen[k], 1);
    int& piece = piece_of_cluster[static_cast<size_t>(fitted.clusters()[k])];
    if (piece < 0) piece = piece_of[k];
    EXPECT_EQ(piece_of[k], piece);
  }
}

// Also where the problem has moved in between: the rows go by what it was given.
TEST(FittedStream, HasTheRowsOfTheFit) {
  for (CalibrationProblem made : {Rigid(700), Loaded()}) {
    ExpectRowsOfTheFit(made, FittedStream(made));
    const ResidualSelection selected = CalibrationResiduals(made, kFallbackSigma);
    std::shared_ptr<const RowBatches> at_hand;
    {
      const NormalEquations equations(made, selected.observations, selected.noise, LatentTreatment::kMarginalise, 1);
      at_hand = equations.shared_batches();
    }
    const CalibrationProblem moved = std::move(made);
    ExpectRowsOfTheFit(moved, FittedStream(moved, at_hand));
  }
}

TEST(SampleForStep, IsAllThatCanBeHeldOrKnowsAStepToATenthOfTheNoise) {
  const CalibrationProblem few = Rigid(100), many = Rigid(8000);
  const std::vector<int> of_few = few.CalibrationObservations(), of_many = many.CalibrationObservations();
  EXPECT_EQ(SampleForStep(few.data(), of_few, 60), of_few);
  const size_t rows = 3 * SampleForStep(many.data(), of_many, 60).size();
  EXPECT_GT(rows, 80u * 60u);
  EXPECT_LT(rows, 120u * 60u);
}

// Some rows that show every motion clearly spare the others a question, and no limit changes by that; some of all are
// less than all, or equal.
TEST(HoldLimits, AreThoseOfAllRowsWhereSomeAreAskedFirst) {
  const CalibrationProblem problem = Loaded();
  const std::vector<int> all = problem.CalibrationObservations();
  const RowBatches rows(problem, all, FitRoots(problem, all, kFallbackSigma), LatentTreatment::kMarginalise);
  const auto of_all = [&](const std::vector<ParameterSet>& at) { return rows.LargestMotions(at); };
  const auto of_some = [&](const std::vector<ParameterSet>& at) { return rows.LargestMotions(at, 2); };
  ParameterSet plain = problem.parameters, asked = problem.parameters;
  SetHoldLimits(problem, of_all, nullptr, &plain);
  SetHoldLimits(problem, of_all, of_some, &asked);
  for (int i = 0; i < plain.num_coordinates(); ++i) {
    EXPECT_EQ(plain.coordinates()[i].hold_limit, asked.coordinates()[i].hold_limit) << plain.coordinates()[i].name;
  }
  const std::vector<double> largest = of_all({plain})[0], some = of_some({plain})[0];
  for (size_t i = 0; i < largest.size(); ++i) EXPECT_LE(some[i], largest[i]);
  EXPECT_EQ(rows.LargestMotions({plain}, 1 << 20)[0], largest);
}

}  // namespace
}  // namespace sagitta::fitted_stream_test
