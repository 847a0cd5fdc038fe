// Bounded Gauss-Newton steps against the exhaustive active set.
#include "estimator/least_squares/bounded_step.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "tests/support/random_numbers.h"

namespace sagitta::bounded_step_test {
namespace {

constexpr int kUnknowns = 5;

// Five compliances of joints that do not exist: coordinates with a bound at 0.
ParameterSet Bounded(test::RandomNumbers* random) {
  std::vector<ModelParameter> model;
  for (int i = 0; i < kUnknowns; ++i) {
    ModelParameter parameter{"compliance/J" + std::to_string(i), Quantity::kCompliance, ParameterLaw::kCompliance, i};
    parameter.nominal = i % 2 == 0 ? 0.0 : random->Uniform(0.0, 1.0);
    parameter.lower = 0.0;
    model.push_back(parameter);
  }
  ParameterSet set({}, {}, model);
  for (int i = 0; i < kUnknowns; ++i) set.coordinate(i).free = true;
  return set;
}

double Cost(const Linearization& here, const Eigen::VectorXd& delta) {
  return (here.jacobian * delta + here.residual).squaredNorm();
}

// Every set of pinned coordinates is tried; the best step inside the bounds wins.
double BestCost(const Linearization& here, const ParameterSet& set) {
  double best = std::numeric_limits<double>::infinity();
  for (int pins = 0; pins < 1 << kUnknowns; ++pins) {
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(kUnknowns);
    std::vector<int> free;
    for (int c = 0; c < kUnknowns; ++c) {
      if (pins >> c & 1) delta[c] = -set.Value(c);
      if (!(pins >> c & 1)) free.push_back(c);
    }
    if (!free.empty()) {
      const Eigen::MatrixXd columns = here.jacobian(Eigen::all, free);
      delta(free) = columns.colPivHouseholderQr().solve(-(here.residual + here.jacobian * delta));
    }
    bool inside = true;
    for (int c = 0; c < kUnknowns; ++c) inside = inside && set.Value(c) + delta[c] >= -1e-12;
    if (inside) best = std::min(best, Cost(here, delta));
  }
  return best;
}

TEST(BoundedStep, IsTheBestStepInsideTheBounds) {
  test::RandomNumbers random(3);
  int pinned = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const ParameterSet set = Bounded(&random);
    Linearization here;
    here.jacobian.resize(9, kUnknowns);
    here.residual.resize(9);
    for (double& x : here.jacobian.reshaped()) x = random.Uniform(-1.0, 1.0);
    for (double& x : here.residual) x = random.Uniform(-2.0, 2.0);
    for (int c = 0; c < kUnknowns; ++c) here.columns.push_back(c);
    const BoundedStep step = SolveBounded(here, set);
    ASSERT_TRUE(step.valid);
    for (int c = 0; c < kUnknowns; ++c) EXPECT_GE(set.Value(c) + step.delta[c], -1e-12);
    EXPECT_NEAR(Cost(here, step.delta), BestCost(here, set), 1e-9);
    pinned += static_cast<int>(step.pinned.size());
  }
  EXPECT_GT(pinned, 200);  // bounds rule in many of them
}

}  // namespace
}  // namespace sagitta::bounded_step_test
