#include "estimator/random_effects/sweep.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/least_squares/normal_algebra.h"
#include "estimator/least_squares/row_sums.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

constexpr long kSpareRows = 32;  // of a smooth function without a name, the widest groups: one more has room

// s M'G of one group.
Eigen::MatrixXd ScaledRowsOf(const ProjectedNormal& normal, const ColumnGroup& group, double scale) {
  return scale * group.Mixed(normal.information.Rows(group.columns));
}

Eigen::MatrixXd Cross(const ProjectedNormal& normal, const ColumnGroup& a, const ColumnGroup& b) {
  return a.Mixed(b.Mixed(normal.information.Between(a.columns, b.columns).transpose()).transpose());
}

// Of no columns none: a solver would ask where the first one lies.
Eigen::MatrixXd Solved(const Eigen::LLT<Eigen::MatrixXd>& root, const Eigen::MatrixXd& right) {
  if (right.cols() == 0) return right;
  return root.solve(right);
}

}  // namespace

Eigen::MatrixXd ColumnGroup::Mixed(Eigen::MatrixXd rows) const {
  if (mixing.size() == 0) return rows;
  return mixing.transpose() * rows;
}

Eigen::MatrixXd ColumnGroup::MixedBlock(Eigen::MatrixXd block) const {
  if (mixing.size() == 0) return block;
  return mixing.transpose() * block * mixing;
}

std::vector<int> ColumnsTogether(const ColumnGroup& a, const ColumnGroup& b) {
  std::vector<int> columns = a.columns;
  columns.insert(columns.end(), b.columns.begin(), b.columns.end());
  return columns;
}

ColumnGroup Joined(const ColumnGroup& a, const ColumnGroup& b) {
  ColumnGroup both;
  both.columns = ColumnsTogether(a, b);
  both.mixing.setZero(both.columns.size(), a.size() + b.size());
  const auto put = [&both](const ColumnGroup& group, long row, long column) {
    const long height = static_cast<long>(group.columns.size());
    both.mixing.block(row, column, height, group.size()) =
        group.mixing.size() > 0 ? group.mixing : Eigen::MatrixXd::Identity(height, height);
  };
  put(a, 0, 0);
  put(b, static_cast<long>(a.columns.size()), a.size());
  both.not_negative = a.not_negative;
  for (const int c : b.not_negative) both.not_negative.push_back(a.size() + c);
  return both;
}

Eigen::MatrixXd ColumnsOf(const ColumnGroup& group, const Eigen::MatrixXd& matrix) {
  Eigen::MatrixXd own(matrix.rows(), group.columns.size());
  for (long c = 0; c < own.cols(); ++c) own.col(c) = matrix.col(group.columns[c]);
  if (group.mixing.size() == 0) return own;
  return own * group.mixing;
}

Eigen::MatrixXd OwnInformation(const ProjectedNormal& normal, const ColumnGroup& group) {
  return group.MixedBlock(normal.information.Own(group.columns));
}

Eigen::VectorXd OwnGradient(const ProjectedNormal& normal, const ColumnGroup& group) {
  return group.Mixed(normal.gradient(group.columns));
}

GivenOthers GivenNothing(const ProjectedNormal& normal, const ColumnGroup& group) {
  return {OwnInformation(normal, group),
          OwnGradient(normal, group),
          normal.residual,
          0.0,
          group.num_scales,
          group.not_negative};
}

// Q = I + D M'GM D,  W W' = Q^-1,  t = Q^-1 D M'g,  log |Q| = -2 sum log W_ii.
Members::Members(const ProjectedNormal& normal, std::vector<const ColumnGroup*> groups, std::vector<double> scales)
    : normal_(&normal), groups_(std::move(groups)), scales_(std::move(scales)) {
  SetFirst();
  gradient_.resize(first_.back());
  for (size_t k = 0; k < size(); ++k) gradient_.segment(first_[k], SizeOf(k)) = OwnGradient(normal, *groups_[k]);
  const Eigen::VectorXd diagonal = Scales();
  Eigen::MatrixXd inner = diagonal.asDiagonal() * Information() * diagonal.asDiagonal();
  inner.diagonal().array() += 1.0;
  const Eigen::MatrixXd root = InverseRoot(inner);
  inverse_ = SquareOfRoot(root);
  solved_ = inverse_ * diagonal.cwiseProduct(gradient_);
  log_det_ = -2.0 * root.diagonal().array().log().sum();
  SetResidual();
}

void Members::SetFirst() {
  first_.assign(1, 0);
  for (const ColumnGroup* group : groups_) first_.push_back(first_.back() + group->size());
}

Eigen::VectorXd Members::Scales() const {
  Eigen::VectorXd scales(num_columns());
  for (size_t k = 0; k < size(); ++k) scales.segment(first_[k], SizeOf(k)).setConstant(scales_[k]);
  return scales;
}

Eigen::MatrixXd Members::Information() const {
  std::vector<const std::vector<int>*> lists;
  for (const ColumnGroup* group : groups_) lists.push_back(&group->columns);
  normal_->information.AskTogether(lists);
  Eigen::MatrixXd information(num_columns(), num_columns());
  for (size_t i = 0; i < size(); ++i) {
    information.block(first_[i], first_[i], SizeOf(i), SizeOf(i)) = OwnInformation(*normal_, *groups_[i]);
    for (size_t j = 0; j < i; ++j) {
      const Eigen::MatrixXd block = Cross(*normal_, *groups_[i], *groups_[j]);
      information.block(first_[i], first_[j], block.rows(), block.cols()) = block;
      information.block(first_[j], first_[i], block.cols(), block.rows()) = block.transpose();
    }
  }
  return information;
}

Eigen::MatrixXd Members::ScaledRows() const {
  Eigen::MatrixXd rows(num_columns(), normal_->gradient.size());
  for (size_t k = 0; k < size(); ++k) {
    rows.middleRows(first_[k], SizeOf(k)) = ScaledRowsOf(*normal_, *groups_[k], scales_[k]);
  }
  return rows;
}

// `extra`: e;  `beside`: A_k;  `left`: (I + e A_kk)^-1 A_k';  `own`: (I + e A_kk)^-1 t_k.
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

// `beside`: A_k;  t <- t - A_k A_kk^-1 t_k. Of the group itself nothing is left.
void Members::Remove(size_t group) {
  const long first = first_[group], size = SizeOf(group);
  const Apart apart = Without(group);
  const Eigen::MatrixXd beside = inverse_.middleCols(first, size), left = apart.root.solve(beside.transpose());
  inverse_.noalias() -= beside * left;
  solved_ -= beside * apart.own;
  log_det_ = apart.log_det;
  const long last = num_columns() - first - size;
  Eigen::MatrixXd inverse(first + last, first + last);
  inverse << inverse_.topLeftCorner(first, first), inverse_.topRightCorner(first, last),
      inverse_.bottomLeftCorner(last, first), inverse_.bottomRightCorner(last, last);
  Eigen::VectorXd solved(first + last), gradient(first + last);
  solved << solved_.head(first), solved_.tail(last);
  gradient << gradient_.head(first), gradient_.tail(last);
  inverse_ = std::move(inverse);
  solved_ = std::move(solved);
  gradient_ = std::move(gradient);
  groups_.erase(groups_.begin() + static_cast<long>(group));
  scales_.erase(scales_.begin() + static_cast<long>(group));
  SetFirst();
  SetResidual();
}

// `column`: q;  `beside`: U = A q;  `corner`: c - q'U = i^-1.
void Members::Insert(size_t place, const ColumnGroup& group, double scale) {
  const long count = num_columns(), more = group.size(), first = first_[place], last = count - first;
  Eigen::MatrixXd column(count, more);
  for (size_t k = 0; k < size(); ++k) {
    column.middleRows(first_[k], SizeOf(k)) = scale * scales_[k] * Cross(*normal_, *groups_[k], group);
  }
  const Eigen::MatrixXd beside = inverse_ * column;
  Eigen::MatrixXd corner = scale * scale * OwnInformation(*normal_, group) - column.transpose() * beside;
  corner.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> root(corner);
  const Eigen::VectorXd gradient = OwnGradient(*normal_, group);
  const Eigen::MatrixXd left = Solved(root, beside.transpose());  // i U'
  const Eigen::VectorXd own = root.solve(scale * gradient - column.transpose() * solved_);
  inverse_.noalias() += beside * left;
  Eigen::MatrixXd inverse(count + more, count + more);
  inverse << inverse_.topLeftCorner(first, first), -left.leftCols(first).transpose(),
      inverse_.topRightCorner(first, last),                                                             //
      -left.leftCols(first), root.solve(Eigen::MatrixXd::Identity(more, more)), -left.rightCols(last),  //
      inverse_.bottomLeftCorner(last, first), -left.rightCols(last).transpose(), inverse_.bottomRightCorner(last, last);
  solved_ -= beside * own;
  Eigen::VectorXd solved(count + more), gradients(count + more);
  solved << solved_.head(first), own, solved_.tail(last);
  gradients << gradient_.head(first), gradient, gradient_.tail(last);
  inverse_ = std::move(inverse);
  solved_ = std::move(solved);
  gradient_ = std::move(gradients);
  log_det_ += LogDeterminant(root);
  groups_.insert(groups_.begin() + static_cast<long>(place), &group);
  scales_.insert(scales_.begin() + static_cast<long>(place), scale);
  SetFirst();
  SetResidual();
}

// R - g'M D t = R - g'M D Q^-1 D M'g.
void Members::SetResidual() { residual_ = normal_->residual - Scales().cwiseProduct(gradient_).dot(solved_); }

Members::Apart Members::Without(size_t group) const {
  const long first = first_[group], size = SizeOf(group);
  const Eigen::VectorXd solved = solved_.segment(first, size);
  Apart apart;
  apart.root.compute(inverse_.block(first, first, size, size));
  apart.own = apart.root.solve(solved);
  apart.residual = residual_ + solved.dot(apart.own);
  apart.log_det = log_det_ + LogDeterminant(apart.root);
  return apart;
}

// s_k^2 G_k = A_kk^-1 - I,  s_k g_k = A_kk^-1 t_k.
GivenOthers Members::Of(size_t group) const {
  const Apart apart = Without(group);
  const double scale = scales_[group];
  GivenOthers given{apart.root.solve(Eigen::MatrixXd::Identity(SizeOf(group), SizeOf(group))),
                    apart.own / scale,
                    apart.residual,
                    apart.log_det,
                    groups_[group]->num_scales,
                    groups_[group]->not_negative};
  given.information.diagonal().array() -= 1.0;
  given.information /= scale * scale;
  return given;
}

double Members::LogOfSigns(const ResidualLikelihood& likelihood) const {
  double sum = 0.0;
  for (size_t k = 0; k < size(); ++k) {
    if (!groups_[k]->not_negative.empty()) sum += sagitta::LogOfSigns(likelihood, Of(k), scales_[k]);
  }
  return sum;
}

Sweep::Sweep(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& given,
             const std::vector<double>& scales)
    : members_(normal, given, scales), gradient_(normal.gradient) {
  tops_.assign(members_.first_.begin(), members_.first_.end() - 1);
  rows_ = members_.ScaledRows();
  solved_ = TallProduct(rows_.transpose(), members_.inverse_).transpose();
  gradient_ -= rows_.transpose() * members_.solved_;
}

// `rows`: W = L^-1 s M'G, then T_k = L^-T W;  `along`: w;  `beside`: U = s T M, M of the new group.
void Sweep::Insert(size_t place, const ColumnGroup& group, double scale) {
  const Eigen::MatrixXd own = ScaledRowsOf(*members_.normal_, group, scale);
  Eigen::MatrixXd rows = own;  // s M'G of what is left
  rows -= scale * TallProduct(ColumnsOf(group, rows_).transpose(), solved_);
  Eigen::MatrixXd inner = scale * ColumnsOf(group, rows);
  inner.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> factor(inner);
  const Eigen::VectorXd along = factor.matrixL().solve(scale * Gradient(group));
  const Eigen::MatrixXd beside = scale * ColumnsOf(group, solved_);
  factor.matrixL().solveInPlace(rows);  // W
  gradient_.noalias() -= rows.transpose() * along;
  factor.matrixU().solveInPlace(rows);  // T of the group
  solved_.noalias() -= beside * rows;
  const long top = FreeRows(group.size());
  latest_ = {};
  members_.Insert(place, group, scale);
  tops_.insert(tops_.begin() + place, top);
  solved_.middleRows(top, rows.rows()) = rows;
  rows_.middleRows(top, rows.rows()) = own;
}

// The first gap that is large enough, or below all others: then there is room for some more.
long Sweep::FreeRows(long size) {
  std::map<long, long> taken;  // end of each, by its top
  for (size_t k = 0; k < tops_.size(); ++k) taken[tops_[k]] = tops_[k] + members_.SizeOf(k);
  long top = 0;
  for (const auto& [own, end] : taken) {
    if (own - top >= size) return top;
    top = end;
  }
  const long before = solved_.rows();
  if (top + size <= before) return top;
  const long more = top + size + kSpareRows - before;
  for (Eigen::MatrixXd* matrix : {&rows_, &solved_}) {
    matrix->conservativeResize(before + more, gradient_.size());
    matrix->bottomRows(more).setZero();
  }
  return top;
}

void Sweep::Remove(size_t group) {
  const long size = members_.SizeOf(group), top = tops_[group];
  const WithoutOne without = Without(group);
  gradient_ += without.Gradient(solved_);
  Eigen::MatrixXd beside = Eigen::MatrixXd::Zero(solved_.rows(), size);  // A_k, by rows of T
  for (size_t k = 0; k < tops_.size(); ++k) {
    beside.middleRows(tops_[k], members_.SizeOf(k)) =
        members_.inverse_.block(members_.First(k), members_.First(group), members_.SizeOf(k), size);
  }
  const Eigen::MatrixXd of_group = without.root.solve(Eigen::MatrixXd(solved_.middleRows(top, size)));
  solved_.noalias() -= beside * of_group;
  solved_.middleRows(top, size).setZero();
  rows_.middleRows(top, size).setZero();
  latest_ = {};
  members_.Remove(group);
  tops_.erase(tops_.begin() + group);
}

Eigen::MatrixXd Sweep::Taken(const ColumnGroup& group) const {
  if (latest_.columns != group.columns) {
    const ColumnGroup plain{group.columns, {}};
    latest_ = {group.columns, ColumnsOf(plain, rows_).transpose() * ColumnsOf(plain, solved_)};
  }
  return group.MixedBlock(latest_.taken);
}

Eigen::MatrixXd Sweep::Information(const ColumnGroup& group) const {
  return OwnInformation(*members_.normal_, group) - Taken(group);
}

Eigen::VectorXd Sweep::Gradient(const ColumnGroup& group) const { return group.Mixed(gradient_(group.columns)); }

Sweep::WithoutOne Sweep::Without(size_t group) const { return {members_.Without(group), tops_[group]}; }

// X'X,  X = C^(-1/2) T_k.
Eigen::MatrixXd Sweep::WithoutOne::Information(const Eigen::MatrixXd& solved) const {
  const Eigen::MatrixXd x = root.matrixL().solve(solved.middleRows(top, own.size()));
  return x.transpose() * x;
}

Eigen::VectorXd Sweep::WithoutOne::Gradient(const Eigen::MatrixXd& solved) const {
  return solved.middleRows(top, own.size()).transpose() * own;
}

Eigen::MatrixXd Sweep::Gradients(const std::vector<WithoutOne>& without) const {
  Eigen::MatrixXd gradients(static_cast<long>(without.size()), gradient_.size());
  for (size_t m = 0; m < without.size(); ++m) {
    gradients.row(m) = (gradient_ + without[m].Gradient(solved_)).transpose();
  }
  return gradients;
}

// (M'GM + D^-2)^-1 = D Q^-1 D:  values -D t,  covariance D A D.
GroupValues ValuesOf(const ProjectedNormal& normal, const std::vector<const ColumnGroup*>& groups,
                     const std::vector<double>& scales) {
  const Members members(normal, groups, scales);
  const Eigen::VectorXd scale = members.Scales();
  return {-scale.cwiseProduct(members.solved_), scale.asDiagonal() * members.inverse_ * scale.asDiagonal()};
}

GroupValues GroupValues::Of(size_t group, const std::vector<const ColumnGroup*>& groups) const {
  long first = 0;
  for (size_t k = 0; k < group; ++k) first += groups[k]->size();
  const long size = groups[group]->size();
  return {values.segment(first, size), covariance.block(first, first, size, size)};
}

}  // namespace sagitta
