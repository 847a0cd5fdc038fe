// Products, roots and inverses on vector registers against Eigen's, whole registers and what is left over.
#include "estimator/least_squares/normal_algebra.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "estimator/least_squares/linearization.h"
#include "tests/support/instruction_sets.h"

namespace sagitta::normal_algebra_test {
namespace {

constexpr double kRoundOff = 1e-12;  // of sums of a few hundred numbers of size 1

Eigen::MatrixXd Random(Eigen::Index rows, Eigen::Index columns) {
  std::srand(7);  // Eigen's numbers come from there
  return Eigen::MatrixXd::Random(rows, columns);
}

TEST(NormalAlgebra, IsEigensOnEveryInstructionSet) {
  test::OnEveryInstructionSet([] {
    for (const int n : {1, 3, 4, 7, 8, 9, 45, 57}) {
      for (const int rows : {n + 1, 2 * n + 3, 200}) {
        SCOPED_TRACE(testing::Message() << n << " of " << rows);
        const Eigen::MatrixXd j = Random(rows, n);
        EXPECT_LT((SelfProduct(j) - j.transpose() * j).cwiseAbs().maxCoeff(), kRoundOff);
        const Eigen::MatrixXd a = Eigen::MatrixXd(j.transpose() * j) + Eigen::MatrixXd::Identity(n, n);
        const Eigen::MatrixXd w = InverseRoot(a);
        ASSERT_EQ(w.cols(), n);
        EXPECT_TRUE(w.isUpperTriangular(0.0));
        EXPECT_LT((w.transpose() * a * w - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), kRoundOff);
        EXPECT_LT((SquareOfRoot(w) - w * w.transpose()).cwiseAbs().maxCoeff(), kRoundOff);
      }
    }
  });
}

TEST(NormalAlgebra, WhatIsNotPositiveDefiniteHasNoRoot) {
  test::OnEveryInstructionSet([] {
    Eigen::MatrixXd a = Eigen::MatrixXd::Identity(12, 12);
    a(9, 9) = -1.0;
    EXPECT_EQ(InverseRoot(a).size(), 0);
    a(9, 9) = std::nan("");
    EXPECT_EQ(InverseRoot(a).size(), 0);
    EXPECT_EQ(InverseRoot(Eigen::MatrixXd(0, 0)).size(), 0);
    EXPECT_EQ(SelfProduct(Eigen::MatrixXd(3, 0)).size(), 0);
    EXPECT_EQ(SelfProduct(Eigen::MatrixXd(0, 3)), Eigen::MatrixXd::Zero(3, 3));
  });
}

// To the round-off of the largest, whatever lies between: wide spectra, equal eigenvalues, one number.
TEST(NormalAlgebra, EndsOfSpectrumAreThoseOfAllEigenvalues) {
  test::OnEveryInstructionSet([] {
    for (const int n : {1, 2, 3, 9, 45, 101}) {
      for (const double spread : {0.0, 1e-8, 1.0, 1e6}) {
        const Eigen::MatrixXd j = Random(n + 3, n);
        const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(n, 1.0, 1.0 + spread);
        const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(j.topRows(n)).householderQ();
        const Eigen::MatrixXd a = q * weights.asDiagonal() * q.transpose() - 0.5 * Eigen::MatrixXd::Identity(n, n);
        const Eigen::VectorXd all = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a).eigenvalues();
        const auto [least, largest] = EndsOfSpectrum(a);
        const double round_off = 1e-14 * n * all.cwiseAbs().maxCoeff();
        EXPECT_NEAR(least, all[0], round_off) << n << " " << spread;
        EXPECT_NEAR(largest, all[n - 1], round_off) << n << " " << spread;
      }
    }
  });
}

// Columns that nearly depend on each other are solved by their rows, others by their products: both say the same where
// they meet, at a condition of 1000.
TEST(NormalAlgebra, ByProductsAsByRows) {
  double conditions[2];
  Eigen::VectorXd steps[2], variances[2];
  for (const int by_rows : {0, 1}) {
    Linearization rows;
    rows.jacobian = Random(60, 12);
    rows.residual = Random(60, 1);
    rows.columns.assign(12, 0);
    // Unit vectors at an angle of e have a condition of 2 / e and more among others.
    const double angle = by_rows == 1 ? 2.0e-3 : 2.5e-3;
    const Eigen::VectorXd first = rows.jacobian.col(0).normalized();
    const Eigen::VectorXd across = (rows.jacobian.col(1) - first * first.dot(rows.jacobian.col(1))).normalized();
    rows.jacobian.col(1) = first + angle * across;
    const LinearSolution solution = SolveLinearization(rows);
    ASSERT_TRUE(solution.full_rank);
    conditions[by_rows] = solution.condition;
    const Eigen::MatrixXd normal = rows.jacobian.transpose() * rows.jacobian;
    const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
    steps[by_rows] = solution.step + factor.solve(rows.jacobian.transpose() * rows.residual);
    variances[by_rows] = solution.covariance.diagonal().cwiseQuotient(
        Eigen::VectorXd(factor.solve(Eigen::MatrixXd::Identity(12, 12)).diagonal()));
    EXPECT_LT(steps[by_rows].cwiseAbs().maxCoeff(), 1e-6 * solution.step.cwiseAbs().maxCoeff());
    EXPECT_LT((variances[by_rows].array() - 1.0).abs().maxCoeff(), 1e-8);
    EXPECT_NEAR((rows.jacobian * solution.step + rows.residual).squaredNorm(), solution.residual_norm_squared, 1e-12);
  }
  EXPECT_LT(conditions[0], 1000.0);
  EXPECT_GT(conditions[1], 1000.0);
}

}  // namespace
}  // namespace sagitta::normal_algebra_test
