// Cluster-robust covariance: closed form, and what its intervals cover.
#include "estimator/least_squares/sandwich.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "estimator/least_squares/cluster_sandwich.h"
#include "estimator/statistics/distributions.h"
#include "problems/simulation.h"

namespace sagitta::sandwich_test {
namespace {

Linearization Rows(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual) {
  Linearization l;
  l.jacobian = jacobian;
  l.residual = residual;
  for (int c = 0; c < jacobian.cols(); ++c) l.columns.push_back(c);
  for (int k = 0; k < residual.size() / 3; ++k) l.observations.push_back(k);
  return l;
}

// Residuals after the fit, as at an optimum.
Eigen::VectorXd AfterFit(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& y) {
  return y - jacobian * jacobian.colPivHouseholderQr().solve(y);
}

TEST(Sandwich, OfAMeanIsTheVarianceOfClusterMeans) {
  // One unknown, the mean; equal clusters: the unbiased estimate is known, with G - 1 degrees of freedom.
  const int clusters = 7, observations = 2;
  NormalNumbers normal(3);
  Eigen::VectorXd y(3 * clusters * observations);
  for (double& v : y) v = normal();
  const Eigen::MatrixXd ones = Eigen::MatrixXd::Ones(y.size(), 1);
  std::vector<int> cluster_of;
  Eigen::VectorXd means(clusters);
  for (int k = 0; k < clusters * observations; ++k) cluster_of.push_back(k / observations);
  for (int g = 0; g < clusters; ++g) means[g] = y.segment(g * 3 * observations, 3 * observations).mean();
  const double expected = (means.array() - means.mean()).square().sum() / (clusters * (clusters - 1.0));
  const RobustCovariance robust = SandwichCovariance(Rows(ones, AfterFit(ones, y)), cluster_of);
  EXPECT_EQ(robust.clusters, clusters);
  EXPECT_NEAR(robust.covariance(0, 0), expected, 1e-12 * expected);
  EXPECT_NEAR(robust.dof[0], clusters - 1.0, 1e-9);
}

// Eight side by side: clusters of different length, one longer than its columns are many, one that alone sees a column;
// all of them, and half of them in fewer columns one step away.
TEST(Sandwich, OfManyIsTheSameSideBySide) {
  constexpr int kClusters = 203, kColumns = 6;
  NormalNumbers normal(5);
  std::vector<int> cluster_of;
  for (int g = 0; g < kClusters; ++g) cluster_of.insert(cluster_of.end(), g == 17 ? 30 : 1 + g % 3, g);
  const auto observations = static_cast<int>(cluster_of.size());
  Eigen::MatrixXd jacobian(3 * observations, kColumns);
  Eigen::VectorXd y(3 * observations);
  for (double& value : jacobian.reshaped()) value = normal();
  for (double& value : y) value = normal();
  for (int k = 0; k < observations; ++k) {
    if (cluster_of[k] != 40) jacobian.block<3, 1>(3 * k, 5).setZero();
  }
  const Linearization all = Rows(jacobian, AfterFit(jacobian, y));
  RowMajorMatrix rows(all.num_rows(), kColumns + 1);
  rows << all.jacobian, all.residual;
  // The half: even clusters in the first five columns, from a point one step away.
  ClusterFit whole, half;
  whole.solution = SolveLinearization(all);
  half.columns = {0, 1, 2, 3, 4};
  half.has.assign(kClusters, 0);
  std::vector<int> own, own_rows;
  for (int k = 0; k < observations; ++k) {
    if (cluster_of[k] % 2 != 0) continue;
    half.has[cluster_of[k]] = 1;
    own.push_back(cluster_of[k]);
    for (int axis = 0; axis < 3; ++axis) own_rows.push_back(3 * k + axis);
  }
  Linearization part = Rows(all.jacobian(own_rows, half.columns), all.residual(own_rows));
  half.solution = SolveLinearization(part);
  half.step = half.solution.step;
  part.residual += part.jacobian * half.step;
  ClusterSandwich together(kColumns, kClusters, whole.solution.covariance, {whole, half});
  together.Add(rows, cluster_of);
  const auto expect_same = [](const RobustCovariance& a, const RobustCovariance& b) {
    ASSERT_EQ(a.covariance.rows(), b.covariance.rows());
    EXPECT_EQ(a.clusters, b.clusters);
    const double size = b.covariance.norm();
    EXPECT_LT((a.covariance - b.covariance).norm(), 1e-6 * size);
    for (Eigen::Index c = 0; c < a.dof.size(); ++c) EXPECT_NEAR(a.dof[c], b.dof[c], 1e-6 * b.dof[c]);
  };
  expect_same(together.Result(0), SandwichCovariance(all, cluster_of));
  expect_same(together.Result(1), SandwichCovariance(part, own));
}

// Fits of columns that are turned: the same as of rows that were.
TEST(Sandwich, TurnsWhatItSumsAsRowsAreTurned) {
  constexpr int kClusters = 60, kColumns = 4;
  NormalNumbers normal(11);
  std::vector<int> cluster_of;
  for (int g = 0; g < kClusters; ++g) cluster_of.insert(cluster_of.end(), 1 + g % 2, g);
  Eigen::MatrixXd jacobian(3 * static_cast<Eigen::Index>(cluster_of.size()), kColumns);
  Eigen::VectorXd y(jacobian.rows());
  for (double& value : jacobian.reshaped()) value = normal();
  for (double& value : y) value = normal();
  Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(kColumns, kColumns);
  turn.block<2, 2>(1, 1) = Eigen::Rotation2Dd(0.7).toRotationMatrix();
  const Linearization plain = Rows(jacobian, y), turned = Rows(jacobian * turn, y);
  ClusterFit whole, half;
  whole.solution = SolveLinearization(turned);
  half.columns = {0, 2, 3};
  half.has.assign(kClusters, 0);
  std::vector<int> own, own_rows;
  for (size_t k = 0; k < cluster_of.size(); ++k) {
    if (cluster_of[k] % 3 == 0) continue;
    half.has[cluster_of[k]] = 1;
    own.push_back(cluster_of[k]);
    for (int axis = 0; axis < 3; ++axis) own_rows.push_back(3 * static_cast<int>(k) + axis);
  }
  Linearization part = Rows(turned.jacobian(own_rows, half.columns), turned.residual(own_rows));
  half.solution = SolveLinearization(part);
  half.step = half.solution.step;
  part.residual += part.jacobian * half.step;
  RowMajorMatrix rows(plain.num_rows(), kColumns + 1);
  rows << plain.jacobian, plain.residual;
  ClusterSandwich together(kColumns, kClusters, SolveLinearization(plain).covariance, {whole, half}, turn);
  together.Add(rows, cluster_of);
  const RobustCovariance of_all = SandwichCovariance(turned, cluster_of), of_part = SandwichCovariance(part, own);
  EXPECT_LT((together.Result(0).covariance - of_all.covariance).norm(), 1e-6 * of_all.covariance.norm());
  EXPECT_LT((together.Result(1).covariance - of_part.covariance).norm(), 1e-6 * of_part.covariance.norm());
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(together.Result(1).dof[c], of_part.dof[c], 1e-6 * of_part.dof[c]);
}

// Of 12,000 clusters some 2,000 say how many degrees of freedom there are: G - 1 of a mean, within four standard
// deviations of a count of 2,000.
TEST(Sandwich, OfTheManyASampleSaysTheDegreesOfFreedom) {
  constexpr int kClusters = 12000;
  NormalNumbers normal(9);
  Eigen::VectorXd y(3 * kClusters);
  for (double& value : y) value = normal();
  const Eigen::MatrixXd ones = Eigen::MatrixXd::Ones(y.size(), 1);
  std::vector<int> cluster_of(kClusters);
  Eigen::VectorXd means(kClusters);
  for (int g = 0; g < kClusters; ++g) {
    cluster_of[g] = g;
    means[g] = y.segment(3 * g, 3).mean();
  }
  const double expected = (means.array() - means.mean()).square().sum() / (kClusters * (kClusters - 1.0));
  const RobustCovariance robust = SandwichCovariance(Rows(ones, AfterFit(ones, y)), cluster_of);
  EXPECT_NEAR(robust.covariance(0, 0), expected, 1e-6 * expected);
  EXPECT_NEAR(robust.dof[0] / kClusters, 1.0, 4.0 / std::sqrt(2000.0));
}

TEST(Sandwich, APriorKeepsItsStatedVariance) {
  // A column that only a prior row touches: its variance is the prior's, whatever the residual there.
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(10, 2);
  jacobian.topLeftCorner(9, 1).setOnes();
  jacobian(9, 1) = 1.0 / 0.3;
  Eigen::VectorXd residual = Eigen::VectorXd::LinSpaced(10, -1, 1);
  Linearization l = Rows(jacobian, residual);
  l.observations = {0, 1, 2};
  const RobustCovariance robust = SandwichCovariance(l, {0, 1, 2});
  EXPECT_NEAR(robust.covariance(1, 1), 0.09, 1e-12);
}

TEST(Sandwich, CoversUnderErrorsThatAConfigurationShares) {
  // 24 clusters of 2 observations, 4 unknowns; each cluster shares an error twice the rows' own, and the
  // clusters differ in size of error by a factor 3. Model intervals (scaled by the a-posteriori sigma) do not hold.
  const int clusters = 24, rows = 6 * clusters, unknowns = 4, trials = 1000;
  NormalNumbers normal(11);
  Eigen::MatrixXd jacobian(rows, unknowns);
  for (int g = 0; g < clusters; ++g) {
    for (int c = 0; c < unknowns; ++c) {
      const double level = normal();
      for (int i = 0; i < 6; ++i) jacobian(6 * g + i, c) = level + 0.3 * normal();
    }
  }
  std::vector<int> cluster_of;
  for (int k = 0; k < 2 * clusters; ++k) cluster_of.push_back(k / 2);
  int robust_covers = 0, model_covers = 0;
  for (int trial = 0; trial < trials; ++trial) {
    Eigen::VectorXd y(rows);
    for (int g = 0; g < clusters; ++g) {
      const double size = g % 2 == 0 ? 1.0 : 3.0, shared = 2.0 * size * normal();
      for (int i = 0; i < 6; ++i) y[6 * g + i] = shared + size * normal();
    }
    const Eigen::VectorXd residual = AfterFit(jacobian, y);
    const Linearization l = Rows(jacobian, residual);
    const LinearSolution model = SolveLinearization(l);
    const Eigen::VectorXd error = jacobian.colPivHouseholderQr().solve(y);
    const RobustCovariance robust = SandwichCovariance(l, cluster_of);
    const double scale = residual.squaredNorm() / (rows - unknowns);
    robust_covers += std::abs(error[0]) <= StudentQuantile(0.975, robust.dof[0]) * std::sqrt(robust.covariance(0, 0));
    model_covers += std::abs(error[0]) <= 1.98 * std::sqrt(scale * model.covariance(0, 0));
  }
  // 1000 trials at 95 %: standard deviation 0.69 %; four of them and 1 % for the finite-sample form.
  EXPECT_NEAR(robust_covers / 1000.0, 0.95, 4 * 0.0069 + 0.01);
  EXPECT_LT(model_covers, 800);
}

TEST(Distributions, ClopperPearsonAsTabulated) {
  EXPECT_NEAR(ClopperPearson(8, 10).low, 0.4439, 5e-5);
  EXPECT_NEAR(ClopperPearson(8, 10).high, 0.9748, 5e-5);
  EXPECT_EQ(ClopperPearson(0, 10).low, 0.0);
  EXPECT_NEAR(ClopperPearson(0, 10).high, 0.3085, 5e-5);
  EXPECT_EQ(ClopperPearson(10, 10).high, 1.0);
  EXPECT_NEAR(ClopperPearson(95, 100).low, 0.8872, 5e-5);
  EXPECT_NEAR(ClopperPearson(95, 100).high, 0.9836, 5e-5);
}

}  // namespace
}  // namespace sagitta::sandwich_test
