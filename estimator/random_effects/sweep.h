// Normal equations given that some explanations hold: with columns M of the group, scaled by s,
//
//   L L' = I + s^2 M'GM,  W = L^-1 s M'G,  w = L^-1 s M'g:   G <- G - W'W,  g <- g - W'w,  R <- R - w'w.
#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "estimator/random_effects/evidence_score.h"

namespace sagitta {

// A group of columns with a common prior: `columns` of the normal equations, times `mixing` where that is not empty
// (one row per column).
struct ColumnGroup {
  std::vector<int> columns;
  Eigen::MatrixXd mixing;
  int num_scales = kNumScales;         // the first of kScales
  std::vector<int> not_negative = {};  // coefficients

  int size() const { return static_cast<int>(mixing.size() > 0 ? mixing.cols() : static_cast<long>(columns.size())); }
  // mixing' X of rows X, one per column; mixing' B mixing of a block B.
  Eigen::MatrixXd Mixed(Eigen::MatrixXd rows) const;
  Eigen::MatrixXd MixedBlock(Eigen::MatrixXd block) const;
};

// Both as one; its columns.
std::vector<int> ColumnsTogether(const ColumnGroup& a, const ColumnGroup& b);
ColumnGroup Joined(const ColumnGroup& a, const ColumnGroup& b);

// The columns of a group out of a matrix over all columns.
Eigen::MatrixXd ColumnsOf(const ColumnGroup& group, const Eigen::MatrixXd& matrix);
Eigen::MatrixXd OwnInformation(const ProjectedNormal& normal, const ColumnGroup& group);
Eigen::VectorXd OwnGradient(const ProjectedNormal& normal, const ColumnGroup& group);

// A group alone with what is believed.
GivenOthers GivenNothing(const ProjectedNormal& normal, const ColumnGroup& group);

// Values of the groups' coefficients, in typical sizes, and their covariance: -(M'GM + I/s^2)^-1 M'g, as the residual
// is predicted - measured.
struct GroupValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;

  // Of one of the groups.
  GroupValues Of(size_t group, const std::vector<const ColumnGroup*>& groups) const;
};
// scales: prior standard deviation of each group, in typical sizes.
GroupValues ValuesOf(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& groups,
                     const std::vector<double>& scales);

// Groups among themselves, for any scales: with D = diag(s), t = Q^-1 D M'g,
//
//   Q = I + D M'GM D;   of group k given the others:  I + s_k^2 G_k = ((Q^-1)_kk)^-1,  s_k g_k = ((Q^-1)_kk)^-1 t_k
//
// With A = Q^-1 one group costs the square of all columns, not the cube: its scale times r, e = 1/r^2 - 1,
//
//   A <- R^-1 (A - A_k e (I + e A_kk)^-1 A_k') R^-1,   log |Q| += log |I + e A_kk| + 2 n_k log r
//
// without it  A <- A - A_k A_kk^-1 A_k',  log |Q| += log |A_kk|,  of the other groups' rows and columns; and with one
// more, of which Q has the column q and the corner c: U = A q, i = (c - q'U)^-1,
//
//   A <- [A + U i U', -U i; -i U', i],   t_k = i (s_k g_k - q't),  t <- t - U t_k,   log |Q| -= log |i|
class Members {
 public:
  Members(const ProjectedNormal& normal, std::vector<const ColumnGroup*> groups, std::vector<double> scales);

  // The same with another scale of one group; without one; with one more at a place.
  void Rescale(size_t group, double scale);
  void Remove(size_t group);
  void Insert(size_t place, const ColumnGroup& group, double scale);
  const std::vector<double>& scales() const { return scales_; }
  GivenOthers Of(size_t group) const;
  double LogOfSigns(const ResidualLikelihood& likelihood) const;  // of all groups, each given the others
  // The others without it: with C = A_kk,  R + t_k' C^-1 t_k,  log |Q| + log |C|.
  struct Apart {
    Eigen::LLT<Eigen::MatrixXd> root;  // of C
    Eigen::VectorXd own;               // C^-1 t_k
    double residual = 0.0, log_det = 0.0;
  };
  Apart Without(size_t group) const;
  double residual() const { return residual_; }
  double log_det() const { return log_det_; }
  const Eigen::VectorXd& Standardised() const { return solved_; }  // t: minus the coefficients over their scales
  size_t size() const { return groups_.size(); }
  int NumScales(size_t group) const { return groups_[group]->num_scales; }
  long num_columns() const { return gradient_.size(); }
  // Where a group's columns begin among those of all.
  long First(size_t group) const { return first_[group]; }
  long SizeOf(size_t group) const { return groups_[group]->size(); }
  // s M'G of all groups, one after the other.
  Eigen::MatrixXd ScaledRows() const;

 private:
  friend class Sweep;
  friend GroupValues ValuesOf(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& groups,
                              const std::vector<double>& scales);

  Eigen::MatrixXd Information() const;  // M'GM
  Eigen::VectorXd Scales() const;       // of every column
  void SetFirst();
  void SetResidual();  // of gradient and t

  const ProjectedNormal* normal_;
  std::vector<const ColumnGroup*> groups_;
  std::vector<long> first_;   // column of each, and the end
  Eigen::VectorXd gradient_;  // M'g
  std::vector<double> scales_;
  Eigen::MatrixXd inverse_;  // Q^-1
  Eigen::VectorXd solved_;   // t
  double residual_ = 0.0, log_det_ = 0.0;
};

// All columns given groups that come and go one at a time. With Z = D M'G and T = Q^-1 Z of all columns, G - Z'T is
// left of G; of that only the rows of the group that comes and the blocks that are asked for are made:
//
//   a group comes:  as above, G, g, R what is left before; T_k = L^-T W, T <- T - U T_k
//   a group goes:   with C = A_kk: g += T_k' C^-1 t_k, R += t_k' C^-1 t_k, log |Q| += log |C|, T <- T - A_k C^-1 T_k
class Sweep {
 public:
  Sweep(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& given, const std::vector<double>& scales);

  void Insert(size_t place, const ColumnGroup& group, double scale);
  void Remove(size_t group);

  Eigen::MatrixXd Information(const ColumnGroup& group) const;
  Eigen::VectorXd Gradient(const ColumnGroup& group) const;
  // T of a group's columns; Z'T: what conditioning removes from its own information.
  Eigen::MatrixXd Solved(const ColumnGroup& group) const { return ColumnsOf(group, solved_); }
  Eigen::MatrixXd Taken(const ColumnGroup& group) const;
  double residual() const { return members_.residual(); }
  const Members& members() const { return members_; }

  // Given all but one of the groups.
  struct WithoutOne : Members::Apart {
    // What it adds to G and g of a group with this T:  T_k' C^-1 T_k,  T_k' C^-1 t_k.
    Eigen::MatrixXd Information(const Eigen::MatrixXd& solved) const;
    Eigen::VectorXd Gradient(const Eigen::MatrixXd& solved) const;

    long top = 0;  // row of T_k in T
  };
  WithoutOne Without(size_t group) const;
  // Given all but each of these: a row of g each, of all columns.
  Eigen::MatrixXd Gradients(const std::vector<WithoutOne>& without) const;

 private:
  long FreeRows(long size);  // top of so many rows that no group has

  // Z'T of columns: many groups mix the same ones, and follow each other.
  struct TakenColumns {
    std::vector<int> columns;
    Eigen::MatrixXd taken;
  };

  Members members_;
  mutable TakenColumns latest_;    // until a group comes or goes
  std::vector<long> tops_;         // row of each group in Z and T, which stay where they are
  Eigen::MatrixXd rows_, solved_;  // Z and T; what no group has is zero
  Eigen::VectorXd gradient_;       // g that is left
};

}  // namespace sagitta
