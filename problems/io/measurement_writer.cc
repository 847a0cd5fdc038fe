#include "problems/io/measurement_writer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "problems/io/text_checks.h"
#include "problems/io/units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// A column's name in its parts: quantity x, q1, sigma_x .., unit "" where it has none of ours.
struct Column {
  std::string quantity;
  std::string unit;
  std::optional<Dimension> dimension;  // of the unit

  std::string Name() const { return unit.empty() ? quantity : quantity + "_" + unit; }
  bool IsLength() const { return dimension == Dimension::kSmallLength; }
  bool IsAngle() const { return dimension == Dimension::kAngle; }
  // In one unit or two.
  bool IsOfTheSame(const Column& other) const { return quantity == other.quantity && dimension == other.dimension; }
};

Column ColumnNamed(const std::string& name) {
  const size_t underscore = name.rfind('_');
  if (underscore != std::string::npos) {
    for (const Dimension dimension : {Dimension::kSmallLength, Dimension::kAngle}) {
      for (const Unit& unit : UnitsOf(dimension)) {
        if (name.substr(underscore + 1) == unit.suffix) return {name.substr(0, underscore), unit.suffix, dimension};
      }
    }
  }
  return {name, "", std::nullopt};
}

std::vector<std::vector<Column>> NamedColumnsOf(const std::vector<MeasurementFile>& files) {
  std::vector<std::vector<Column>> columns(files.size());
  for (size_t f = 0; f < files.size(); ++f) {
    for (const std::string& name : files[f].header) columns[f].push_back(ColumnNamed(name));
  }
  return columns;
}

// 0, 1, 2 for the measured point's coordinates, else -1.
int PointAxis(const Column& column) {
  if (!column.IsLength() || column.quantity.size() != 1) return -1;
  const int axis = column.quantity[0] - 'x';
  return axis >= 0 && axis < 3 ? axis : -1;
}

// 0, 1, 2 for the rotation vector's coordinates, else -1.
int RotationAxis(const Column& column) {
  if (!column.IsAngle() || column.quantity.size() != 2 || column.quantity[0] != 'r') return -1;
  const int axis = column.quantity[1] - 'x';
  return axis >= 0 && axis < 3 ? axis : -1;
}

// Parts of a quaternion: rotations are written as vectors.
bool IsQuaternionColumn(const Column& column) {
  return column.unit.empty() && column.quantity.size() == 2 && column.quantity[0] == 'o' &&
         column.quantity.find_first_of("wxyz", 1) == 1;
}

// The cell in another unit; as it stands when nothing changes or it is no number.
std::string InOtherUnit(const std::string& cell, const std::string& from, const std::string& to) {
  if (from == to || from.empty() || to.empty()) return cell;
  const std::optional<double> number = ParseNumber(cell);
  return number ? FormatNumber(ToUnit(UnitNamed(from).ToSi(*number), UnitNamed(to))) : cell;
}

// Where a column of the file goes: to that of its name, else, unless the file has the quantity in two units, to that in
// whatever unit. -1: there is none.
int PlaceInOutput(const Column& column, const std::vector<Column>& file, const std::vector<Column>& columns) {
  const auto same = [&](const Column& other) { return other.IsOfTheSame(column); };
  const auto of_its_name = [&](const Column& other) { return same(other) && other.unit == column.unit; };
  auto found = std::find_if(columns.begin(), columns.end(), of_its_name);
  const bool is_alone = std::count_if(file.begin(), file.end(), same) <= 1;
  if (found == columns.end() && is_alone) found = std::find_if(columns.begin(), columns.end(), same);
  return found == columns.end() ? -1 : static_cast<int>(found - columns.begin());
}

// Every quantity of any file once, in order of appearance, points in mm, rotations in mrad.
std::vector<Column> UnionOfColumns(const std::vector<std::vector<Column>>& files, bool with_rotations) {
  std::vector<Column> columns;
  const auto add = [&columns](Column column, const std::vector<Column>& file) {
    if (IsQuaternionColumn(column)) return;
    if (PointAxis(column) >= 0) column.unit = "mm";
    if (RotationAxis(column) >= 0) column.unit = "mrad";
    if (PlaceInOutput(column, file, columns) < 0) columns.push_back(std::move(column));
  };
  for (const std::vector<Column>& file : files) {
    for (const Column& column : file) add(column, file);
  }
  for (const char* axis : {"x", "y", "z"}) add({axis, "mm", Dimension::kSmallLength}, {});
  for (const char* axis : {"rx", "ry", "rz"}) {
    if (with_rotations) add({axis, "mrad", Dimension::kAngle}, {});
  }
  return columns;
}

// For every column where it stands in the file and in which unit, -1: nowhere.
struct Source {
  int index = -1;
  std::string unit;
};

std::vector<Source> SourcesIn(const std::vector<Column>& file, const std::vector<Column>& columns) {
  std::vector<Source> sources(columns.size());
  for (size_t i = 0; i < file.size(); ++i) {
    const int place = PlaceInOutput(file[i], file, columns);
    if (place >= 0) sources[place] = {static_cast<int>(i), file[i].unit};
  }
  return sources;
}

// 0, 1, 2 for the standard deviations of the point's coordinates, else -1.
int SigmaAxis(const Column& column) {
  if (!column.IsLength() || column.quantity.size() != 7 || column.quantity.rfind("sigma_", 0) != 0) return -1;
  const int axis = column.quantity.back() - 'x';
  return axis >= 0 && axis < 3 ? axis : -1;
}

}  // namespace

void StateSigma(double sigma, Measurements* data) {
  for (Observation& observation : data->observations) {
    if (observation.is_point()) observation.sigma.setConstant(sigma);
  }
  for (MeasurementFile& file : data->files) {
    std::vector<std::string> stated(file.header.size());  // the cell of each column of standard deviations
    std::vector<bool> is_sigma(file.header.size(), false);
    for (size_t c = 0; c < file.header.size(); ++c) {
      const Column column = ColumnNamed(file.header[c]);
      is_sigma[c] = SigmaAxis(column) >= 0;
      if (is_sigma[c] && sigma > 0.0) stated[c] = FormatNumber(ToUnit(sigma, UnitNamed(column.unit)));
    }
    if (std::find(is_sigma.begin(), is_sigma.end(), true) == is_sigma.end()) continue;
    MeasurementRows rows;
    for (const MeasurementRows::Row row : file.rows) {
      rows.BeginRow(row.line);
      for (size_t c = 0; c < row.cells.size(); ++c) rows.AddCell(is_sigma[c] ? stated[c] : row.cells[c]);
    }
    file.rows = rows;
  }
}

std::string MeasurementsToCsv(const Measurements& data) {
  const std::vector<bool> oriented = data.OrientedMarkers();
  const std::vector<std::vector<Column>> files = NamedColumnsOf(data.files);
  const std::vector<Column> columns =
      UnionOfColumns(files, std::find(oriented.begin(), oriented.end(), true) != oriented.end());
  std::vector<std::vector<Source>> sources;
  for (const std::vector<Column>& file : files) sources.push_back(SourcesIn(file, columns));
  std::string csv;
  for (size_t c = 0; c < columns.size(); ++c) csv += (c > 0 ? "," : "") + CsvCell(columns[c].Name());
  csv += "\n";
  for (const Observation& observation : data.observations) {
    if (!observation.is_point()) continue;  // in the line of its point
    if (observation.file < 0) {
      throw InputError(data.WhereOf(observation, ""),
                       "the row is of no file: the columns of its joint values are not known",
                       "write these rows yourself (docs/FORMATS.md, section 2)");
    }
    const MeasurementRows::Cells cells = data.files[observation.file].rows[observation.row].cells;
    for (size_t c = 0; c < columns.size(); ++c) {
      if (c > 0) csv += ",";
      const int axis = PointAxis(columns[c]);
      const Source& source = sources[observation.file][c];
      if (axis >= 0) {
        const double value = observation.point_in_station[axis];
        if (!std::isnan(value)) csv += FormatNumber(ToUnit(value, UnitNamed("mm")));
      } else if (RotationAxis(columns[c]) >= 0) {
        if (observation.partner < 0) continue;
        const Matrix3<double>& rotation = data.observations[observation.partner].rotation().in_station;
        const double value = RotationVector(rotation)[RotationAxis(columns[c])];
        if (!std::isnan(value)) csv += FormatNumber(ToUnit(value, UnitNamed("mrad")));
      } else if (source.index >= 0) {
        csv += CsvCell(InOtherUnit(std::string(cells[source.index]), source.unit, columns[c].unit));
      }
    }
    csv += "\n";
  }
  return csv;
}

}  // namespace sagitta
