// Dense algebra of normal equations, a few dozen columns: what every Gauss-Newton step and every covariance is made of.
// Instructions are chosen at run time.
#pragma once

#include <Eigen/Core>
#include <utility>

namespace sagitta {

// J'J
Eigen::MatrixXd SelfProduct(const Eigen::MatrixXd& j);

// W upper triangular with W W' = A^-1; empty where A is not positive definite. A symmetric, its columns scaled alike:
// no pivots are sought.
Eigen::MatrixXd InverseRoot(const Eigen::MatrixXd& a);

// The least and the largest eigenvalue of A symmetric.
std::pair<double, double> EndsOfSpectrum(const Eigen::MatrixXd& a);

// W W' of W upper triangular.
Eigen::MatrixXd SquareOfRoot(const Eigen::MatrixXd& w);

}  // namespace sagitta
