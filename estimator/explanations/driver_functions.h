// Functions of what drives a deviation, one row per shot: what an unnamed smooth function, a wave or a jump is made of.
// Random functions have unit variance where their coefficients have.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "models/effects/bump.h"

namespace sagitta {

// Bumps as wide as they are apart: a random smooth function with a correlation length of that distance. Or ramps.
Eigen::MatrixXd OverKnots(const Eigen::VectorXd& x, const Knots& knots);
// cos and sin.
Eigen::MatrixX2d Wave(const Eigen::VectorXd& phase);
// exp(i x): of multiples by products, which round a hundred times at most.
Eigen::ArrayXcd Turn(const Eigen::ArrayXd& x);
// Its values, each once, ascending.
std::vector<double> Distinct(const Eigen::VectorXd& x);
// Neighbours among the distinct values of x, at most so many pairs.
using Gap = std::pair<double, double>;
std::vector<Gap> Gaps(const Eigen::VectorXd& x, int most);
// A jump somewhere in a gap: 0 below, 1 above, within it the probability that it lies before x.
Eigen::VectorXd Jump(const Eigen::VectorXd& x, const Gap& gap);

// One in each of so many stretches of equally many distinct values, in ascending order; fewer where there are fewer.
Eigen::MatrixXd Stretches(const Eigen::VectorXd& x, int most);

// So many unit vectors, evenly over half of the sphere (z >= 0).
std::vector<Eigen::Vector3d> HalfOfAllDirections(int count);

// functions = basis * mixing: fewer columns where many functions are alike.
struct Compressed {
  Eigen::MatrixXd basis, mixing;
};
// To within `tolerance` of the largest singular value.
Compressed Compress(const Eigen::MatrixXd& functions, double tolerance);

}  // namespace sagitta
