// Whether points of one shot err alike: against the matrices written out, and on arms that scatter and that do not.
#include "estimator/agreement/shared_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/agreement/agreement.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/linearization.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::shared_errors_test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// Joints that scatter by so much (rad) from arrival to arrival, which nothing states.
CalibrationProblem Scattering(double scatter, std::uint64_t seed) {
  test::Kr270Design design;
  design.configurations = 30;
  Measurements data = test::DesignMeasurements(design);
  Measurements arrived = data;
  NormalNumbers normal(seed);
  for (Configuration& configuration : arrived.configurations) {
    for (double& q : configuration.q) q += scatter * normal();
  }
  test::MeasureKr270(test::Kr270Truth(), design.sigma, seed, &arrived);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    data.observations[i].point_in_station = arrived.observations[i].point_in_station;
  }
  return test::Kr270ProblemOf(data, Experiment());
}

AgreementReport ReportOf(const CalibrationProblem& problem, Estimate* estimate) {
  CheckAgreement(problem, {}, estimate);
  return estimate->agreement;
}

TEST(SharedErrors, IsAQuadraticFormOverItsDeviation) {
  const CalibrationProblem problem = Scattering(20e-6, 5);
  Estimate estimate = EstimateJointly(problem);
  const std::vector<int> rows = problem.CalibrationObservations();
  const Linearization at = Linearize(problem, estimate.parameters, rows, estimate.estimated,
                                     ObservationNoise(problem, rows, 1e-3), LatentTreatment::kIgnore);
  const auto n = at.jacobian.rows(), p = at.jacobian.cols();
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n / 3; ++i) {
    for (Eigen::Index k = 0; k < n / 3; ++k) {
      const bool together = problem.data().observations[rows[i]].shot == problem.data().observations[rows[k]].shot;
      if (together && i != k) w.block(3 * i, 3 * k, 3, 3).setIdentity();
    }
  }
  const Eigen::MatrixXd m =
      Eigen::MatrixXd::Identity(n, n) -
      at.jacobian * (at.jacobian.transpose() * at.jacobian).ldlt().solve(Eigen::MatrixXd(at.jacobian.transpose()));
  const double nu = static_cast<double>(n - p), variance = at.residual.squaredNorm() / nu;
  const Eigen::MatrixXd mw = m * w;
  const double expected = (at.residual.dot(w * at.residual) / variance - mw.trace()) /
                          std::sqrt(2.0 * ((mw * mw).trace() - mw.trace() * mw.trace() / nu));
  EXPECT_NEAR(ReportOf(problem, &estimate).shared_errors, expected, 1e-6 * std::abs(expected));
}

// 100 sound arms: the mean of a normal number is off by 0.1 (one standard error), 0.4 at most; its square is 1 +- 0.14.
TEST(SharedErrors, OfSoundArmsIsANormalNumber) {
  double sum = 0.0, squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const CalibrationProblem problem = Scattering(0.0, seed);
    Estimate estimate = EstimateJointly(problem);
    const double z = ReportOf(problem, &estimate).shared_errors;
    sum += z, squares += z * z;
  }
  EXPECT_NEAR(sum / 100.0, 0.0, 0.4);
  EXPECT_NEAR(squares / 100.0, 1.0, 0.6);
}

TEST(SharedErrors, OfJointsThatScatterAreSaid) {
  const auto advice = Contains(HasSubstr("repeatability_urad: estimate"));
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const CalibrationProblem problem = Scattering(60e-6, seed);
    Estimate estimate = EstimateJointly(problem);
    const AgreementReport report = ReportOf(problem, &estimate);
    EXPECT_GT(report.shared_errors, 3.0);
    EXPECT_TRUE(report.sandwich_advised);
    EXPECT_THAT(report.words, advice);
  }
}

}  // namespace
}  // namespace sagitta::shared_errors_test
