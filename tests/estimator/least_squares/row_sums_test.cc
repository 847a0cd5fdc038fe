// Sums of rows in vector registers, against Eigen's products of the same rows.
#include "estimator/least_squares/row_sums.h"

#include <gtest/gtest.h>

#include "estimator/least_squares/part_sums.h"
#include "problems/simulation.h"
#include "tests/support/instruction_sets.h"

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

// Ten halves make more cells than are kept; what is in no part counts in the whole alone.
TEST(PartSums, AreThoseOfTheRowsOfEachPart) {
  constexpr int kObservations = 300, kColumns = 4;
  NormalNumbers normal(4);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows(3 * kObservations, kColumns + 1);
  for (double& value : rows.reshaped()) value = normal();
  std::vector<Partition> partitions(11, {2, std::vector<int>(kObservations)});
  partitions[10].parts = 7;
  PartSums sums(kObservations, std::vector<int>(kColumns, 0));
  for (size_t p = 0; p < partitions.size(); ++p) {
    for (int k = 0; k < kObservations; ++k) partitions[p].part_of[k] = p < 10 ? normal() > 0.0 : k % 8 - 1;
    sums.Divide(partitions[p]);
  }
  for (int k = 0; k < kObservations; ++k) sums.Add(k, rows.row(3 * k).data());
  const SummedParts found = sums.Totals();
  EXPECT_LT((found.all.matrix - rows.transpose() * rows).cwiseAbs().maxCoeff(), 1e-10);
  ASSERT_EQ(found.parts.size(), partitions.size());
  for (size_t p = 0; p < partitions.size(); ++p) {
    ASSERT_EQ(found.parts[p].size(), static_cast<size_t>(partitions[p].parts));
    for (int part = 0; part < partitions[p].parts; ++part) {
      Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(kColumns + 1, kColumns + 1);
      int count = 0;
      for (int k = 0; k < kObservations; ++k) {
        if (partitions[p].part_of[k] != part) continue;
        expected += rows.middleRows<3>(3 * k).transpose() * rows.middleRows<3>(3 * k);
        count += 3;
      }
      EXPECT_LT((found.parts[p][part].matrix - expected).cwiseAbs().maxCoeff(), 1e-10) << p << " " << part;
      EXPECT_EQ(found.parts[p][part].rows, count);
    }
  }
}

// Rows that fill strips and vectors or not, and of as many columns as are summed together, of fewer and of more.
TEST(TallProduct, IsEigensOnEveryInstructionSet) {
  test::OnEveryInstructionSet([] {
    NormalNumbers normal(3);
    for (const int rows : {1, 7, 8, 15, 16, 23, 24, 25, 50}) {
      for (int columns = 1; columns <= 17; ++columns) {
        Eigen::MatrixXd x(rows, 5), w(5, columns);
        for (double& value : x.reshaped()) value = normal();
        for (double& value : w.reshaped()) value = normal();
        const Eigen::MatrixXd found = TallProduct(x, w);
        EXPECT_LT((found - x.lazyProduct(w)).cwiseAbs().maxCoeff(), 1e-13) << rows << " " << columns;
      }
    }
  });
}

}  // namespace
}  // namespace sagitta::row_sums_test
