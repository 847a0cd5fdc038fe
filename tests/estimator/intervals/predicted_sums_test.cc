// What errors of unseen points are expected to be, against the covariance of all these points written out.
#include "estimator/intervals/predicted_sums.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/validation/trust.h"
#include "tests/support/judged.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::predicted_sums_test {
namespace {

// Joints that deviate by 60 urad at every arrival: three markers of a pose share that.
CalibrationProblem Deviating(double held_out) {
  test::Kr270Design design;
  design.configurations = 30;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 7, &data);
  Experiment experiment;
  experiment.repeatability.angle.common = 60e-6;
  if (held_out > 0.0) {
    experiment.validation.kind = ValidationSpec::Kind::kFraction;
    experiment.validation.fraction = held_out;
  }
  return test::Kr270ProblemOf(data, experiment);
}

// Of the rows: J in m, and the covariance of their readings, m^2: S S' + L_i L_k' for points of one arrival.
struct DenseRows {
  Eigen::MatrixXd jacobian, noise;
};
DenseRows DenseOf(const CalibrationProblem& problem, const Estimate& estimate, const std::vector<int>& rows) {
  const NoiseRoots metres(rows.size(), Matrix3<double>::Identity());
  const Linearization all =
      Linearize(problem, estimate.parameters, rows, estimate.estimated, metres, LatentTreatment::kIgnore);
  DenseRows dense{all.jacobian, Eigen::MatrixXd::Zero(all.jacobian.rows(), all.jacobian.rows())};
  const auto visit_of = [&](size_t k) {
    const Shot& shot = problem.data().shots[problem.data().observations[rows[k]].shot];
    return std::make_pair(shot.configuration, shot.visit);
  };
  for (size_t i = 0; i < rows.size(); ++i) {
    for (size_t k = 0; k < rows.size(); ++k) {
      const auto a = static_cast<Eigen::Index>(3 * i), b = static_cast<Eigen::Index>(3 * k);
      if (visit_of(i) != visit_of(k)) continue;
      dense.noise.block(a, b, 3, 3) = all.latent.middleRows(a, 3) * all.latent.middleRows(b, 3).transpose();
      if (i == k) dense.noise.block(a, a, 3, 3) += estimate.noise[rows[i]] * estimate.noise[rows[i]].transpose();
    }
  }
  return dense;
}

PredictedSquares SquaresOf(const Eigen::MatrixXd& v) {
  PredictedSquares squares;
  squares.trace = v.trace();
  squares.trace_of_square = (v * v).trace();
  return squares;
}

TEST(PredictedSums, HeldOutPointsShareTheDeviationsOfTheirArrival) {
  const CalibrationProblem problem = Deviating(0.3);
  Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(estimate.held.coordinates.empty());
  const DenseRows dense = DenseOf(problem, estimate, problem.ValidationObservations());
  const PredictedSquares expected =
      SquaresOf(dense.jacobian * estimate.covariance * dense.jacobian.transpose() + dense.noise);
  const UnseenPoints holdout = test::JudgeTrust(problem, 1, &estimate).holdout;
  EXPECT_NEAR(holdout.freedom / expected.Freedom(), 1.0, 1e-9);
  EXPECT_NEAR(3.0 * holdout.points * holdout.predicted_rms * holdout.predicted_rms / expected.trace, 1.0, 1e-9);
}

// e = E n of all points, each predicted by the fit of the other folds: E is 1 within a fold, and
// -J_f (J_o' C_oo^-1 J_o)^-1 J_o' C_oo^-1 of the others. V = E C E'.
TEST(PredictedSums, PointsOfAFoldShareThemAndFoldsShareTheirRows) {
  const CalibrationProblem problem = Deviating(0.0);
  Estimate estimate = EstimateJointly(problem);
  const std::vector<int> rows = problem.CalibrationObservations(), fold_of = FoldsOf(problem, 1);
  const DenseRows dense = DenseOf(problem, estimate, rows);
  Eigen::MatrixXd errors = Eigen::MatrixXd::Identity(dense.noise.rows(), dense.noise.rows());
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<Eigen::Index> own, others;
    for (size_t k = 0; k < rows.size(); ++k) {
      const bool is_own =
          fold_of[problem.data().shots[problem.data().observations[rows[k]].shot].configuration] == fold;
      for (int axis = 0; axis < 3; ++axis) (is_own ? own : others).push_back(static_cast<Eigen::Index>(3 * k) + axis);
    }
    const Eigen::MatrixXd j = dense.jacobian(others, Eigen::all);
    const Eigen::MatrixXd weighed = Eigen::MatrixXd(dense.noise(others, others)).llt().solve(j);
    const Eigen::MatrixXd gain = Eigen::MatrixXd(j.transpose() * weighed).ldlt().solve(weighed.transpose());
    errors(own, others) = -dense.jacobian(own, Eigen::all) * gain;
  }
  const PredictedSquares expected = SquaresOf(errors * dense.noise * errors.transpose());
  const UnseenPoints unseen = test::JudgeTrust(problem, 1, &estimate).cross_validation.unseen;
  EXPECT_NEAR(unseen.freedom / expected.Freedom(), 1.0, 1e-6);
  EXPECT_NEAR(3.0 * unseen.points * unseen.predicted_rms * unseen.predicted_rms / expected.trace, 1.0, 1e-6);
}

// Of parameters that are held the same columns are left open: a hold-out is predicted to be off by these too.
TEST(PredictedSums, WhatHeldParametersLeaveOpenIsExpected) {
  test::Kr270Design design;
  design.configurations = 24;
  Measurements data = test::DesignMeasurements(design);
  for (Configuration& configuration : data.configurations) {
    if (!configuration.is_validation) configuration.q[5] = 0.3;  // A6 stands where it is fitted
  }
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 9, &data);
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  const CalibrationProblem problem = test::Kr270ProblemOf(data, experiment);
  Estimate estimate = EstimateJointly(problem);
  ASSERT_FALSE(estimate.held.coordinates.empty());
  const UnseenPoints holdout = test::JudgeTrust(problem, 1, &estimate).holdout;
  EXPECT_NEAR(holdout.predicted_rms / estimate.validation_predicted_rms, 1.0, 1e-6);
}

}  // namespace
}  // namespace sagitta::predicted_sums_test
