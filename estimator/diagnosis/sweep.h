// Normal equations given that some explanations hold: with columns M of the group, scaled by s,
//
//   L L' = I + s^2 M'GM,  W = L^-1 s M'G,  w = L^-1 s M'g:   G <- G - W'W,  g <- g - W'w,  R <- R - w'w.
//
// Blocks of what is left are computed when asked for; the whole matrix is never copied.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimator/diagnosis/evidence_score.h"

namespace sagitta {

// A group of columns with a common prior: `columns` of the normal equations, times `mixing` where that is not empty
// (one row per column).
struct ColumnGroup {
  std::vector<int> columns;
  Eigen::MatrixXd mixing;

  int size() const { return static_cast<int>(mixing.size() > 0 ? mixing.cols() : static_cast<long>(columns.size())); }
};

// Given groups and the scale of each.
class Sweep {
 public:
  Sweep(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& given, const std::vector<double>& scales);

  // Of one more group, given those.
  Eigen::MatrixXd Information(const ColumnGroup& group) const;
  Eigen::VectorXd Gradient(const ColumnGroup& group) const;
  double residual() const { return residual_; }
  double log_det() const { return log_det_; }

 private:
  const ProjectedNormal& normal_;
  Eigen::MatrixXd root_;   // W
  Eigen::VectorXd along_;  // w
  double residual_ = 0.0;
  double log_det_ = 0.0;  // of L L'
};

// The same for one group alone, without what is left of the others.
struct SmallSweep {
  SmallSweep(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& given,
             const std::vector<double>& scales, const ColumnGroup& asked);

  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double residual = 0.0;
  double log_det = 0.0;
};

// Values of the groups' coefficients, in typical sizes, and their covariance: -(M'GM + I/s^2)^-1 M'g, as the residual
// is predicted - measured.
struct GroupValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
};
GroupValues ValuesOf(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& groups,
                     const std::vector<double>& scales);

}  // namespace sagitta
