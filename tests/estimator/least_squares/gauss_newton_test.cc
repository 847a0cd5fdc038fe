// The one Gauss-Newton on functions whose optimum is known.
#include "estimator/least_squares/gauss_newton.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sagitta::gauss_newton_test {
namespace {

// Two compliances of joints that do not exist, x and y, with a bound at 0.
ParameterSet At(double x, double y) {
  std::vector<ModelParameter> model;
  for (const double value : {x, y}) {
    ModelParameter parameter{"compliance/J" + std::to_string(model.size()), Quantity::kCompliance,
                             ParameterLaw::kCompliance, static_cast<int>(model.size())};
    parameter.nominal = value;
    parameter.lower = 0.0;
    model.push_back(parameter);
  }
  ParameterSet set({}, {}, model);
  for (int i = 0; i < 2; ++i) set.coordinate(i).free = true;
  return set;
}

// Rosenbrock's valley, r = (10 (y - x^2), c - x), its minimum (c, c^2).
RowsAt Valley(double c) {
  return [c](const ParameterSet& at, const std::vector<int>& columns) -> FittedRows {
    const double x = at.Value(0), y = at.Value(1);
    Linearization rows;
    rows.columns = columns;
    rows.residual = Eigen::Vector2d(10.0 * (y - x * x), c - x);
    Eigen::Matrix2d all;
    all << -20.0 * x, 10.0, -1.0, 0.0;
    rows.jacobian = all(Eigen::all, columns);
    return {rows, 2};
  };
}

GaussNewtonOptions Exact() {
  GaussNewtonOptions options;
  options.max_steps = 100;
  options.tolerance = 1e-9;
  options.least_noise = 1.0;
  return options;
}

TEST(GaussNewton, GoesThroughABentValley) {
  const GaussNewtonResult result = GaussNewton(Valley(1.0), {0, 1}, At(0.1, 4.0), Exact());
  ASSERT_TRUE(result.converged);
  EXPECT_NEAR(result.parameters.Value(0), 1.0, 1e-7);
  EXPECT_NEAR(result.parameters.Value(1), 1.0, 1e-7);
  EXPECT_LT(result.cost(), 1e-14);
}

// r = w(x) (s (x - 1), b) whitened with w(x), the columns of a given w: J' r = 0 at x = 1, where r' r is not least. A
// whole step leaves nothing, and b' b rises by more than it promises.
TEST(GaussNewton, FindsWhereTheStepsEndThoughTheWeightsMove) {
  const RowsAt rows_at = [](const ParameterSet& at, const std::vector<int>& columns) -> FittedRows {
    const double x = at.Value(0), weight = 1.0 + 1e-5 * x;
    Linearization rows;
    rows.columns = columns;
    rows.residual = weight * Eigen::Vector2d(0.1 * (x - 1.0), 100.0);
    rows.jacobian = weight * Eigen::Vector2d(0.1, 0.0);
    return {rows, 2};
  };
  GaussNewtonOptions options = Exact();
  options.max_steps = 5;
  const GaussNewtonResult result = GaussNewton(rows_at, {0}, At(0.5, 0.0), options);
  ASSERT_TRUE(result.converged);
  EXPECT_NEAR(result.parameters.Value(0), 1.0, 1e-9);
  EXPECT_GT(result.cost(), 1e4 * std::pow(1.0 + 0.5e-5, 2));  // that of the start, without the first row
}

// With c = -1 the minimum inside the bounds is at the origin: r = (0, -1).
TEST(GaussNewton, StopsAtTheBound) {
  const GaussNewtonResult result = GaussNewton(Valley(-1.0), {0, 1}, At(0.5, 0.5), Exact());
  ASSERT_TRUE(result.converged);
  EXPECT_NEAR(result.parameters.Value(0), 0.0, 1e-9);
  EXPECT_NEAR(result.parameters.Value(1), 0.0, 1e-9);
  EXPECT_NEAR(result.cost(), 1.0, 1e-9);
  EXPECT_FALSE(result.left.pinned.empty());
}

TEST(GaussNewton, HeldStaysWhereItIs) {
  const GaussNewtonResult result = GaussNewton(Valley(1.0), {1}, At(0.5, 3.0), Exact());
  ASSERT_TRUE(result.converged);
  EXPECT_EQ(result.parameters.Value(0), 0.5);
  EXPECT_NEAR(result.parameters.Value(1), 0.25, 1e-9);
}

// r = (atan(4 (x - 3)), 0.01 (x - 3)): undamped steps from x = 4.5 on overshoot further and further.
FittedRows Overshooting(const ParameterSet& at, const std::vector<int>& columns) {
  const double x = at.Value(0) - 3.0;
  Linearization rows;
  rows.columns = columns;
  rows.residual = Eigen::Vector2d(std::atan(4.0 * x), 0.01 * x);
  rows.jacobian = Eigen::Vector2d(4.0 / (1.0 + 16.0 * x * x), 0.01);
  return {rows, 2};
}

TEST(GaussNewton, DampsWhatOvershoots) {
  const ParameterSet start = At(4.5, 0.0);
  const BoundedStep undamped = SolveBounded(Overshooting(start, {0}).rows, start);
  ASSERT_LT(start.Value(0) + undamped.delta[0], 3.0 - 1.5);  // farther off than before, on the other side
  const GaussNewtonResult result = GaussNewton(Overshooting, {0}, start, Exact());
  ASSERT_TRUE(result.converged);
  EXPECT_NEAR(result.parameters.Value(0), 3.0, 1e-8);
  ParameterSet one = start;
  ASSERT_EQ(TakeOneStep(Overshooting, Overshooting(start, {0}).rows, &one), StepOutcome::kTaken);
  EXPECT_LT(std::abs(one.Value(0) - 3.0), 1.5);
}

TEST(GaussNewton, SaysWhyItEnds) {
  const RowsAt flat = [](const ParameterSet&, const std::vector<int>& columns) -> FittedRows {
    Linearization rows;
    rows.columns = columns;
    rows.residual.setOnes(2);
    rows.jacobian.setZero(2, static_cast<Eigen::Index>(columns.size()));
    return {rows, 2};
  };
  EXPECT_EQ(GaussNewton(flat, {0, 1}, At(1.0, 1.0)).outcome, StepOutcome::kSingular);
  const RowsAt folded = [](const ParameterSet&, const std::vector<int>&) -> FittedRows {
    FittedRows rows;
    rows.rows.valid = false;
    return rows;
  };
  EXPECT_EQ(GaussNewton(folded, {0}, At(1.0, 1.0)).outcome, StepOutcome::kEquilibriumDiverged);
  // A Jacobian of the wrong sign: every step climbs.
  const RowsAt lying = [](const ParameterSet& at, const std::vector<int>& columns) -> FittedRows {
    Linearization rows;
    rows.columns = columns;
    rows.residual = Eigen::Vector2d(at.Value(0) + 1.0, 0.0);
    rows.jacobian = Eigen::Vector2d(-1.0, 0.0);
    return {rows, 2};
  };
  const GaussNewtonResult climbed = GaussNewton(lying, {0}, At(1.0, 0.0));
  EXPECT_EQ(climbed.outcome, StepOutcome::kNoDescent);
  EXPECT_EQ(climbed.parameters.Value(0), 1.0);
  EXPECT_FALSE(climbed.converged);
}

}  // namespace
}  // namespace sagitta::gauss_newton_test
