// A residual, columns that are believed and columns that may explain it, few enough to write every density out.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "estimator/random_effects/evidence_score.h"

namespace sagitta::test {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline Eigen::MatrixXd Random(int rows, int cols, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

// Believed columns, explanations, residual; and an orthonormal basis of what the believed ones leave.
struct Small {
  Eigen::MatrixXd believed, columns, left;
  Eigen::VectorXd residual;

  Small(int rows, int believed_columns, int explanations, unsigned seed)
      : believed(Random(rows, believed_columns, seed)),
        columns(Random(rows, explanations, seed + 1)),
        residual(Random(rows, 1, seed + 2)) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(believed);
    left = (qr.householderQ() * Eigen::MatrixXd::Identity(rows, rows)).rightCols(rows - believed_columns);
  }

  ProjectedNormal Normal() const {
    const Eigen::MatrixXd a = left.transpose() * columns;
    const Eigen::VectorXd r = left.transpose() * residual;
    return {Eigen::MatrixXd(a.transpose() * a), a.transpose() * r, r.squaredNorm(), static_cast<double>(r.size())};
  }

  // Log density of the residual given the believed columns, without (2 pi)^(-n/2), sigma times `factor`.
  double LogDensity(const Eigen::MatrixXd& coefficients_root, double factor = 1.0) const {
    const Eigen::MatrixXd a = left.transpose() * columns * coefficients_root;
    const Eigen::VectorXd r = left.transpose() * residual;
    const Eigen::MatrixXd covariance =
        factor * factor * (Eigen::MatrixXd::Identity(r.size(), r.size()) + a * a.transpose());
    return -0.5 * std::log(covariance.determinant()) - 0.5 * r.dot(covariance.inverse() * r);
  }
};

inline Eigen::MatrixXd AllOf(const ProjectedNormal& normal) {
  std::vector<int> all(static_cast<size_t>(normal.gradient.size()));
  std::iota(all.begin(), all.end(), 0);
  return normal.information.Own(all);
}

inline double Integrate(const std::function<double(double)>& f, double from, double to) {
  constexpr int kSteps = 20000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) sum += f(from + (to - from) * (i + 0.5) / kSteps);
  return sum * (to - from) / kSteps;
}

}  // namespace sagitta::test
