#include "estimator/explanations/scan.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>

namespace sagitta::scan_test {
namespace {

constexpr int kShots = 40, kRowsOfShot = 3, kSources = 2;

// Rows of each source in each shot, and residuals that are orthogonal to both, as they are given what is believed.
struct Rows {
  Eigen::MatrixXd moved;  // rows x sources
  Eigen::VectorXd residual;
  AlongSources along;
};

Rows RandomRows() {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  Rows rows;
  rows.moved = Eigen::MatrixXd::NullaryExpr(kShots * kRowsOfShot, kSources, [&] { return normal(generator); });
  rows.residual = Eigen::VectorXd::NullaryExpr(kShots * kRowsOfShot, [&] { return normal(generator); });
  // The sources move different rows, as the axes of a station and of a marker do.
  for (int row = 0; row < kShots * kRowsOfShot; ++row) rows.moved(row, row % kRowsOfShot == 0 ? 0 : 1) = 0.0;
  const auto believed = rows.moved.householderQr();
  rows.residual -= rows.moved * believed.solve(rows.residual);
  rows.along.square.setZero(kShots, kSources);
  rows.along.residual.setZero(kShots, kSources);
  for (int row = 0; row < kShots * kRowsOfShot; ++row) {
    rows.along.square.row(row / kRowsOfShot) += rows.moved.row(row).cwiseAbs2();
    rows.along.residual.row(row / kRowsOfShot) += rows.residual[row] * rows.moved.row(row);
  }
  return rows;
}

// What chi-square loses where each of the sources follows the function in addition to a constant: two least-squares
// fits.
double LostBy(const Rows& rows, const Eigen::VectorXd& function) {
  Eigen::MatrixXd columns(rows.moved.rows(), 2 * kSources);
  columns.leftCols(kSources) = rows.moved;
  for (int row = 0; row < rows.moved.rows(); ++row) {
    columns.row(row).tail(kSources) = function[row / kRowsOfShot] * rows.moved.row(row);
  }
  const Eigen::VectorXd left = rows.residual - columns * columns.householderQr().solve(rows.residual);
  return rows.residual.squaredNorm() - left.squaredNorm();
}

Eigen::VectorXd WithTies() {
  std::mt19937 generator(8);
  std::uniform_int_distribution<int> grid(0, 12);
  return Eigen::VectorXd::NullaryExpr(kShots, [&] { return 0.1 * grid(generator); });
}

TEST(Scan, AReductionIsWhatTwoFitsDifferBy) {
  const Rows rows = RandomRows();
  const Eigen::VectorXd wave = WithTies().array().sin();
  const double reduction = rows.along.Reduction(wave, 0, true) + rows.along.Reduction(wave, 1, true);
  EXPECT_NEAR(reduction, LostBy(rows, wave), 1e-10 * rows.residual.squaredNorm());
}

TEST(Scan, EveryJumpExplainsWhatTwoFitsDifferBy) {
  const Rows rows = RandomRows();
  const Eigen::VectorXd x = WithTies();
  std::vector<int> all(kShots);
  for (int s = 0; s < kShots; ++s) all[static_cast<size_t>(s)] = s;
  const std::vector<TriedJump> jumps = TryJumps(rows.along, all, x, {100, 1, 0, kSources});
  ASSERT_EQ(jumps.size(), Gaps(x, 100).size());
  for (const TriedJump& jump : jumps) {
    EXPECT_NEAR(jump.reduction, LostBy(rows, Jump(x, jump.gap)), 1e-10 * rows.residual.squaredNorm());
  }
}

TEST(Scan, OneSourceOfSeveral) {
  const Rows rows = RandomRows();
  const Eigen::VectorXd x = WithTies();
  std::vector<int> all(kShots);
  for (int s = 0; s < kShots; ++s) all[static_cast<size_t>(s)] = s;
  for (const TriedJump& jump : TryJumps(rows.along, all, x, {100, 1, 1, 1})) {
    EXPECT_NEAR(jump.reduction, rows.along.Reduction(Jump(x, jump.gap), 1, true), 1e-10);
  }
}

// Two jumps at once, of two sources that move the same rows: those that leave least of all pairs, each fitted.
TEST(Scan, JumpsThatGoTogetherExplainMost) {
  std::mt19937 generator(9);
  std::normal_distribution<double> normal;
  Rows rows;
  rows.moved = Eigen::MatrixXd::NullaryExpr(kShots * kRowsOfShot, kSources, [&] { return normal(generator); });
  rows.moved.col(1) += 2.0 * rows.moved.col(0);
  rows.residual = Eigen::VectorXd::NullaryExpr(kShots * kRowsOfShot, [&] { return normal(generator); });
  rows.residual -= rows.moved * rows.moved.householderQr().solve(rows.residual);
  rows.along = {Eigen::MatrixXd::Zero(kShots, kSources), Eigen::MatrixXd::Zero(kShots, kSources),
                Eigen::MatrixXd::Zero(kShots, kSources * kSources)};
  Eigen::VectorXd x(kShots);
  std::vector<int> all;
  for (int s = 0; s < kShots; ++s) {
    const Eigen::MatrixXd own = rows.moved.middleRows<kRowsOfShot>(kRowsOfShot * s);
    const Eigen::MatrixXd products = own.transpose() * own;
    rows.along.square.row(s) = products.diagonal().transpose();
    rows.along.products.row(s) = products.reshaped().transpose();
    rows.along.residual.row(s) = rows.residual.segment<kRowsOfShot>(kRowsOfShot * s).transpose() * own;
    x[s] = s / 4;
    all.push_back(s);
  }
  const auto left_by = [&rows](const std::vector<Eigen::VectorXd>& functions) {
    Eigen::MatrixXd columns(rows.moved.rows(), kSources * (1 + static_cast<long>(functions.size())));
    columns.leftCols(kSources) = rows.moved;
    for (size_t f = 0; f < functions.size(); ++f) {
      for (int row = 0; row < rows.moved.rows(); ++row) {
        columns.block<1, kSources>(row, kSources * (1 + static_cast<long>(f))) =
            functions[f][row / kRowsOfShot] * rows.moved.row(row);
      }
    }
    return (rows.residual - columns * columns.householderQr().solve(rows.residual)).squaredNorm();
  };
  const std::vector<Gap> gaps = Gaps(x, 100);
  std::vector<Gap> least;
  double left = rows.residual.squaredNorm();
  for (size_t j = 1; j < gaps.size(); ++j) {
    for (size_t i = 0; i < j; ++i) {
      const double here = left_by({Jump(x, gaps[i]), Jump(x, gaps[j])});
      if (here < left) {
        left = here;
        least = {gaps[i], gaps[j]};
      }
    }
  }
  const std::vector<std::vector<Gap>> best = BestJumps(rows.along, all, x, 100, 20);
  ASSERT_EQ(best.size(), gaps.size() + 1);  // no more jumps than gaps
  EXPECT_TRUE(best[0].empty());
  EXPECT_EQ(best[2], least);
  EXPECT_EQ(best[gaps.size()], gaps);
}

// Shots that are held out have no sums, and their places make no gaps.
TEST(Scan, JumpsLieBetweenFittedShotsWithEnoughOnEachSide) {
  const Rows rows = RandomRows();
  Eigen::VectorXd x(kShots);
  for (int s = 0; s < kShots; ++s) x[s] = s;
  std::vector<int> even;
  for (int s = 0; s < kShots; s += 2) even.push_back(s);
  const std::vector<TriedJump> jumps = TryJumps(rows.along, even, x, {100, 3, 0, 1});
  ASSERT_EQ(jumps.size(), even.size() - 5);  // 19 gaps of 20 shots, without two at each end
  EXPECT_EQ(jumps.front().gap, Gap(4.0, 6.0));
  EXPECT_EQ(jumps.back().gap, Gap(32.0, 34.0));
}

// A source that is seen on one side of the gap alone has nothing to jump from.
TEST(Scan, AConstantIsNoJump) {
  Rows rows = RandomRows();
  Eigen::VectorXd x(kShots);
  std::vector<int> all(kShots);
  for (int s = 0; s < kShots; ++s) {
    x[s] = s;
    all[static_cast<size_t>(s)] = s;
  }
  rows.along.square.topRows(10).setZero();
  rows.along.residual.topRows(10).setZero();
  int unseen = 0;
  for (const TriedJump& jump : TryJumps(rows.along, all, x, {100, 1, 0, 1})) {
    if (jump.gap.first >= 9.5) continue;
    ++unseen;
    EXPECT_EQ(jump.reduction, 0.0) << jump.gap.first;
  }
  EXPECT_GT(unseen, 0);
}

TEST(Scan, TheBestAreListedAndAllAreCounted) {
  Scan<int> scan;
  for (int n = 0; n < 10; ++n) scan.Try(n % 5, n);
  EXPECT_EQ(scan.Best(3), (std::vector<int>{4, 9, 3}));
  EXPECT_EQ(scan.size(), 10u);
  EXPECT_EQ(scan.Best(20).size(), 10u);
}

}  // namespace
}  // namespace sagitta::scan_test
