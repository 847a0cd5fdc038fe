#include "estimator/results/residuals_csv.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "estimator/least_squares/linearization.h"
#include "problems/io/files.h"
#include "problems/io/text_checks.h"

namespace sagitta {
namespace {

std::vector<std::string> UnionOfColumns(const Measurements& data, const std::vector<WrittenColumn>& added) {
  std::vector<std::string> names;
  const auto add = [&names](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const MeasurementFile& file : data.files) {
    for (const std::string& name : file.header) add(name);
  }
  for (const WrittenColumn& column : added) add(column.name);
  return names;
}

const WrittenColumn* Find(const std::vector<WrittenColumn>& added, const std::string& name) {
  const auto found = std::find_if(added.begin(), added.end(), [&](const WrittenColumn& c) { return c.name == name; });
  return found == added.end() ? nullptr : &*found;
}

std::vector<int> AllObservations(const Measurements& data) {
  std::vector<int> all(data.observations.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// A column that is written row by row: nobody keeps its text.
struct WrittenColumn {
  std::string name;
  std::function<void(size_t observation, std::string* line)> write;  // the cell of an observation
};

void AddNumber(double number, std::string* line) {
  if (std::isfinite(number)) *line += FormatNumber(number);
}

// Columns <prefix><axis><suffix> of numbers as they are; <prefix>r<axis><rotation_suffix> in the row of its point where
// any row is a pose. `numbers` must outlive them.
std::vector<WrittenColumn> AxisColumns(const std::string& prefix, const std::string& suffix,
                                       const std::string& rotation_suffix, const Measurements& data,
                                       const Eigen::Matrix3Xd& numbers) {
  const std::vector<bool> oriented = data.OrientedMarkers();
  const bool has_poses = std::find(oriented.begin(), oriented.end(), true) != oriented.end();
  std::vector<WrittenColumn> columns;
  for (const bool of_rotation : {false, true}) {
    if (of_rotation && !has_poses) break;
    for (int axis = 0; axis < 3; ++axis) {
      columns.push_back({prefix + (of_rotation ? "r" : "") + "xyz"[axis] + (of_rotation ? rotation_suffix : suffix),
                         [&data, &numbers, of_rotation, axis](size_t i, std::string* line) {
                           const int source = of_rotation ? data.observations[i].partner : static_cast<int>(i);
                           if (source >= 0) AddNumber(numbers(axis, source), line);
                         }});
    }
  }
  return columns;
}

// With their text.
std::vector<AddedColumn> TextOf(const std::vector<WrittenColumn>& columns, size_t observations) {
  std::vector<AddedColumn> texts;
  for (const WrittenColumn& column : columns) {
    AddedColumn& text = texts.emplace_back();
    text.name = column.name;
    text.cells.resize(observations);
    for (size_t i = 0; i < observations; ++i) column.write(i, &text.cells[i]);
  }
  return texts;
}

// Whether a robust loss flagged the row of each observation.
std::vector<bool> Outliers(const Measurements& data, const NoiseReport& report) {
  std::vector<bool> outliers(data.observations.size(), false);
  for (const Outlier& outlier : report.outliers) {
    outliers[outlier.observation] = true;
    const int partner = data.observations[outlier.observation].partner;
    if (partner >= 0) outliers[partner] = true;
  }
  return outliers;
}

std::string WriteRows(const Measurements& data, const std::vector<WrittenColumn>& added) {
  constexpr size_t kRowsForSize = 1000;
  const std::vector<std::string> names = UnionOfColumns(data, added);
  std::vector<const WrittenColumn*> replaced;
  std::vector<std::vector<int>> index(data.files.size());  // of each column in each file, -1: none
  std::string csv;
  for (const std::string& name : names) {
    csv += (csv.empty() ? "" : ",") + CsvCell(name);
    replaced.push_back(Find(added, name));
    for (size_t f = 0; f < data.files.size(); ++f) index[f].push_back(data.files[f].FindColumn(name));
  }
  csv += "\n";
  for (size_t i = 0; i < data.observations.size(); ++i) {
    if (i == kRowsForSize) csv.reserve(csv.size() / i * (data.observations.size() + data.observations.size() / 16));
    const Observation& observation = data.observations[i];
    if (!observation.is_point()) continue;  // in the line of its point
    const std::vector<std::string>& cells = data.files[observation.file].rows[observation.row].cells;
    for (size_t c = 0; c < names.size(); ++c) {
      if (c > 0) csv += ",";
      const int source = index[observation.file][c];
      if (replaced[c] != nullptr) {
        replaced[c]->write(i, &csv);
      } else if (source >= 0) {
        AddCsvCell(cells[source], &csv);
      }
    }
    csv += "\n";
  }
  return csv;
}

}  // namespace

std::string RowsToCsv(const Measurements& data, const std::vector<AddedColumn>& added) {
  std::vector<WrittenColumn> columns;
  for (const AddedColumn& column : added) {
    columns.push_back({column.name, [&column](size_t i, std::string* line) { AddCsvCell(column.cells[i], line); }});
  }
  return WriteRows(data, columns);
}

std::vector<AddedColumn> ReadingColumns(const std::string& prefix, const Measurements& data,
                                        const Eigen::Matrix3Xd& readings) {
  const Eigen::Matrix3Xd shown = 1e3 * readings;
  return TextOf(AxisColumns(prefix, "_mm", "_mrad", data, shown), data.observations.size());
}

std::vector<AddedColumn> ResidualColumns(const Measurements& data, const Eigen::Matrix3Xd& predicted) {
  return ReadingColumns("res_", data, ResidualsOf(data, AllObservations(data), predicted));
}

Eigen::Matrix3Xd WhitenedResiduals(const CalibrationProblem& problem, const Estimate& estimate) {
  Eigen::Matrix3Xd whitened = ResidualsOf(problem.data, AllObservations(problem.data), estimate.predicted);
  for (int i = 0; i < whitened.cols(); ++i) whitened.col(i) = estimate.scatter[i].inverse() * whitened.col(i);
  return whitened;
}

std::string ResidualsToCsv(const CalibrationProblem& problem, const Estimate& estimate) {
  const Measurements& data = problem.data;
  const Eigen::Matrix3Xd predicted = 1e3 * estimate.predicted;
  const Eigen::Matrix3Xd residuals = 1e3 * ResidualsOf(data, AllObservations(data), estimate.predicted);
  const Eigen::Matrix3Xd whitened = WhitenedResiduals(problem, estimate);
  std::vector<WrittenColumn> added = AxisColumns("pred_", "_mm", "_mrad", data, predicted);
  const auto append = [&added](const std::vector<WrittenColumn>& columns) {
    added.insert(added.end(), columns.begin(), columns.end());
  };
  append(AxisColumns("res_", "_mm", "_mrad", data, residuals));
  append(AxisColumns("whitened_", "", "", data, whitened));
  added.push_back({"leverage", [&](size_t i, std::string* line) {
                     const int partner = data.observations[i].partner;
                     const double own = estimate.leverage[static_cast<Eigen::Index>(i)];
                     AddNumber(partner < 0 ? own : 0.5 * (own + estimate.leverage[partner]), line);
                   }});
  added.push_back({"set", [&](size_t i, std::string* line) {
                     *line += data.IsValidation(data.observations[i]) ? "validation" : "calibration";
                   }});
  const std::vector<bool> outliers = Outliers(data, estimate.noise_report);
  if (estimate.noise_report.loss != "none") {
    added.push_back({"outlier", [&](size_t i, std::string* line) { *line += outliers[i] ? "1" : "0"; }});
  }
  return WriteRows(data, added);
}

}  // namespace sagitta
