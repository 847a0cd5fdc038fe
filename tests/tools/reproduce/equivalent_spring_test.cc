#include "tools/reproduce/equivalent_spring.h"

#include <gtest/gtest.h>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::equivalent_spring_test {
namespace {

constexpr SpringMounting kGeometry{0.18472, 0.68593, 0.12330};      // paper 002, Table V
constexpr double kNodes[5] = {-140, -99.85, -56.9, -25.24, -0.01};  // deg

// 1/k2 = 1/k0 + d2U/dq2, the second derivative by differences of the energy.
double EquivalentCompliance(const test::SpringTruth& spring, double k0, double q) {
  constexpr double h = 2e-3;
  const double stiffness = -(spring.Torque(q + h) - spring.Torque(q - h)) * 8 / (12 * h) +
                           (spring.Torque(q + 2 * h) - spring.Torque(q - 2 * h)) / (12 * h);
  return 1.0 / (1.0 / k0 + stiffness);
}

TEST(EquivalentSpring, RecoversTheSpringFromExactNodes) {
  const test::SpringTruth spring;
  std::vector<JointTwoNode> nodes;
  for (const double q : kNodes) {
    nodes.push_back({q * kDegree, EquivalentCompliance(spring, 0.302e-6, q * kDegree), 1e-9});
  }
  for (const SpringWeights weights : {SpringWeights::kEqual, SpringWeights::kSigma}) {
    const EquivalentSpring fit = FitEquivalentSpring(nodes, kGeometry, weights);
    ASSERT_TRUE(fit.solved);
    EXPECT_NEAR(fit.k0, 0.302e-6, 1e-9 * 0.302e-6);
    EXPECT_NEAR(fit.Kc, spring.Kc, 1e-7 * spring.Kc);
    EXPECT_NEAR(fit.s0, spring.s0, 1e-7 * spring.s0);
    EXPECT_LT(fit.rms, 1e-16);
  }
}

// PUBLISHED.md section 4: from the OLS nodes of paper 003, Table 3, unweighted.
TEST(EquivalentSpring, PublishedFitIsReproduced) {
  const double ols[5] = {0.251, 0.302, 0.315, 0.287, 0.297}, ci[5] = {0.020, 0.032, 0.018, 0.012, 0.010};
  const double wls[5] = {0.246, 0.293, 0.302, 0.277, 0.287}, wls_ci[5] = {0.0007, 0.0010, 0.0005, 0.0004, 0.0003};
  std::vector<JointTwoNode> nodes, weighted;
  for (int i = 0; i < 5; ++i) {
    nodes.push_back({kNodes[i] * kDegree, ols[i] * 1e-6, ci[i] * 1e-6 / 3});
    weighted.push_back({kNodes[i] * kDegree, wls[i] * 1e-6, wls_ci[i] * 1e-6 / 3});
  }
  const EquivalentSpring fit = FitEquivalentSpring(nodes, kGeometry);
  ASSERT_TRUE(fit.solved);
  EXPECT_NEAR(fit.k0 / 1e-6, 0.302, 0.004);  // published interval
  EXPECT_NEAR(1e6 / fit.Kc, 0.144, 0.031);   // um/N
  EXPECT_NEAR(fit.s0, 0.458, 0.027);
  // Intervals (3 sigma) from the nodes' own: kc +-.17, s0 +-145 mm.
  EXPECT_NEAR(3 * std::sqrt(fit.covariance(1, 1)) / (fit.Kc * fit.Kc) * 1e6, 0.17, 0.02);
  EXPECT_NEAR(3 * std::sqrt(fit.covariance(2, 2)), 0.145, 0.015);
  // Weighted by the WLS intervals it lands elsewhere: kc .32, s0 611 mm.
  const EquivalentSpring swapped = FitEquivalentSpring(weighted, kGeometry, SpringWeights::kSigma);
  ASSERT_TRUE(swapped.solved);
  EXPECT_NEAR(1e6 / swapped.Kc, 0.32, 0.02);
  EXPECT_NEAR(swapped.s0, 0.611, 0.012);
}

TEST(EquivalentSpring, TooFewNodesOrNoSpringIsNotSolved) {
  EXPECT_FALSE(FitEquivalentSpring({{0, 3e-7, 1e-9}, {-1, 3e-7, 1e-9}}, kGeometry).solved);
  const JointTwoNode same{-0.5, 3e-7, 1e-9};
  EXPECT_FALSE(FitEquivalentSpring({same, same, same, same}, kGeometry).solved);
  EXPECT_FALSE(FitEquivalentSpring({{0, 3e-7, 0}, {-1, 0, 0}, {-2, 3e-7, 0}}, kGeometry).solved);
  const std::vector<JointTwoNode> without_sigma = {{0, 3e-7, 0}, {-1, 3e-7, 0}, {-2, 3e-7, 0}};
  EXPECT_FALSE(FitEquivalentSpring(without_sigma, kGeometry, SpringWeights::kSigma).solved);
}

// k21 ... k25 in the joint solve, configurations at the five q2 only, and on to the spring.
TEST(EquivalentSpring, FromTheNodesOfAJointSolve) {
  const test::SpringTruth spring;
  test::LoadedTruth truth;
  truth.base_rotvec = {{0.0528, 0.01, 0.3}, {-0.04, 0.02, -1.0}};
  truth.k2_of_q2 = [&](double q) { return EquivalentCompliance(spring, 0.302e-6, q); };
  test::LoadedDesign design;
  design.configurations = 30;
  design.change = [](std::vector<Configuration>* configurations) {
    for (size_t c = 0; c < configurations->size(); ++c) (*configurations)[c].q[1] = kNodes[c % 5] * kDegree;
  };
  Measurements data = test::LoadedRows(design, truth);
  const std::vector<Vector3<double>> exact = test::ExactPoints(truth, data);
  test::Measure(exact, 0.0, 1, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  JointCompliance table{1, {}, true};
  for (const double q : kNodes) table.nodes.push_back({q * kDegree, 0.25e-6});
  setup.robot.compliances.push_back(table);
  CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  for (int seed = 0; seed <= 5; ++seed) {  // 0: no noise
    test::Measure(exact, seed == 0 ? 0.0 : design.sigma, seed, problem.mutable_data());
    const Estimate estimate = EstimateJointly(problem);
    ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
    EXPECT_EQ(estimate.estimated.size(), 49u);  // 45 and four more nodes
    if (seed > 0) {
      EXPECT_GT(ChiSquareSurvival(test::SquaredDistanceToTruth(estimate, truth), 49), 1e-5);
    }
    std::vector<JointTwoNode> nodes;
    for (const char* at : {"-140", "-99.85", "-56.9", "-25.24", "-0.01"}) {
      const int i = estimate.parameters.FindCoordinate(std::string("compliance/A2@") + at);
      ASSERT_GE(i, 0) << at;
      nodes.push_back({std::stod(at) * kDegree, estimate.table[i].value, std::max(estimate.table[i].sigma, 1e-15)});
      if (seed == 0) {
        EXPECT_NEAR(estimate.table[i].value, truth.k2_of_q2(nodes.back().q), 1e-9 * nodes.back().k);
      }
    }
    const EquivalentSpring fit = FitEquivalentSpring(nodes, kGeometry);
    ASSERT_TRUE(fit.solved);
    if (seed == 0) {
      EXPECT_NEAR(fit.Kc, spring.Kc, 1e-6 * spring.Kc);
      EXPECT_NEAR(fit.s0, spring.s0, 1e-6);
      continue;
    }
    const Eigen::Vector3d error(fit.k0 - 0.302e-6, fit.Kc - spring.Kc, fit.s0 - spring.s0);
    const Eigen::Vector3d root = fit.covariance.diagonal().cwiseSqrt();
    EXPECT_LT((error.cwiseQuotient(root)).cwiseAbs().maxCoeff(), 5.0);
  }
}

}  // namespace
}  // namespace sagitta::equivalent_spring_test
