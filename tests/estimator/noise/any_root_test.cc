// Of the roots of one covariance none is better than another.
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/sagitta.h"
#include "tests/support/in_memory.h"

namespace sagitta::any_root_test {
namespace {

Estimate EstimateWith(const Matrix3<double>& turned) {
  CalibrationProblem problem =
      MakeCalibrationProblem(test::ArmInMemory(), test::ReadingsInMemory(test::ArmInMemory()), {});
  const Matrix3<double> root = Vector3<double>(2e-5, 3e-5, 5e-5).asDiagonal();
  problem.resolved_noise.assign(problem.data().observations.size(), root * turned);
  return Calibrate(problem).estimate;
}

// S Q (S Q)' = S S' for each orthogonal Q, whatever its determinant: eigenvectors have either sign.
TEST(AnyRoot, StatesTheNoiseWhateverItsDeterminant) {
  const Estimate expected = EstimateWith(Matrix3<double>::Identity());
  ASSERT_TRUE(expected.sigma.stated);
  const Matrix3<double> turn = Eigen::AngleAxisd(0.7, Vector3<double>(1, 2, 3).normalized()).toRotationMatrix();
  for (const Matrix3<double>& turned : {turn, Matrix3<double>(-turn), Matrix3<double>(-Matrix3<double>::Identity())}) {
    const Estimate estimate = EstimateWith(turned);
    EXPECT_TRUE(estimate.sigma.stated);
    ASSERT_EQ(estimate.table.size(), expected.table.size());
    for (size_t i = 0; i < estimate.table.size(); ++i) {
      const ParameterEstimate &one = estimate.table[i], &other = expected.table[i];
      EXPECT_NEAR(one.value, other.value, 1e-4 * other.sigma + 1e-15) << other.name;
      EXPECT_NEAR(one.sigma, other.sigma, 1e-5 * other.sigma) << other.name;
    }
  }
}

}  // namespace
}  // namespace sagitta::any_root_test
