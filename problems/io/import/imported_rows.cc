#include "problems/io/import/imported_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/files.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/time_column.h"
#include "problems/io/text_checks.h"
#include "problems/io/units.h"
#include "problems/limits.h"
#include "problems/measurements.h"

namespace sagitta {
namespace {

bool IsText(const PlannedColumn& column) { return column.unit.empty() && column.stem.rfind("approach", 0) != 0; }
bool IsSigma(const PlannedColumn& column) { return column.stem.rfind("sigma_", 0) == 0; }
bool IsRotation(const PlannedColumn& column) {
  return column.stem.size() == 2 && (column.stem[0] == 'r' || column.stem[0] == 'o');
}
bool IsRotationSigma(const PlannedColumn& column) { return column.stem.rfind("sigma_r", 0) == 0; }
bool IsTorque(const PlannedColumn& column) { return column.stem.rfind("tau", 0) == 0; }
bool IsRequired(const PlannedColumn& column) {
  return column.stem[0] == 'q' || column.stem == "x" || column.stem == "y" || column.stem == "z";
}

// A unit of measurements.csv for what it is used for here.
bool IsOurs(const std::string& unit) { return unit != "um" && unit != "cm" && unit != "in"; }

// A tracker that lost its target may write any number; beyond what a reader of measurements accepts none is a reading.
void CheckSize(const TextTable& table, const TextTable::Row& row, const PlannedColumn& column, double number) {
  if (!IsRequired(column) || column.unit.empty()) return;
  const double si = std::abs(UnitNamed(column.unit).ToSi(number));
  if (si <= (column.stem[0] == 'q' ? limits::kJointValue : limits::kCoordinate)) return;
  throw InputError({table.path, row.line, column.header}, FormatNumber(number) + " " + column.unit + " is no reading",
                   "a lost reading is an empty cell, NaN or -9999");
}

// {column of measurements.csv, cell} of a row's rotation, as a rotation vector and the standard deviations of its left
// perturbation; empty where a number is lost. Throws InputError for a cell that is neither.
std::map<std::string, std::string> RotationCells(const TextTable& table, const TextTable::Row& source,
                                                 const ImportPlan& plan) {
  std::vector<double> numbers;
  Vector3<double> sigmas = Vector3<double>::Zero();
  int stated = 0;
  std::map<std::string, std::string> cells;
  for (const PlannedColumn& column : plan.columns) {
    if (!IsRotation(column) && !IsRotationSigma(column)) continue;
    const std::string& cell = source.cells[static_cast<size_t>(column.source)];
    const std::optional<double> number = IsLostCell(cell) ? std::nullopt : table.Number(cell);
    if (!number && !IsLostCell(cell)) {
      throw InputError({table.path, source.line, column.header}, "'" + cell + "' is no number",
                       "a lost reading is an empty cell, NaN or -9999");
    }
    if (!number && IsRotation(column)) return {};
    const double value = !number ? 0.0 : column.unit == "1" ? *number : UnitNamed(column.unit).ToSi(*number);
    if (IsRotation(column)) {
      numbers.push_back(value);
    } else if (value > 0.0) {
      sigmas[column.stem[7] - 'x'] = value;
      ++stated;
    }
  }
  if (numbers.empty()) return {};
  const RotationReading& reading = *plan.rotation;
  if (reading.kind == RotationReading::Kind::kQuaternion) {
    double squared = 0.0;
    for (const double part : numbers) squared += part * part;
    if (std::abs(std::sqrt(squared) - 1.0) > 1e-2) return {};  // a tracker that lost its target writes zeros
  }
  const Vector3<double> vector = RotationVector(reading.StationFromTarget(numbers));
  const Vector3<double> turned =
      stated == 3 ? reading.PerturbationSigmas(numbers, sigmas) : Vector3<double>(Vector3<double>::Zero());
  for (int i = 0; i < 3; ++i) {
    const std::string name = std::string("r") + "xyz"[i] + "_mrad";
    cells[name] = FormatNumber(ToUnit(vector[i], UnitNamed("mrad")));
    if (stated == 3) cells["sigma_" + name] = FormatNumber(ToUnit(turned[i], UnitNamed("mrad")));
  }
  return cells;
}

}  // namespace

void ImportedRows::Add(const TextTable& table, const ImportPlan& plan, const RowDefaults& defaults, size_t stride) {
  size_t lost = 0, zeros = 0, without_sigma = 0, without_rotation = 0;
  int first_lost = 0;
  TimeColumn time;
  if (const PlannedColumn* column = plan.Find("time")) {
    time = LookAtTime(table, column->source);
    if (!time.why_not.empty()) notes_.push_back(table.path + ": '" + column->header + "' is not used: " + time.why_not);
  }
  std::vector<Row> rows;
  for (size_t r = 0; r < table.rows.size(); r += stride) {
    CheckInterruption();
    const TextTable::Row& source = table.rows[r];
    Row row;
    bool is_lost = false, sigma_lost = false, all_zero = true;
    for (const PlannedColumn& column : plan.columns) {
      if (IsRotation(column) || IsRotationSigma(column)) continue;
      const std::string& cell = source.cells[column.source];
      if (IsText(column)) {
        row[column.stem] = column.stem == "load" ? LoadName(table, column, cell) : PartOfName(cell, column.part);
        continue;
      }
      if (column.stem == "time") {
        if (!time.why_not.empty() || IsLostCell(cell)) continue;
        row["time_s"] = FormatNumber(time.stamps ? *SecondsOfStamp(cell) : *table.Number(cell));
        continue;
      }
      const bool gone = IsLostCell(cell) || (column.second >= 0 && IsLostCell(source.cells[column.second]));
      if (gone) {
        is_lost |= IsRequired(column);
        sigma_lost |= IsSigma(column);
        continue;
      }
      std::optional<double> number = table.Number(cell);
      if (number && column.second >= 0) {
        const std::optional<double> second = table.Number(source.cells[column.second]);
        number = second ? std::optional<double>(*number + column.sign * *second) : std::nullopt;
      }
      if (!number) {
        throw InputError({table.path, source.line, column.header}, "'" + cell + "' is no number",
                         "a lost reading is an empty cell, NaN or -9999");
      }
      if (IsSigma(column) && !(*number > 0.0)) sigma_lost = true;
      if (column.stem.size() == 1) all_zero &= *number == 0.0;
      CheckSize(table, source, column, *number);
      // In the unit that the first table has, um, cm and in in mm: elsewhere the digits stay as they are printed.
      if (IsTorque(column)) {
        row[column.stem + "_" + column.unit] = FormatNumber(*number);
        continue;
      }
      const std::string unit = unit_of_.emplace(column.stem, IsOurs(column.unit) ? column.unit : "mm").first->second;
      const bool converts = unit != column.unit && !column.unit.empty();
      const double value = converts ? ToUnit(UnitNamed(column.unit).ToSi(*number), UnitNamed(unit)) : *number;
      row[column.stem + (unit.empty() ? "" : "_" + unit)] = FormatNumber(value);
    }
    if (is_lost || all_zero) {
      if (lost + zeros == 0) first_lost = source.line;
      ++(is_lost ? lost : zeros);
      continue;
    }
    if (plan.rotation) {
      const auto rotation = RotationCells(table, source, plan);
      without_rotation += rotation.empty();
      row.insert(rotation.begin(), rotation.end());
    }
    if (sigma_lost) {
      ++without_sigma;
      for (auto it = row.begin(); it != row.end();)
        it = it->first.rfind("sigma_", 0) == 0 && it->first.rfind("sigma_r", 0) != 0 ? row.erase(it) : std::next(it);
    }
    DropPartOfTorques(plan, &row);
    row.emplace("station", defaults.station);
    row.emplace("marker", defaults.marker);
    row["source"] = table.path.substr(table.path.find_last_of('/') + 1) + ":" + std::to_string(source.line);
    rows.push_back(std::move(row));
  }
  if (lost > 0) {
    notes_.push_back(table.path + ": " + std::to_string(lost) +
                     " lost readings are left out (empty, NaN or -9999), the first in line " +
                     std::to_string(first_lost));
  }
  if (zeros > 0)
    notes_.push_back(table.path + ": " + std::to_string(zeros) + " readings of 0, 0, 0 are read as lost and left out");
  if (without_sigma > 0)
    notes_.push_back(table.path + ": " + std::to_string(without_sigma) + " rows have no standard deviation above 0");
  if (without_rotation > 0) {
    notes_.push_back(table.path + ": of " + std::to_string(without_rotation) +
                     " readings the rotation is lost; their points are used");
  }
  if (rows.empty()) throw InputError({table.path, 0, ""}, "no row holds a reading", "");
  int joints = 0;
  while (plan.Find("q" + std::to_string(joints + 1))) ++joints;
  NameConfigurations(&rows, plan.Find("config") != nullptr, joints);
  rows_.insert(rows_.end(), rows.begin(), rows.end());
}

// A load is named by its mass where that is what the cell says; no mass is no load.
std::string ImportedRows::LoadName(const TextTable& table, const PlannedColumn& column, const std::string& cell) {
  const std::string in_cell = UnitInHeader(cell);
  const std::string unit = in_cell.empty() ? column.text_unit : in_cell;
  const std::optional<double> number = table.Number(in_cell.empty() ? cell : StemOf(cell));
  if (!number) return cell;
  if (*number == 0.0) return Shot().load;
  if (unit.empty()) return cell;
  const std::string name = FormatNumber(*number) + unit;
  if (unit == "kg" && *number > 0.0) masses_[name] = *number;
  return name;
}

// A row states the torques of all joints or of none.
void ImportedRows::DropPartOfTorques(const ImportPlan& plan, Row* row) {
  std::vector<std::string> names;
  bool all = true;
  for (const PlannedColumn& column : plan.columns) {
    if (!IsTorque(column)) continue;
    names.push_back(column.stem + "_" + column.unit);
    all = all && row->count(names.back());
  }
  for (const std::string& name : names) {
    if (!all) row->erase(name);
  }
}

// The joint values of a row, as text: equal ones are one configuration.
void ImportedRows::NameConfigurations(std::vector<Row>* rows, bool has_column, int joints) {
  const auto joint_key = [joints](const Row& row) {
    std::string key;
    for (int j = 1; j <= joints; ++j) {
      const auto at = row.lower_bound("q" + std::to_string(j) + "_");
      key += at->first + "=" + at->second + ";";
    }
    return key;
  };
  std::map<std::string, std::string> config_of, joints_of;
  for (const Row& row : rows_) {
    CheckInterruption();
    config_of.emplace(joint_key(row), row.at("config"));
    joints_of.emplace(row.at("config"), joint_key(row));
  }
  // A stated id is kept where it means one set of joint values, here and in the files before.
  bool keep = has_column;
  if (has_column) {
    std::map<std::string, std::string> stated = joints_of;
    for (const Row& row : *rows) {
      CheckInterruption();
      const std::string& id = row.at("config");
      keep = keep && !id.empty() && stated.emplace(id, joint_key(row)).first->second == joint_key(row);
    }
    if (!keep) notes_.push_back("the ids of configurations are not used: one id stands for different joint values");
  }
  for (Row& row : *rows) {
    CheckInterruption();
    if (keep) continue;
    char name[32];
    std::snprintf(name, sizeof name, "c%05zu", config_of.size() + 1);
    row["config"] = config_of.emplace(joint_key(row), name).first->second;
  }
}

std::string ImportedRows::ToCsv(int joints) const {
  std::set<std::string> present;
  for (const Row& row : rows_) {
    CheckInterruption();
    for (const auto& [column, cell] : row) present.insert(column);
  }
  std::vector<std::string> order = {"config", "marker", "station", "visit", "repeat", "load", "set"};
  const auto add_all = [&](const std::string& stem) {
    for (const std::string& column : present) {
      if (column.rfind(stem + "_", 0) == 0) order.push_back(column);
    }
  };
  for (int j = 1; j <= joints; ++j) add_all("q" + std::to_string(j));
  for (const char* stem :
       {"x",        "y",        "z",  "sigma_x", "sigma_y", "sigma_z", "rx", "ry", "rz",   "sigma_rx",
        "sigma_ry", "sigma_rz", "fx", "fy",      "fz",      "mx",      "my", "mz", "time", "temperature"})
    add_all(stem);
  for (int j = 1; j <= joints; ++j) add_all("tau" + std::to_string(j));
  for (int j = 1; j <= joints; ++j) order.push_back("approach" + std::to_string(j));
  order.push_back("source");
  order.erase(std::remove_if(order.begin(), order.end(), [&](const std::string& c) { return !present.count(c); }),
              order.end());
  std::string text;
  for (const std::string& column : order) text += (text.empty() ? "" : ",") + column;
  text += "\n";
  for (const Row& row : rows_) {
    CheckInterruption();
    for (size_t c = 0; c < order.size(); ++c) {
      const auto cell = row.find(order[c]);
      const std::string value = cell == row.end() ? "" : cell->second;
      text += (c == 0 ? "" : ",") + CsvCell(value);
    }
    text += "\n";
  }
  return text;
}

}  // namespace sagitta
