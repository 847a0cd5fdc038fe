#include "estimator/diagnosis/sweep.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace sagitta {
namespace {

// s M' of all groups, one after the other, applied to rows of a matrix.
Eigen::MatrixXd RowsOf(const std::vector<const ColumnGroup*>& groups, const std::vector<double>& scales,
                       const Eigen::MatrixXd& matrix) {
  int size = 0;
  for (const ColumnGroup* group : groups) size += group->size();
  Eigen::MatrixXd rows(size, matrix.cols());
  int at = 0;
  for (size_t k = 0; k < groups.size(); ++k) {
    const ColumnGroup& group = *groups[k];
    auto own = rows.middleRows(at, group.size());
    if (group.mixing.size() > 0) {
      own.noalias() = scales[k] * (group.mixing.transpose() * matrix(group.columns, Eigen::all));
    } else {
      own = scales[k] * matrix(group.columns, Eigen::all);
    }
    at += group.size();
  }
  return rows;
}

}  // namespace

Sweep::Sweep(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& given,
             const std::vector<double>& scales)
    : normal_(normal), residual_(normal.residual) {
  if (given.empty()) return;
  root_ = RowsOf(given, scales, normal.information);
  Eigen::MatrixXd inner = RowsOf(given, scales, root_.transpose());
  inner.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> factor(inner);
  factor.matrixL().solveInPlace(root_);
  along_ = factor.matrixL().solve(RowsOf(given, scales, normal.gradient));
  residual_ -= along_.squaredNorm();
  log_det_ = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

Eigen::MatrixXd Sweep::Information(const ColumnGroup& group) const {
  Eigen::MatrixXd block = normal_.information(group.columns, group.columns);
  if (root_.rows() > 0) {
    const Eigen::MatrixXd own = root_(Eigen::all, group.columns);
    block.noalias() -= own.transpose() * own;
  }
  if (group.mixing.size() == 0) return block;
  return group.mixing.transpose() * block * group.mixing;
}

Eigen::VectorXd Sweep::Gradient(const ColumnGroup& group) const {
  Eigen::VectorXd gradient = normal_.gradient(group.columns);
  if (root_.rows() > 0) gradient.noalias() -= root_(Eigen::all, group.columns).transpose() * along_;
  if (group.mixing.size() == 0) return gradient;
  return group.mixing.transpose() * gradient;
}

SmallSweep::SmallSweep(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& given,
                       const std::vector<double>& scales, const ColumnGroup& asked) {
  // Columns of all groups alone; then as ever.
  std::vector<int> needed = asked.columns;
  for (const ColumnGroup* group : given) needed.insert(needed.end(), group->columns.begin(), group->columns.end());
  std::sort(needed.begin(), needed.end());
  needed.erase(std::unique(needed.begin(), needed.end()), needed.end());
  const auto at = [&](ColumnGroup group) {
    for (int& column : group.columns) {
      column = static_cast<int>(std::lower_bound(needed.begin(), needed.end(), column) - needed.begin());
    }
    return group;
  };
  const ProjectedNormal few{normal.information(needed, needed), normal.gradient(needed), normal.residual, normal.dof};
  std::vector<ColumnGroup> placed;
  for (const ColumnGroup* group : given) placed.push_back(at(*group));
  std::vector<const ColumnGroup*> groups;
  for (const ColumnGroup& group : placed) groups.push_back(&group);
  const Sweep sweep(few, groups, scales);
  const ColumnGroup own = at(asked);
  information = sweep.Information(own);
  gradient = sweep.Gradient(own);
  residual = sweep.residual();
  log_det = sweep.log_det();
}

GroupValues ValuesOf(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& groups,
                     const std::vector<double>& scales) {
  const Eigen::MatrixXd rows = RowsOf(groups, scales, normal.information);
  Eigen::MatrixXd inner = RowsOf(groups, scales, rows.transpose());
  inner.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> factor(inner);
  Eigen::VectorXd scale(inner.rows());
  int at = 0;
  for (size_t k = 0; k < groups.size(); ++k) {
    scale.segment(at, groups[k]->size()).setConstant(scales[k]);
    at += groups[k]->size();
  }
  GroupValues result;
  result.values = -scale.cwiseProduct(factor.solve(RowsOf(groups, scales, normal.gradient)).col(0));
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(inner.rows(), inner.rows());
  result.covariance = scale.asDiagonal() * factor.solve(identity) * scale.asDiagonal();
  return result;
}

}  // namespace sagitta
