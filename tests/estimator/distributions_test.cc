#include "estimator/statistics/distributions.h"

#include <gtest/gtest.h>

#include <limits>

namespace sagitta {
namespace {

// Table values: Abramowitz and Stegun, tables 26.7, 26.8, 26.10.
TEST(Distributions, TableValues) {
  EXPECT_NEAR(NormalQuantile(0.975), 1.959963985, 1e-8);
  EXPECT_NEAR(StudentQuantile(0.975, 1), 12.7062, 1e-3);
  EXPECT_NEAR(StudentQuantile(0.975, 10), 2.228139, 1e-5);
  EXPECT_NEAR(StudentQuantile(0.025, 10), -2.228139, 1e-5);
  EXPECT_NEAR(StudentQuantile(0.995, 30), 2.749996, 1e-5);
  EXPECT_NEAR(ChiSquareSurvival(18.307, 10), 0.05, 1e-5);
  EXPECT_NEAR(ChiSquareQuantile(0.95, 10), 18.3070, 1e-3);
  EXPECT_NEAR(ChiSquareQuantile(0.01, 3), 0.114832, 1e-5);
  EXPECT_NEAR(FSurvival(3.70826, 3, 10), 0.05, 1e-5);
  EXPECT_NEAR(FSurvival(5.84893, 2, 20), 0.01, 1e-5);
  EXPECT_NEAR(FSurvival(161.448, 1, 1), 0.05, 1e-5);
  EXPECT_NEAR(FQuantile(0.95, 3, 10), 3.70826, 1e-5);
  EXPECT_NEAR(FQuantile(0.99, 2, 20), 5.84893, 1e-5);
  const double exact = std::numeric_limits<double>::infinity();
  EXPECT_NEAR(FSurvival(1.8307, 10, exact), 0.05, 1e-5);
  EXPECT_NEAR(FQuantile(0.95, 10, exact), 1.83070, 1e-4);
}

TEST(Distributions, StudentTendsToNormal) { EXPECT_NEAR(StudentQuantile(0.975, 1e5), NormalQuantile(0.975), 5e-5); }

}  // namespace
}  // namespace sagitta
