#include "estimator/random_effects/column_products.h"

#include <algorithm>

namespace sagitta {

ColumnProducts::ColumnProducts(const Eigen::MatrixXd& whole) {
  for (const auto& row : whole.rowwise()) known_.push_back(row);
}

Eigen::MatrixXd ColumnProducts::Own(const std::vector<int>& columns) const {
  const auto own = own_.find(columns);
  return own != own_.end() ? own->second : Between(columns, columns);
}

Eigen::MatrixXd ColumnProducts::Between(const std::vector<int>& a, const std::vector<int>& b) const {
  if (!AreKnown(a) && AreKnown(b)) return Between(b, a).transpose();
  Ask(a);
  Eigen::MatrixXd between(static_cast<long>(a.size()), b.size());
  for (size_t k = 0; k < a.size(); ++k) between.row(k) = known_[a[k]](b);
  return between;
}

Eigen::MatrixXd ColumnProducts::Rows(const std::vector<int>& columns) const {
  Ask(columns);
  Eigen::MatrixXd rows(static_cast<long>(columns.size()), columns.empty() ? 0 : known_[columns[0]].size());
  for (size_t k = 0; k < columns.size(); ++k) rows.row(k) = known_[columns[k]];
  return rows;
}

void ColumnProducts::AskTogether(const std::vector<const std::vector<int>*>& lists) const {
  std::vector<int> all;
  int unknown = 0;
  for (const std::vector<int>* list : lists) {
    if (AreKnown(*list)) continue;
    ++unknown;
    all.insert(all.end(), list->begin(), list->end());
  }
  if (unknown > 1) Ask(EachOnce(all));
}

void ColumnProducts::Ask(const std::vector<int>& columns) const {
  std::vector<int> asked;
  for (const int column : columns) {
    if (!IsKnown(column)) asked.push_back(column);
  }
  if (asked.empty()) return;
  const Eigen::MatrixXd rows = rows_of_(asked);
  known_.resize(static_cast<size_t>(rows.cols()));
  for (size_t k = 0; k < asked.size(); ++k) known_[asked[k]] = rows.row(k);
}

bool ColumnProducts::IsKnown(int column) const {
  return static_cast<size_t>(column) < known_.size() && known_[column].size() > 0;
}

bool ColumnProducts::AreKnown(const std::vector<int>& columns) const {
  return std::all_of(columns.begin(), columns.end(), [this](int column) { return IsKnown(column); });
}

}  // namespace sagitta
