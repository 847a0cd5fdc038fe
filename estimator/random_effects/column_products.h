// G = A'PA of the columns that may explain something, what is believed eliminated. A search asks for little of it: what
// each group says of itself, and the rows of those groups that were members of a set. Where whatever gives rows can be
// asked again, nothing else is made; G as a whole costs its rows times the square of its columns.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <vector>

#include "estimator/statistics/ascending.h"

namespace sagitta {

// G, known in part.
class ColumnProducts {
 public:
  // Rows of G, one per listed column.
  using RowsOf = std::function<Eigen::MatrixXd(const std::vector<int>& columns)>;
  // Blocks of G of some lists of columns with themselves.
  using OwnBlocks = std::map<std::vector<int>, Eigen::MatrixXd>;

  ColumnProducts() = default;
  ColumnProducts(const Eigen::MatrixXd& whole);  // NOLINT: a matrix is one
  ColumnProducts(OwnBlocks own, RowsOf rows_of) : own_(std::move(own)), rows_of_(std::move(rows_of)) {}

  Eigen::MatrixXd Own(const std::vector<int>& columns) const;
  Eigen::MatrixXd Between(const std::vector<int>& a, const std::vector<int>& b) const;
  // Listed columns x all columns.
  Eigen::MatrixXd Rows(const std::vector<int>& columns) const;
  // Makes the rows of several lists in one pass, which costs little more than those of one: the blocks between them are
  // asked for next. Where one list alone is not known the others' rows say all of it.
  void AskTogether(const std::vector<const std::vector<int>*>& lists) const;

 private:
  bool IsKnown(int column) const;
  bool AreKnown(const std::vector<int>& columns) const;
  void Ask(const std::vector<int>& columns) const;  // for those that are not known

  OwnBlocks own_;
  RowsOf rows_of_;
  mutable std::vector<Eigen::VectorXd> known_;  // rows that were asked for, or of the whole, by column; else empty
};

}  // namespace sagitta
