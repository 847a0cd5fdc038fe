#include "estimator/least_squares/part_sums.h"

#include <optional>
#include <utility>

namespace sagitta {

// Of a few partitions: observations that go together in all of them are summed once.
class PartSums::Cells {
 public:
  explicit Cells(std::size_t observations) : cell_of_(observations, 0) { cells_.emplace_back(); }

  // False: there would be too many cells.
  bool Take(const Partition& partition) {
    constexpr std::size_t kMost = 128;  // 7 MB with 56 unknowns
    const auto sides = static_cast<std::size_t>(partition.parts) + 1;
    std::vector<int> number(cells_.size() * sides, -1), cell_of;
    cell_of.reserve(cell_of_.size());
    std::vector<Cell> cells;
    for (std::size_t k = 0; k < cell_of_.size(); ++k) {
      const auto before = static_cast<std::size_t>(cell_of_[k]);
      int& own = number[before * sides + static_cast<std::size_t>(partition.part_of[k] + 1)];
      if (own < 0) {
        own = static_cast<int>(cells.size());
        cells.emplace_back().parts = cells_[before].parts;
        cells.back().parts.push_back(partition.part_of[k]);
      }
      cell_of.push_back(own);
    }
    if (!parts_.empty() && cells.size() > kMost) return false;
    cell_of_ = std::move(cell_of);
    cells_ = std::move(cells);
    parts_.push_back(partition.parts);
    return true;
  }

  void Add(int position, const double* rows, int numbers, const Share& share) {
    const auto cell = static_cast<std::size_t>(cell_of_[static_cast<std::size_t>(position)]);
    if (!share.Has(cell)) return;
    Cell& own = cells_[cell];
    if (!own.sum) own.sum.emplace(numbers);
    for (int axis = 0; axis < 3; ++axis) own.sum->Add(rows + axis * numbers);
    own.rows += 3;
  }

  // Appends the parts of its partitions.
  void AddTo(const NormalSums& none, SummedParts* sums) {
    const std::size_t first = sums->parts.size();
    for (const int count : parts_) sums->parts.emplace_back(static_cast<std::size_t>(count), none);
    sums->all = none;
    for (Cell& cell : cells_) {
      if (!cell.sum) continue;
      const Eigen::MatrixXd total = cell.sum->Total();
      const auto add = [&](NormalSums* to) { to->matrix += total, to->rows += cell.rows; };
      add(&sums->all);
      for (std::size_t d = 0; d < cell.parts.size(); ++d) {
        if (cell.parts[d] >= 0) add(&sums->parts[first + d][static_cast<std::size_t>(cell.parts[d])]);
      }
    }
  }

 private:
  struct Cell {
    std::vector<int> parts;  // of each partition, the one that has it
    std::optional<SumOfRows> sum;
    int rows = 0;
  };
  std::vector<int> parts_;    // of each partition, how many
  std::vector<int> cell_of_;  // of each observation
  std::vector<Cell> cells_;
};

PartSums::PartSums(std::size_t observations, const std::vector<int>& columns)
    : observations_(observations),
      none_{true, columns, Eigen::MatrixXd::Zero(columns.size() + 1, columns.size() + 1), 0} {
  cells_.push_back(std::make_unique<Cells>(observations_));
}

PartSums::~PartSums() = default;

void PartSums::Divide(const Partition& partition) {
  if (cells_.back()->Take(partition)) return;
  cells_.push_back(std::make_unique<Cells>(observations_));
  cells_.back()->Take(partition);
}

void PartSums::Add(int position, const double* rows, const Share& share) {
  for (const std::unique_ptr<Cells>& own : cells_) own->Add(position, rows, none_.num_columns() + 1, share);
}

void PartSums::Add(const RowPiece& piece, const Share& share) {
  for (int i = 0; i < piece.num_observations(); ++i) Add(piece.positions[i], &piece.rows(3 * i, 0), share);
}

SummedParts PartSums::Totals() {
  SummedParts sums;
  for (const std::unique_ptr<Cells>& own : cells_) own->AddTo(none_, &sums);
  return sums;
}

}  // namespace sagitta
