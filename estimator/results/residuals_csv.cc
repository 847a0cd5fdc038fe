#include "estimator/results/residuals_csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/parallel.h"
#include "problems/io/rows_in_memory.h"
#include "problems/io/text_checks.h"

namespace sagitta {
namespace {

constexpr int kLinesOfPiece = 256;  // that are handed on together
constexpr int kPiecesOfWriter = 8;  // per thread, made before they are written

std::vector<std::string> UnionOfColumns(const Measurements& data, const std::vector<AddedColumn>& added) {
  std::vector<std::string> names;
  const auto add = [&names](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const MeasurementFile& file : data.files) {
    for (const std::string& name : file.header) add(name);
  }
  for (const AddedColumn& column : added) add(column.name);
  return names;
}

const AddedColumn* FindAdded(const std::vector<AddedColumn>& added, const std::string& name) {
  const auto found = std::find_if(added.begin(), added.end(), [&](const AddedColumn& c) { return c.name == name; });
  return found == added.end() ? nullptr : &*found;
}

std::vector<int> AllObservations(const Measurements& data) {
  std::vector<int> all(data.observations.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

constexpr size_t kMostLetters = 32;  // of a number: sign, 17 digits, point and exponent are 24

// Appends numbers of columns that follow each other in a line, a comma before each but the line's first: the shortest
// texts that read back to the same. Returns where they end.
size_t AddNumbers(const std::vector<const AddedColumn*>& columns, size_t first, size_t row, std::string* buffer,
                  std::string* csv) {
  buffer->resize(kMostLetters * columns.size());
  char* end = buffer->data();
  size_t c = first;
  for (; c < columns.size() && columns[c] != nullptr && columns[c]->cells.empty(); ++c) {
    if (c > 0) *end++ = ',';
    const double number = columns[c]->numbers[row];
    if (std::isfinite(number)) end = std::to_chars(end, end + kMostLetters - 1, number).ptr;
  }
  csv->append(buffer->data(), end);
  return c;
}

// Columns <prefix><axis><suffix> of numbers as they are; <prefix>r<axis><rotation_suffix> in the row of its point where
// any row is a pose.
std::vector<AddedColumn> AxisColumns(const std::string& prefix, const std::string& suffix,
                                     const std::string& rotation_suffix, const Measurements& data,
                                     const Eigen::Matrix3Xd& numbers) {
  const std::vector<bool> oriented = data.OrientedMarkers();
  const bool has_poses = std::find(oriented.begin(), oriented.end(), true) != oriented.end();
  std::vector<AddedColumn> columns;
  for (const bool of_rotation : {false, true}) {
    if (of_rotation && !has_poses) break;
    for (int axis = 0; axis < 3; ++axis) {
      AddedColumn column{prefix + (of_rotation ? "r" : "") + "xyz"[axis] + (of_rotation ? rotation_suffix : suffix),
                         {}};
      column.numbers.reserve(static_cast<size_t>(numbers.cols()));
      for (int i = 0; i < numbers.cols(); ++i) {
        const int source = of_rotation ? data.observations[i].partner : i;
        column.numbers.push_back(source < 0 ? std::nan("") : numbers(axis, source));
      }
      columns.push_back(std::move(column));
    }
  }
  return columns;
}

// 1 where a robust loss flagged the row.
AddedColumn OutlierColumn(const Measurements& data, const NoiseReport& report) {
  AddedColumn column{"outlier", std::vector<std::string>(data.observations.size(), "0")};
  for (const Outlier& outlier : report.outliers) {
    column.cells[outlier.observation] = "1";
    const int partner = data.observations[outlier.observation].partner;
    if (partner >= 0) column.cells[partner] = "1";
  }
  return column;
}

// The first cells of a row, at least one, as they lie in its file.
std::string_view FirstCells(const MeasurementRows::Cells& cells, size_t count) {
  const std::string_view first = cells[0], last = cells[count - 1];
  return {first.data(), static_cast<size_t>(last.data() + last.size() - first.data())};
}

// How many columns are a file's own, in its order, before one is not. index: of each column in the file.
size_t CountOwn(const std::vector<int>& index, const std::vector<const AddedColumn*>& replaced) {
  size_t own = 0;
  while (own < index.size() && index[own] == static_cast<int>(own) && replaced[own] == nullptr) ++own;
  return own;
}

// Lines of the file, each by itself.
class CsvLines {
 public:
  CsvLines(const Measurements& data, const std::vector<AddedColumn>& added)
      : data_(data), names_(UnionOfColumns(data, added)), index_(data.files.size()) {
    for (const std::string& name : names_) {
      replaced_.push_back(FindAdded(added, name));
      for (size_t f = 0; f < data.files.size(); ++f) index_[f].push_back(data.files[f].FindColumn(name));
    }
    for (const std::vector<int>& of_file : index_) own_columns_.push_back(CountOwn(of_file, replaced_));
  }

  std::string Header() const {
    std::string csv;
    for (const std::string& name : names_) csv += (csv.empty() ? "" : ",") + CsvCell(name);
    return csv + "\n";
  }

  // numbers: memory for their texts.
  void Append(size_t i, std::string* numbers, std::string* csv) const {
    const Observation& observation = data_.observations[i];
    if (!observation.is_point()) return;  // in the line of its point
    const MeasurementRows::Cells cells = data_.files[observation.file].rows[observation.row].cells;
    const size_t together = own_columns_[observation.file];
    const bool are_taken = together > 0 && AddCsvCells(FirstCells(cells, together), together, csv);
    for (size_t c = are_taken ? together : 0; c < names_.size();) {
      const size_t next = AddNumbers(replaced_, c, i, numbers, csv);
      if (next > c) {
        c = next;
        continue;
      }
      if (c > 0) *csv += ',';
      const int source = index_[observation.file][c];
      if (replaced_[c] != nullptr) {
        AddCsvCell(replaced_[c]->cells[i], csv);
      } else if (source >= 0) {
        AddCsvCell(cells[source], csv);
      }
      ++c;
    }
    *csv += '\n';
  }

 private:
  const Measurements& data_;
  const std::vector<std::string> names_;
  std::vector<const AddedColumn*> replaced_;
  std::vector<std::vector<int>> index_;  // of each column in each file, -1: none
  std::vector<size_t> own_columns_;      // of each file, that come first
};

}  // namespace

std::string RowsToCsv(const Measurements& data, const std::vector<AddedColumn>& added) {
  std::string csv;
  RowsToCsv(data, added, [&csv](const std::string& piece) { csv += piece; });
  return csv;
}

void RowsToCsv(const Measurements& data, const std::vector<AddedColumn>& added, const TextSink& write,
               int num_threads) {
  struct Piece {
    std::string csv, numbers;
  };
  std::optional<Measurements> made;
  const CsvLines lines(WithCells(data, &made), added);
  const int count = static_cast<int>(data.observations.size());
  std::vector<Piece> pieces(static_cast<size_t>(num_threads == 1 ? 1 : kPiecesOfWriter * num_threads));
  write(lines.Header());
  MakeAndUse((count + kLinesOfPiece - 1) / kLinesOfPiece, num_threads, static_cast<int>(pieces.size()),
             [&](int p, int slot) {
               Piece& piece = pieces[static_cast<size_t>(slot)];
               piece.csv.clear();
               for (int i = p * kLinesOfPiece; i < std::min(count, (p + 1) * kLinesOfPiece); ++i) {
                 lines.Append(static_cast<size_t>(i), &piece.numbers, &piece.csv);
               }
             },
             [&](int slot, int user) {
               if (user == 0) write(pieces[static_cast<size_t>(slot)].csv);
             });
}

void CheckAreOf(const Measurements& rows, size_t results, const char* function) {
  if (results == rows.observations.size()) return;
  throw std::invalid_argument(std::string(function) + ": these are results of " + std::to_string(results) +
                              " rows, there are " + std::to_string(rows.observations.size()));
}

std::vector<AddedColumn> ReadingColumns(const std::string& prefix, const Measurements& data,
                                        const Eigen::Matrix3Xd& readings) {
  return AxisColumns(prefix, "_mm", "_mrad", data, 1e3 * readings);
}

std::vector<AddedColumn> ResidualColumns(const Measurements& data, const Eigen::Matrix3Xd& predicted) {
  return ReadingColumns("res_", data, ResidualsOf(data, AllObservations(data), predicted));
}

namespace {

Eigen::Matrix3Xd Whitened(const Measurements& data, const Eigen::Matrix3Xd& predicted, const NoiseRoots& scatter) {
  Eigen::Matrix3Xd whitened = ResidualsOf(data, AllObservations(data), predicted);
  for (int i = 0; i < whitened.cols(); ++i) {
    const bool is_known = !Matrix3<double>(scatter[i]).isZero(0.0);
    if (is_known) whitened.col(i) = scatter[i].inverse() * whitened.col(i);
    if (!is_known) whitened.col(i).setConstant(std::nan(""));
  }
  return whitened;
}

}  // namespace

Eigen::Matrix3Xd WhitenedResiduals(const CalibrationProblem& problem, const Estimate& estimate) {
  return Whitened(problem.data(), estimate.predicted, estimate.scatter);
}

std::vector<AddedColumn> WhitenedColumns(const Measurements& data, const Eigen::Matrix3Xd& predicted,
                                         const NoiseRoots& scatter) {
  return AxisColumns("whitened_", "", "", data, Whitened(data, predicted, scatter));
}

std::vector<double> LeverageOfRows(const Measurements& data, const Estimate& estimate) {
  std::vector<double> leverage;
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const int partner = data.observations[i].partner;
    const double own = estimate.leverage[i];
    leverage.push_back(partner < 0 ? own : 0.5 * (own + estimate.leverage[partner]));
  }
  return leverage;
}

std::string ResidualsToCsv(const CalibrationProblem& problem, const Estimate& estimate) {
  std::string csv;
  ResidualsToCsv(problem, estimate, [&csv](const std::string& piece) { csv += piece; });
  return csv;
}

void ResidualsToCsv(const CalibrationProblem& problem, const Estimate& estimate, const TextSink& write,
                    int num_threads) {
  const Measurements& data = problem.data();
  std::vector<AddedColumn> added = ReadingColumns("pred_", data, estimate.predicted);
  const auto append = [&added](std::vector<AddedColumn> columns) {  // a tracker stream's are not copied
    for (AddedColumn& column : columns) added.push_back(std::move(column));
  };
  append(ResidualColumns(data, estimate.predicted));
  append(WhitenedColumns(data, estimate.predicted, estimate.scatter));
  AddedColumn set{"set", {}};
  for (const Observation& row : data.observations) {
    set.cells.push_back(data.IsValidation(row) ? "validation" : "calibration");
  }
  added.push_back({"leverage", {}, LeverageOfRows(data, estimate)});
  added.push_back(std::move(set));
  if (estimate.noise_report.loss != LossKind::kNone) added.push_back(OutlierColumn(data, estimate.noise_report));
  RowsToCsv(data, added, write, num_threads);
}

LongText ResidualsFile(const CalibrationProblem& problem, const Estimate& estimate, int num_threads) {
  return {"residuals.csv", [&problem, &estimate, num_threads](const TextSink& write) {
            ResidualsToCsv(problem, estimate, write, num_threads);
          }};
}

}  // namespace sagitta
