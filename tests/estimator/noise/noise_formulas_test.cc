// Formulas of noise and robust losses at numbers computed by hand, and their use recomputed.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "estimator/calibration/noise_loop.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/noise/residual_noise.h"
#include "estimator/noise/robust.h"
#include "tests/support/noise_experiment.h"

namespace sagitta::noise_formulas_test {
namespace {

TEST(NoiseFormulas, LossesAtADistance) {
  EXPECT_EQ(LossWeight(LossKind::kHuber, 2.0), 1.0);
  EXPECT_NEAR(LossWeight(LossKind::kHuber, 4.2), 0.5, 1e-15);  // 2.1 / 4.2
  EXPECT_EQ(LossDerivative(LossKind::kHuber, 2.0), 1.0);
  EXPECT_EQ(LossDerivative(LossKind::kHuber, 4.2), 0.0);
  EXPECT_NEAR(LossWeight(LossKind::kCauchy, 2.67), 0.5, 1e-15);
  EXPECT_NEAR(LossWeight(LossKind::kCauchy, 2 * 2.67), 0.2, 1e-15);  // 1 / (1 + 4)
  EXPECT_NEAR(LossDerivative(LossKind::kCauchy, 2.67), 0.0, 1e-15);
  EXPECT_NEAR(LossDerivative(LossKind::kCauchy, 2 * 2.67), -0.12, 1e-15);  // (1 - 4) / 25
}

// Distances 1 and 4.2 with Huber: psi 1 and 2.1, psi' 1 and 0, psi/r 1 and 0.5.
//   mean psi^2 / 3 = (1 + 4.41) / 6 = 0.901667, slope (3/3 + 1/3) / 2 = 0.666667, mean r^2 / 3 = (1 + 17.64) / 6
TEST(NoiseFormulas, PriceOfALoss) {
  PointCheck check;
  check.distance = {1.0, 4.2};
  check.expected = {1.0, 1.0};
  const double by_hand = (5.41 / 6) / std::pow(2.0 / 3, 2) / (18.64 / 6);
  EXPECT_NEAR(LossInflation(LossKind::kHuber, check, {true, true}), by_hand, 1e-12);
  // Of one kept: sum psi^2 / (sum slope)^2 over r^2 of the first, both per estimate and not per row.
  EXPECT_NEAR(LossInflation(LossKind::kHuber, check, {true, false}), (5.41 / 3) / std::pow(4.0 / 3, 2) / (1.0 / 3),
              1e-12);
}

// The median of chi-square with three degrees of freedom is 2.36597; half the rows follow a deviation by half.
TEST(NoiseFormulas, RobustScale) {
  PointCheck check;
  check.distance = {1.0, 2.0, 3.0, 50.0, 0.1};
  check.expected = {1.0, 1.0, 1.0, 1.0, 1.0};
  EXPECT_NEAR(RobustScale(check), std::sqrt(4.0 / 2.365974), 1e-6);
  check.expected = {0.25, 1.0, 1.0, 1.0, 1.0};  // 1 / 0.25 = 4 too
  EXPECT_NEAR(RobustScale(check), std::sqrt(4.0 / 2.365974), 1e-6);
}

// w = s0 / (s0 + lambda s): 0.01 / (0.01 + 2.5 x 0.03).
TEST(NoiseFormulas, WeightsOfEquation14) {
  EXPECT_NEAR(Eq14Weight(1e-5, 2.5, 3e-5), 1.0 / 8.5, 1e-15);
  EXPECT_NEAR(Eq14Weight(0.0, 2.5, 3e-5), 1.0 / 3e-5, 1e-8);
  NoiseRoots spread = {Vector3<double>(1e-5, 2e-5, 4e-5).asDiagonal()};
  const Matrix3<double> root = Eq14Roots(spread, 1e-5, 0.5)[0];
  EXPECT_LT((root.diagonal() - Vector3<double>(1.5e-5, 2e-5, 3e-5)).norm(), 1e-18);
}

// s^2 = sum r^2 / sum (1 - h) per axis, h from a dense QR: 39 unknowns absorb a quarter of 162 equations.
TEST(NoiseFormulas, SpreadOfResidualsCountsWhatTheFitLeaves) {
  const CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), test::Kr270Truth(), 6);
  const Estimate estimate = EstimateJointly(problem);
  const std::vector<int> rows = problem.CalibrationObservations();
  const Linearization fit = Linearize(problem, estimate.parameters, rows, estimate.estimated,
                                      NoiseRoots(rows.size(), Matrix3<double>::Identity()));
  const Eigen::MatrixXd scaled = fit.jacobian * fit.jacobian.colwise().norm().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(scaled).householderQ() *
                            Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols());
  Vector3<double> squares = Vector3<double>::Zero(), left = squares;
  for (size_t k = 0; k < rows.size(); ++k) {
    const Vector3<double> r = problem.data().observations[rows[k]].point_in_station - estimate.predicted.col(rows[k]);
    squares += r.cwiseAbs2();
    for (int a = 0; a < 3; ++a) left[a] += 1.0 - q.row(3 * static_cast<long>(k) + a).squaredNorm();
  }
  EXPECT_NEAR(left.sum(), 162 - 39, 1e-6);
  std::vector<NoiseGroup> report;
  SpreadOfResiduals(problem, estimate, GroupRows(problem.data(), ResidualGroup::kAxis), &report);
  ASSERT_EQ(report.size(), 3u);
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(report[a].sigma, std::sqrt(squares[a] / left[a]), 1e-9) << a;
}

// With a loss: the covariance of least squares on the rows that are kept, times the loss's price.
TEST(NoiseFormulas, PriceOfTheLossIsInTheCovariance) {
  for (const char* loss : {"huber", "cauchy"}) {
    Measurements data = test::DesignMeasurements(test::Kr270Design());
    test::MeasureKr270(test::Kr270Truth(), 1e-4, 6, &data);
    test::Spoil(0.06, 3, &data);
    Experiment experiment;
    experiment.method.loss = *FindChoice<LossKind>(loss);
    const ResolvedEstimate result = EstimateWithNoise(test::Kr270ProblemOf(data, experiment));
    const Estimate& estimate = result.estimate;
    ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
    ASSERT_GT(estimate.noise_report.loss_inflation, 1.001);
    const std::vector<int> rows = result.problem.CalibrationObservations();
    const Linearization fit = Linearize(result.problem, estimate.parameters, rows, estimate.estimated,
                                        ObservationNoise(result.problem, rows, 1e-3));
    const Eigen::VectorXd scale = fit.jacobian.colwise().norm();
    const Eigen::MatrixXd scaled = fit.jacobian * scale.cwiseInverse().asDiagonal();
    const Eigen::VectorXd plain = (scaled.transpose() * scaled).inverse().diagonal().cwiseSqrt().cwiseQuotient(scale);
    const double factor =
        (estimate.sigma.scaled ? estimate.sigma.a_posteriori : 1.0) * std::sqrt(estimate.noise_report.loss_inflation);
    for (long c = 0; c < plain.size(); ++c) {
      EXPECT_NEAR(estimate.table[estimate.estimated[c]].sigma / (factor * plain[c]), 1.0, 1e-6) << c;
    }
  }
}

// An error about the measurement frame's x of a target that is turned by 90 deg about z: what pointed along x points
// along y, and then 1 mrad towards z.
TEST(NoiseFormulas, ARotationsErrorIsAboutTheAxesOfTheMeasurementFrame) {
  Observation rotation;
  rotation.kind = ReadingKind::kRotation;
  rotation.Read({0.0, 0.0, std::acos(0.0)}, {1e-3, 0.0, 0.0});
  const Vector3<double> along = rotation.rotation().in_station * Vector3<double>::UnitX();
  EXPECT_LT((along - Vector3<double>(0.0, std::cos(1e-3), std::sin(1e-3))).norm(), 1e-15);
}

}  // namespace
}  // namespace sagitta::noise_formulas_test
