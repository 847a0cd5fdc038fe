#include "estimator/diagnosis/sweep.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimator/least_squares/row_sums.h"

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

Eigen::MatrixXd ColumnsOf(const ColumnGroup& group, const Eigen::MatrixXd& matrix) {
  if (group.mixing.size() == 0) return matrix(Eigen::all, group.columns);
  return matrix(Eigen::all, group.columns) * group.mixing;
}

Eigen::MatrixXd OwnInformation(const ProjectedNormal& normal, const ColumnGroup& group) {
  const Eigen::MatrixXd block = normal.information(group.columns, group.columns);
  if (group.mixing.size() == 0) return block;
  return group.mixing.transpose() * block * group.mixing;
}

Eigen::VectorXd OwnGradient(const ProjectedNormal& normal, const ColumnGroup& group) {
  const Eigen::VectorXd own = normal.gradient(group.columns);
  if (group.mixing.size() == 0) return own;
  return group.mixing.transpose() * own;
}

Members::Members(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& groups)
    : first_(1, 0), residual_given_none_(normal.residual) {
  for (const ColumnGroup* group : groups) first_.push_back(first_.back() + group->size());
  information_.resize(first_.back(), first_.back());
  gradient_.resize(first_.back());
  for (size_t i = 0; i < groups.size(); ++i) {
    gradient_.segment(first_[i], groups[i]->size()) = OwnGradient(normal, *groups[i]);
    for (size_t j = 0; j <= i; ++j) {
      Eigen::MatrixXd block = normal.information(groups[i]->columns, groups[j]->columns);
      if (groups[j]->mixing.size() > 0) block = block * groups[j]->mixing;
      if (groups[i]->mixing.size() > 0) block = groups[i]->mixing.transpose() * block;
      information_.block(first_[i], first_[j], block.rows(), block.cols()) = block;
      information_.block(first_[j], first_[i], block.cols(), block.rows()) = block.transpose();
    }
  }
}

void Members::Condition(const std::vector<double>& scales) {
  scales_ = scales;
  Eigen::VectorXd diagonal(num_columns());
  for (size_t k = 0; k < scales.size(); ++k)
    diagonal.segment(first_[k], first_[k + 1] - first_[k]).setConstant(scales[k]);
  Eigen::MatrixXd inner = diagonal.asDiagonal() * information_ * diagonal.asDiagonal();
  inner.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> root(inner);
  factor_ = root.matrixL();
  inverse_ = root.solve(Eigen::MatrixXd::Identity(num_columns(), num_columns()));
  const Eigen::VectorXd along = diagonal.cwiseProduct(gradient_);
  solved_ = root.solve(along);
  residual_ = residual_given_none_ - along.dot(solved_);
  log_det_ = 2.0 * factor_.diagonal().array().log().sum();
}

void Members::Rescale(size_t group, double scale) {
  const long first = first_[group], size = first_[group + 1] - first;
  const double ratio = scale / scales_[group], extra = 1.0 / (ratio * ratio) - 1.0;
  Eigen::MatrixXd inner = extra * inverse_.block(first, first, size, size);
  inner.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> root(inner);
  const Eigen::MatrixXd beside = inverse_.middleCols(first, size), left = root.solve(beside.transpose());
  const Eigen::VectorXd own = root.solve(solved_.segment(first, size));
  solved_.noalias() -= extra * (beside * own);
  inverse_.noalias() -= extra * (beside * left);
  // A_k - A_kk e (I + e A_kk)^-1 A_k = (I + e A_kk)^-1 A_k, without a difference of what is nearly equal.
  inverse_.middleRows(first, size) = left / ratio;
  inverse_.middleCols(first, size) = left.transpose() / ratio;
  inverse_.block(first, first, size, size) /= ratio;
  solved_.segment(first, size) = own / ratio;
  log_det_ += 2.0 * (root.matrixLLT().diagonal().array().log().sum() + static_cast<double>(size) * std::log(ratio));
  scales_[group] = scale;
  SetResidual();
}

Members Members::Without(size_t group) const {
  const long first = first_[group], size = first_[group + 1] - first;
  std::vector<long> kept;
  for (long c = 0; c < num_columns(); ++c) {
    if (c < first || c >= first + size) kept.push_back(c);
  }
  Members others = *this;
  others.first_.erase(others.first_.begin() + static_cast<long>(group) + 1);
  for (size_t k = group + 1; k < others.first_.size(); ++k) others.first_[k] -= size;
  others.scales_.erase(others.scales_.begin() + static_cast<long>(group));
  others.information_ = information_(kept, kept);
  others.gradient_ = gradient_(kept);
  const Eigen::LLT<Eigen::MatrixXd> root(inverse_.block(first, first, size, size));
  const Eigen::MatrixXd beside = inverse_(kept, Eigen::seqN(first, size));
  others.inverse_ = inverse_(kept, kept) - beside * root.solve(beside.transpose());
  others.solved_ = solved_(kept) - beside * root.solve(solved_.segment(first, size));
  others.log_det_ = log_det_ + 2.0 * root.matrixLLT().diagonal().array().log().sum();
  others.SetResidual();
  return others;
}

void Members::SetResidual() {
  residual_ = residual_given_none_;
  for (size_t k = 0; k < scales_.size(); ++k) {
    const long first = first_[k], size = first_[k + 1] - first;
    residual_ -= scales_[k] * gradient_.segment(first, size).dot(solved_.segment(first, size));
  }
}

GivenOthers Members::Of(size_t group) const {
  const long first = first_[group], size = first_[group + 1] - first;
  const Eigen::LLT<Eigen::MatrixXd> root(inverse_.block(first, first, size, size));
  const Eigen::VectorXd own = solved_.segment(first, size);
  const double scale = scales_[group];
  GivenOthers given;
  given.information = root.solve(Eigen::MatrixXd::Identity(size, size));
  given.information.diagonal().array() -= 1.0;
  given.information /= scale * scale;
  given.gradient = root.solve(own) / scale;
  given.residual = residual_ + own.dot(root.solve(own));
  given.log_det = log_det_ + 2.0 * root.matrixLLT().diagonal().array().log().sum();
  return given;
}

Sweep::Sweep(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& given,
             const std::vector<double>& scales)
    : normal_(normal), members_(normal, given), residual_(normal.residual) {
  if (given.empty()) return;
  members_.Condition(scales);
  const auto lower = members_.factor_.triangularView<Eigen::Lower>();
  const Eigen::Index count = members_.num_columns();
  Eigen::MatrixXd columns(normal.information.rows(), count);
  Eigen::Index at = 0;
  for (size_t k = 0; k < given.size(); ++k) {
    columns.middleCols(at, given[k]->size()) = scales[k] * ColumnsOf(*given[k], normal.information);
    at += given[k]->size();
  }
  const Eigen::MatrixXd inverse = lower.solve(Eigen::MatrixXd::Identity(count, count));
  root_ = TallProduct(columns, inverse.transpose()).transpose();  // L^-1 of the rows: the information is symmetric
  along_ = lower.solve(RowsOf(given, scales, normal.gradient)).col(0);
  residual_ -= along_.squaredNorm();
  log_det_ = members_.log_det_;
}

Eigen::MatrixXd Sweep::Taken(const ColumnGroup& group) const { return ColumnsOf(group, root_); }

Eigen::MatrixXd Sweep::Information(const ColumnGroup& group) const {
  Eigen::MatrixXd own = OwnInformation(normal_, group);
  if (root_.rows() == 0) return own;
  const Eigen::MatrixXd taken = Taken(group);
  own.noalias() -= taken.transpose() * taken;
  return own;
}

Eigen::VectorXd Sweep::Gradient(const ColumnGroup& group) const {
  Eigen::VectorXd own = OwnGradient(normal_, group);
  if (root_.rows() > 0) own.noalias() -= Taken(group).transpose() * along_;
  return own;
}

Sweep::WithoutOne Sweep::Without(size_t group) const {
  const long first = members_.first_[group], size = members_.first_[group + 1] - first;
  const Eigen::LLT<Eigen::MatrixXd> own(members_.inverse_.block(first, first, size, size));
  // Rows of L^-T of the group alone.
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(root_.rows(), size);
  rows.middleRows(first, size).setIdentity();
  members_.factor_.triangularView<Eigen::Lower>().solveInPlace(rows);
  WithoutOne without;
  without.root = own.matrixL().solve(rows.transpose() * root_);
  without.along = own.matrixL().solve(members_.solved_.segment(first, size));
  without.residual = residual_ + without.along.squaredNorm();
  without.log_det = log_det_ + 2.0 * own.matrixLLT().diagonal().array().log().sum();
  return without;
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
