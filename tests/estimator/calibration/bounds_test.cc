// Values on their bounds, by hand: columns that do not touch each other.
#include "estimator/calibration/bounds.h"

#include <gtest/gtest.h>

#include "tests/support/kr270_experiment.h"

namespace sagitta::bounds_test {
namespace {

constexpr double kScale = 1.3;

// Two columns: sigma 1/2 and 1, the first rests on its bound. Of the residual (12, 0, 3, 4) the first explains 12 of
// 13: d = -6, |r + J d| / |r| = 5/13.
class Bounds : public ::testing::Test {
 protected:
  Bounds()
      : problem_(test::Kr270Problem(test::Kr270Design(), test::Kr270Truth(), 1)), parameters_(problem_.parameters) {
    fit_.columns = {4, 6};
    fit_.jacobian = Eigen::MatrixXd::Zero(4, 2);
    fit_.jacobian(0, 0) = 2.0;
    fit_.jacobian(1, 1) = 1.0;
    fit_.residual = Eigen::Vector4d(12.0, 0.0, 3.0, 4.0);
    parameters_.coordinate(4).lower = parameters_.Value(4);
  }
  std::vector<BelowBound> Found(double least) const { return FindBelowBounds(fit_, parameters_, kScale, least); }

  CalibrationProblem problem_;
  ParameterSet parameters_;
  Linearization fit_;
};

TEST_F(Bounds, WhatTheBoundCostsIsNoNoise) {
  // 1.3 x 5/13 = 0.5 of the whitening sigmas.
  const std::vector<BelowBound> found = Found(0.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].coordinate, 4);
  EXPECT_NEAR(found[0].sigmas, 12.0 / 0.5, 1e-9);
}

TEST_F(Bounds, NoiseIsNotBelowTheStatedOne) {
  const std::vector<BelowBound> found = Found(1.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].sigmas, 12.0, 1e-9);
  EXPECT_TRUE(Found(3.1).empty()) << "12 / 3.1 is less than four standard deviations";
}

TEST_F(Bounds, WhatTheDataWantAboveItsBoundIsNotBelow) {
  fit_.residual[0] = -12.0;
  EXPECT_TRUE(Found(0.0).empty());
}

TEST_F(Bounds, WhatIsOffItsBoundIsFree) {
  parameters_.coordinate(4).lower = parameters_.Value(4) - 1e-9;
  EXPECT_TRUE(Found(0.0).empty());
}

}  // namespace
}  // namespace sagitta::bounds_test
