// Products, triangular solves and decompositions of matrices, by every instruction set: against sums written out.
#include <gtest/gtest.h>

#include <cmath>

#include "models/dense_algebra.h"
#include "tests/support/instruction_sets.h"

namespace sagitta::dense_kernel_test {
namespace {

using Eigen::MatrixXd;

// Numbers without a pattern that packing could hide: no two are equal.
MatrixXd Numbers(Eigen::Index rows, Eigen::Index columns, double phase) {
  MatrixXd numbers(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    for (Eigen::Index r = 0; r < rows; ++r) numbers(r, c) = std::sin(phase + 1.7 * r + 0.9 * c + 0.31 * r * c);
  }
  return numbers;
}

// The sum of n products of numbers up to 1 is rounded by n epsilon at most, whatever the order.
double Rounding(Eigen::Index n) { return 4.0 * static_cast<double>(n) * 2.3e-16; }

double Written(const MatrixXd& a, const MatrixXd& b, Eigen::Index r, Eigen::Index c) {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < a.cols(); ++k) sum += a(r, k) * b(k, c);
  return sum;
}

void ExpectProduct(const MatrixXd& a, const MatrixXd& b, const MatrixXd& product, double factor) {
  for (Eigen::Index c = 0; c < b.cols(); ++c) {
    for (Eigen::Index r = 0; r < a.rows(); ++r) {
      ASSERT_NEAR(product(r, c), factor * Written(a, b, r, c), Rounding(a.cols())) << r << ", " << c;
    }
  }
}

// Rows by twelve, eight, four, two and one, columns by four and one, a depth that no packet divides.
TEST(DenseKernel, ProductsAreSumsOfProducts) {
  test::OnEveryInstructionSet([] {
    for (const Eigen::Index rows : {1, 2, 3, 4, 7, 8, 12, 15, 23, 26, 61}) {
      for (const Eigen::Index columns : {1, 3, 4, 9, 14}) {
        for (const Eigen::Index depth : {17, 40, 301}) {
          SCOPED_TRACE(testing::Message() << rows << " x " << depth << " x " << columns);
          const MatrixXd a = Numbers(rows, depth, 0.3), b = Numbers(depth, columns, 1.1);
          const MatrixXd a_turned = a.transpose(), b_turned = b.transpose();
          ExpectProduct(a, b, a * b, 1.0);
          ExpectProduct(a, b, a_turned.transpose() * b, 1.0);
          ExpectProduct(a, b, a * b_turned.transpose(), 1.0);
          ExpectProduct(a, b, a_turned.transpose() * b_turned.transpose(), 1.0);
          MatrixXd sum = MatrixXd::Zero(rows + 3, columns);  // a part of a matrix
          sum.bottomRows(rows).noalias() -= 0.5 * a * b;
          ExpectProduct(a, b, sum.bottomRows(rows), -0.5);
          EXPECT_EQ(sum.topRows(3).cwiseAbs().maxCoeff(), 0.0);
        }
      }
    }
  });
}

TEST(DenseKernel, ProductsAndSolvesOfTriangles) {
  test::OnEveryInstructionSet([] {
    for (const Eigen::Index n : {5, 18, 33, 70}) {
      SCOPED_TRACE(n);
      const MatrixXd right = Numbers(n, 11, 0.7);
      MatrixXd whole = 0.3 / static_cast<double>(n) * Numbers(n, n, 0.1);
      whole.diagonal().array() += 1.0;
      const MatrixXd lower = whole.triangularView<Eigen::Lower>(), upper = whole.triangularView<Eigen::Upper>();
      ExpectProduct(lower, right, whole.triangularView<Eigen::Lower>() * right, 1.0);
      ExpectProduct(upper, right, whole.triangularView<Eigen::Upper>() * right, 1.0);
      const MatrixXd below = whole.triangularView<Eigen::Lower>().solve(right);
      const MatrixXd above = whole.triangularView<Eigen::Upper>().solve(right);
      for (Eigen::Index r = 0; r < n; ++r) {
        for (Eigen::Index c = 0; c < 11; ++c) {
          ASSERT_NEAR(Written(lower, below, r, c), right(r, c), Rounding(4 * n)) << r << ", " << c;
          ASSERT_NEAR(Written(upper, above, r, c), right(r, c), Rounding(4 * n)) << r << ", " << c;
        }
      }
    }
  });
}

TEST(DenseKernel, RanksAndRootsOfSymmetricMatrices) {
  test::OnEveryInstructionSet([] {
    for (const Eigen::Index n : {6, 29, 150}) {
      SCOPED_TRACE(n);
      const MatrixXd a = Numbers(n, n + 9, 0.2);
      MatrixXd sum = MatrixXd::Identity(n, n);
      sum.selfadjointView<Eigen::Lower>().rankUpdate(a);
      const MatrixXd root = sum.llt().matrixL();
      for (Eigen::Index r = 0; r < n; ++r) {
        for (Eigen::Index c = 0; c <= r; ++c) {
          const double expected = Written(a, a.transpose(), r, c) + (r == c ? 1.0 : 0.0);
          ASSERT_NEAR(sum(r, c), expected, Rounding(n + 9)) << r << ", " << c;
          ASSERT_NEAR(Written(root, root.transpose(), r, c), expected, Rounding(4 * n) * sum(c, c)) << r << ", " << c;
        }
      }
    }
  });
}

}  // namespace
}  // namespace sagitta::dense_kernel_test
