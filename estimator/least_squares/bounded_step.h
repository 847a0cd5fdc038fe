// The Gauss-Newton step of a linearization whose coordinates have lower bounds.
//
//   min |J d + r|^2   so that   value_c + d_c >= lower_c
//
// by an active set: what the free step would push below its bound stops there and the
// rest is solved again; what would rather leave its bound then is let go. Damped: with `damping` |D d|^2 added, D the
// norms of the columns of J (Marquardt).
#pragma once

#include <Eigen/Core>

#include "estimator/least_squares/linearization.h"

namespace sagitta {

struct BoundedStep {
  bool valid = false;
  Eigen::VectorXd delta;    // one per column, SI
  Eigen::MatrixXd root;     // of (J'J)^-1 of the columns that are free; zero rows where a bound rules
  double size = 0.0;        // largest move, in standard deviations
  std::vector<int> pinned;  // columns that end on their bound
};

BoundedStep SolveBounded(const Linearization& here, const ParameterSet& parameters, double damping = 0.0);

// Moves the columns' coordinates by `share` of delta.
void Move(const std::vector<int>& columns, const Eigen::VectorXd& delta, double share, ParameterSet* parameters);

// The step that leads from one set of values to another (ParameterSet::Plus), one entry per coordinate, SI.
Eigen::VectorXd TangentDifference(const ParameterSet& to, const ParameterSet& from);

}  // namespace sagitta
