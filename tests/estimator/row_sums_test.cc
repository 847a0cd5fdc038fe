// Sums of rows in vector registers, against Eigen's products of the same rows.
#include "estimator/least_squares/row_sums.h"

#include <gtest/gtest.h>

#include "problems/simulation.h"

namespace sagitta::row_sums_test {
namespace {

// Numbers and rows below, at and beyond what registers and the memory for rows hold.
TEST(SumOfRows, IsTheProductOfItsRows) {
  NormalNumbers normal(1);
  int cases = 0;
  for (const int numbers : {1, 3, 4, 7, 8, 9, 31, 33, 57, 64, 65, 130}) {
    for (const int count : {0, 1, 7, 47, 48, 49, 200}) {
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows(count, numbers);
      for (double& value : rows.reshaped()) value = normal();
      SumOfRows sums(numbers);
      for (int i = 0; i < count; ++i) sums.Add(rows.row(i).data());
      const Eigen::MatrixXd expected = rows.transpose() * rows;
      const Eigen::MatrixXd found = sums.Total();
      ASSERT_EQ(found.rows(), numbers);
      EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-12 * (1.0 + count)) << numbers << " " << count;
      ++cases;
    }
  }
  EXPECT_EQ(cases, 84);
}

TEST(SumOfRows, BeginsAnewAndMovesWithItsMemory) {
  NormalNumbers normal(2);
  Eigen::VectorXd first(5), second(5);
  for (double& value : first) value = normal();
  for (double& value : second) value = normal();
  SumOfRows sums(5);
  sums.Add(first.data());
  sums.Clear();
  sums.Add(second.data());
  SumOfRows moved = std::move(sums);
  moved.Add(first.data());
  const Eigen::MatrixXd expected = first * first.transpose() + second * second.transpose();
  EXPECT_LT((moved.Total() - expected).cwiseAbs().maxCoeff(), 1e-14);
}

}  // namespace
}  // namespace sagitta::row_sums_test
