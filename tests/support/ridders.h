// Numerical derivatives by Ridders' extrapolation of central differences
// (C. Ridders, Adv. Eng. Software 4, 1982; step divisor as in Numerical Recipes).
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>

namespace sagitta::test {

// d function / dx at x for a function double -> VectorXd; `step` about the
// length over which the function is smooth.
template <typename Function>
Eigen::VectorXd RiddersDerivative(const Function& function, double x, double step) {
  constexpr int kTable = 10;
  constexpr double kShrink = 1.4;
  std::array<std::array<Eigen::VectorXd, kTable>, kTable> table;
  const auto difference = [&](double h) { return Eigen::VectorXd((function(x + h) - function(x - h)) / (2.0 * h)); };
  double best_error = std::numeric_limits<double>::max();
  table[0][0] = difference(step);
  Eigen::VectorXd best = table[0][0];
  for (int i = 1; i < kTable; ++i) {
    step /= kShrink;
    table[0][i] = difference(step);
    double factor = kShrink * kShrink;
    for (int k = 1; k <= i; ++k, factor *= kShrink * kShrink) {
      table[k][i] = (factor * table[k - 1][i] - table[k - 1][i - 1]) / (factor - 1.0);
      const double error = std::max((table[k][i] - table[k - 1][i]).norm(), (table[k][i] - table[k - 1][i - 1]).norm());
      if (error <= best_error) {
        best_error = error;
        best = table[k][i];
      }
    }
    if ((table[i][i] - table[i - 1][i - 1]).norm() >= 2.0 * best_error) break;
  }
  return best;
}

}  // namespace sagitta::test
