#include "estimator/least_squares/identifiability.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sagitta::identifiability_test {
namespace {

// Two geometric lengths a, b and one marker coordinate family to name columns.
ParameterSet TwoLengths() { return ParameterSet({}, {}, {{"geometry/a"}, {"geometry/b"}}); }

Linearization FromMatrix(const Eigen::MatrixXd& jacobian) {
  Linearization linearization;
  linearization.jacobian = jacobian;
  linearization.residual = Eigen::VectorXd::Zero(jacobian.rows());
  for (int c = 0; c < jacobian.cols(); ++c) linearization.columns.push_back(c);
  return linearization;
}

TEST(Identifiability, SumOnly) {
  Eigen::MatrixXd jacobian(3, 2);
  jacobian << 1, 1, 2, 2, -1, -1;
  const Unidentifiable found = FindUnidentifiable(FromMatrix(1e4 * jacobian), TwoLengths(), 1.0);
  ASSERT_EQ(found.columns.size(), 1u);
  EXPECT_TRUE(std::isinf(found.directions[0].sigma));
  EXPECT_NE(found.directions[0].words.find("only their sum is measured"), std::string::npos)
      << found.directions[0].words;
}

TEST(Identifiability, DifferenceOnly) {
  Eigen::MatrixXd jacobian(3, 2);
  jacobian << 1, -1, 2, -2, -1, 1;
  const Unidentifiable found = FindUnidentifiable(FromMatrix(1e4 * jacobian), TwoLengths(), 1.0);
  ASSERT_EQ(found.directions.size(), 1u);
  EXPECT_NE(found.directions[0].words.find("only their difference is measured"), std::string::npos)
      << found.directions[0].words;
}

// The decision is relative to the noise: sigma of b is 1 / 150 m = 6.7 mm > 5 mm.
TEST(Identifiability, DecidedRelativeToTheNoise) {
  Eigen::MatrixXd jacobian(3, 2);
  jacobian << 1e4, 0, 0, 150, 0, 0;
  const ParameterSet parameters = TwoLengths();
  const Unidentifiable noisy = FindUnidentifiable(FromMatrix(jacobian), parameters, 1.0);
  ASSERT_EQ(noisy.columns.size(), 1u);
  EXPECT_EQ(noisy.columns[0], 1);
  EXPECT_NEAR(noisy.directions[0].sigma, 1.0 / 150 / 5e-3, 1e-9);
  EXPECT_TRUE(FindUnidentifiable(FromMatrix(jacobian), parameters, 0.5).columns.empty());
}

// Three that do the same: noise makes any of them the largest of what is lost by a few per cent, and the first two are
// held all the same.
TEST(Identifiability, OfColumnsThatDoTheSameTheFirstIsHeld) {
  const ParameterSet parameters({}, {}, {{"geometry/a"}, {"geometry/b"}, {"geometry/c"}, {"geometry/d"}});
  for (const double off : {0.0, -0.05, 0.05}) {
    Eigen::MatrixXd jacobian(2, 4);
    jacobian << 1, 0, 0, 0, 0, 1, 1 + off, 1;
    const Unidentifiable found = FindUnidentifiable(FromMatrix(1e5 * jacobian), parameters, 1.0);
    EXPECT_EQ(found.columns, (std::vector<int>{1, 2})) << off;
  }
}

// A prior so wide that it says nothing, or a limit of what hardly moves anything, is no reason to hold others.
TEST(Identifiability, AWidePriorHoldsNothingElse) {
  Eigen::MatrixXd jacobian(3, 2);
  jacobian << 1e4, 2e3, 5e3, 1e4, 0, 0;
  for (const double wide : {1e3, 1e14, 1e155}) {
    ParameterSet parameters = TwoLengths();
    parameters.coordinate(0).prior_sigma = wide;
    jacobian(2, 0) = 1.0 / wide;
    EXPECT_TRUE(FindUnidentifiable(FromMatrix(jacobian), parameters, 1.0).columns.empty()) << wide;
    Eigen::MatrixXd without = jacobian;
    without.col(1).setZero();
    const Unidentifiable found = FindUnidentifiable(FromMatrix(without), parameters, 1.0);
    EXPECT_EQ(found.columns, std::vector<int>{1}) << wide;
  }
}

TEST(Identifiability, UnmeasuredColumnIsNamed) {
  Eigen::MatrixXd jacobian(3, 2);
  jacobian << 1e4, 0, 1e4, 0, 2e4, 0;
  const Unidentifiable found = FindUnidentifiable(FromMatrix(jacobian), TwoLengths(), 1.0);
  ASSERT_EQ(found.directions.size(), 1u);
  EXPECT_EQ(found.directions[0].words, "geometry/b is not measured by these data");
}

TEST(Identifiability, WeakDirectionsAreReported) {
  Eigen::MatrixXd jacobian(3, 2);
  jacobian << 1e4, 0, 0, 500, 0, 0;  // b: 2 mm
  const std::vector<Direction> weak = FindWeak(FromMatrix(jacobian), TwoLengths(), 1.0);
  ASSERT_EQ(weak.size(), 1u);
  EXPECT_EQ(weak[0].components[0].first, "geometry/b");
}

// Two that are both poor, in whatever mixture the decomposition has them, are poor each by itself: "only their sum" and
// "only their difference" would contradict each other.
TEST(Identifiability, TwoThatAreBothPoorAreNamedEachByItself) {
  Eigen::MatrixXd jacobian(2, 2);
  jacobian << 500, 100, -80, 400;
  const std::vector<Direction> weak = FindWeak(FromMatrix(jacobian), TwoLengths(), 1.0);
  ASSERT_EQ(weak.size(), 2u);
  for (const Direction& direction : weak) {
    ASSERT_EQ(direction.components.size(), 1u) << direction.words;
    EXPECT_EQ(direction.words, direction.components[0].first + " is measured poorly");
    EXPECT_GT(direction.sigma, 1.0);
  }
  EXPECT_NE(weak[0].words, weak[1].words);
}

TEST(LinearSolution, MatchesTheNormalEquations) {
  Eigen::MatrixXd jacobian(4, 2);
  jacobian << 1, 2e6, 0, 1e6, 3, -1e6, 1, 1e6;
  Linearization linearization = FromMatrix(jacobian);
  linearization.residual << 1, -2, 0.5, 3;
  const LinearSolution solution = SolveLinearization(linearization);
  const Eigen::MatrixXd covariance = (jacobian.transpose() * jacobian).inverse();
  EXPECT_LT((solution.covariance - covariance).norm(), 1e-9 * covariance.norm());
  const Eigen::VectorXd step = -covariance * jacobian.transpose() * linearization.residual;
  EXPECT_LT((solution.step - step).norm(), 1e-9 * step.norm());
  EXPECT_NEAR(solution.residual_norm_squared, (jacobian * step + linearization.residual).squaredNorm(), 1e-9);
}

}  // namespace
}  // namespace sagitta::identifiability_test
