#include "problems/io/import/table_rows.h"

#include <cmath>
#include <iterator>
#include <utility>

#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/marker_column.h"
#include "problems/io/pattern.h"
#include "problems/io/units.h"
#include "problems/limits.h"
#include "problems/measurements.h"
#include "problems/text.h"

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

std::string OriginInWords(TimeOrigin origin) {
  switch (origin) {
    case TimeOrigin::kSince1970:
      return "dates, or counted from 1970";
    case TimeOrigin::kSince1900:
      return "days counted from 1900";
    case TimeOrigin::kUnknown:
      break;
  }
  return "counted from a start of their own";
}

// What keeps a cell from being a number; "": something else.
std::string WhyNoNumber(const std::string& cell) {
  static const std::regex kGrouped =
      MakePattern("^[-+]?\\d{1,3}(?:(?: |'|\u2019|\u00a0|\u202f|\u2009)\\d{3})+(?:[.,]\\d*)?$");
  static const std::regex kFortran = MakePattern("^[-+]?\\d*[.,]?\\d*[dD][-+]?\\d+$");
  static const std::regex kDash = MakePattern("^(?:\u2013|\u2014)\\d");
  static const std::regex kUnit = MakePattern("^[-+]?\\d+(?:[.,]\\d+)?(?:[eE][-+]?\\d+)? ?[^\\d.,eE+ -]+$");
  constexpr size_t kLongest = 40;
  if (cell.size() > kLongest) return "";
  if (SearchPattern(cell, kGrouped)) return "thousands must not be grouped: 2813.6, not 2 813.6 or 2'813.6";
  if (SearchPattern(cell, kFortran)) return "an exponent is written with E: 2.0E+03, not 2.0D+03";
  if (SearchPattern(cell, kDash)) return "a dash is no minus: write -25.2";
  if (SearchPattern(cell, kUnit)) return "units stand in the header, as in 'X [mm]', not next to the numbers";
  return "";
}

InputError NoNumber(const TextTable& table, const TextTable::Row& row, const PlannedColumn& column) {
  const std::string why = WhyNoNumber(row.cells[column.source]);
  return InputError({table.path, row.line, column.header}, "'" + row.cells[column.source] + "' is no number",
                    why.empty() ? "a lost reading is an empty cell, NaN or -9999" : why);
}

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
ImportedRow RotationCells(const TextTable& table, const TextTable::Row& source, const ImportPlan& plan) {
  std::vector<double> numbers;
  Vector3<double> sigmas = Vector3<double>::Zero();
  int stated = 0;
  ImportedRow cells;
  for (const PlannedColumn& column : plan.columns) {
    if (!IsRotation(column) && !IsRotationSigma(column)) continue;
    const std::string& cell = source.cells[static_cast<size_t>(column.source)];
    const std::optional<double> number = IsLostCell(cell) ? std::nullopt : table.Number(cell);
    if (!number && !IsLostCell(cell)) throw NoNumber(table, source, column);
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

void DropPointSigmas(ImportedRow* row) {
  for (auto it = row->begin(); it != row->end();) {
    const bool is_of_point = it->first.rfind("sigma_", 0) == 0 && it->first.rfind("sigma_r", 0) != 0;
    it = is_of_point ? row->erase(it) : std::next(it);
  }
}

}  // namespace

TableRows::TableRows(const TextTable& table, const ImportPlan& plan, const RowDefaults& defaults, ImportedNames* names)
    : table_(table), plan_(plan), defaults_(defaults), names_(names) {
  const PlannedColumn* column = plan.Find("time");
  if (column == nullptr) return;
  time_ = LookAtTime(table, *column, FirstRowsOfShots(table, plan));
  if (time_.why_not.empty()) RefuseOtherClock(*column);
}

// Seconds from a start and dates in one column would be decades apart.
void TableRows::RefuseOtherClock(const PlannedColumn& column) {
  if (!names_->times_from) names_->times_of = table_.path;
  const TimeOrigin first = names_->times_from.value_or(time_.origin);
  names_->times_from = first;
  if (time_.origin == first) return;
  throw InputError({table_.path, table_.header_line, column.header},
                   "the times are " + OriginInWords(time_.origin) + ", and those of " + names_->times_of + " are " +
                       OriginInWords(first),
                   "times of one clock in all files, or in none of them");
}

std::vector<ImportedRow> TableRows::Read(size_t stride) {
  std::vector<ImportedRow> rows;
  std::map<std::string, size_t> shots;
  for (const TextTable::Row& source : table_.rows) {
    CheckInterruption();
    if (stride > 1 && shots.emplace(ShotOf(source), shots.size()).first->second % stride != 0) continue;
    ImportedRow row;
    const Found found = ReadRow(source, &row);
    if (found != Found::kReading) {
      if (lost_ + zeros_ == 0) first_lost_ = source.line;
      ++(found == Found::kLost ? lost_ : zeros_);
      continue;
    }
    if (plan_.rotation) AddRotation(source, &row);
    if (sigma_is_lost_) {
      ++without_sigma_;
      DropPointSigmas(&row);
    }
    DropPartOfTorques(&row);
    row.emplace("station", defaults_.station);
    row.emplace("marker", defaults_.marker);
    row["source"] = table_.path.substr(table_.path.find_last_of('/') + 1) + ":" + std::to_string(source.line);
    rows.push_back(std::move(row));
  }
  return rows;
}

// What the markers of one shot have in common: of a sample with some of them a reader would say that the others lack a
// load.
std::string TableRows::ShotOf(const TextTable::Row& source) const {
  std::string shot;
  for (const PlannedColumn& column : plan_.columns) {
    if (IsOfPose(column) || column.stem == "repeat") shot += source.cells[column.source] + ";";
  }
  return shot;
}

TableRows::Found TableRows::ReadRow(const TextTable::Row& source, ImportedRow* row) {
  bool is_lost = false, all_zero = true;
  sigma_is_lost_ = false;
  for (const PlannedColumn& column : plan_.columns) {
    if (IsRotation(column) || IsRotationSigma(column)) continue;
    const std::string& cell = source.cells[column.source];
    if (IsText(column)) {
      (*row)[column.stem] = TextCell(column, cell);
    } else if (column.stem == "time") {
      AddTime(source, column, row);
    } else if (const std::optional<double> number = NumberIn(source, column)) {
      sigma_is_lost_ |= IsSigma(column) && !(*number > 0.0);
      if (column.stem.size() == 1) all_zero &= *number == 0.0;
      CheckSize(table_, source, column, *number);
      AddNumber(column, *number, row);
    } else {
      is_lost |= IsRequired(column);
      sigma_is_lost_ |= IsSigma(column);
    }
  }
  return is_lost ? Found::kLost : all_zero ? Found::kZeros : Found::kReading;
}

std::string TableRows::TextCell(const PlannedColumn& column, const std::string& cell) {
  return column.stem == "load" ? LoadName(column, cell) : PartOfName(cell, column.part);
}

void TableRows::AddTime(const TextTable::Row& source, const PlannedColumn& column, ImportedRow* row) const {
  if (!time_.why_not.empty()) return;
  if (const std::optional<double> seconds = SecondsOfRow(table_, source, column, time_))
    (*row)["time_s"] = FormatNumber(*seconds);
}

std::optional<double> TableRows::NumberIn(const TextTable::Row& source, const PlannedColumn& column) const {
  const bool has_second = column.second >= 0;
  const std::string& cell = source.cells[column.source];
  if (IsLostCell(cell) || (has_second && IsLostCell(source.cells[column.second]))) return std::nullopt;
  const std::optional<double> number = table_.Number(cell);
  const std::optional<double> second = has_second ? table_.Number(source.cells[column.second]) : 0.0;
  if (!number || !second) throw NoNumber(table_, source, column);
  return has_second ? *number + column.sign * *second : *number;
}

// In the unit that the first table has, um, cm and in in mm: elsewhere the digits stay as they are printed.
void TableRows::AddNumber(const PlannedColumn& column, double number, ImportedRow* row) {
  if (IsTorque(column)) {
    (*row)[column.stem + "_" + column.unit] = FormatNumber(number);
    return;
  }
  const std::string own = IsOurs(column.unit) ? column.unit : "mm";
  const std::string unit = names_->unit_of.emplace(column.stem, own).first->second;
  const bool converts = unit != column.unit && !column.unit.empty();
  const double value = converts ? ToUnit(UnitNamed(column.unit).ToSi(number), UnitNamed(unit)) : number;
  (*row)[column.stem + (unit.empty() ? "" : "_" + unit)] = FormatNumber(value);
}

void TableRows::AddRotation(const TextTable::Row& source, ImportedRow* row) {
  const ImportedRow rotation = RotationCells(table_, source, plan_);
  without_rotation_ += rotation.empty();
  row->insert(rotation.begin(), rotation.end());
}

// A load is named by its mass where that is what the cell says; no mass is no load.
std::string TableRows::LoadName(const PlannedColumn& column, const std::string& cell) {
  const std::string in_cell = UnitInHeader(cell);
  const std::string unit = in_cell.empty() ? column.text_unit : in_cell;
  const std::optional<double> number = table_.Number(in_cell.empty() ? cell : StemOf(cell));
  if (!number) return cell;
  if (*number == 0.0) return Shot().load;
  if (unit.empty()) return cell;
  const std::string name = FormatNumber(*number) + unit;
  if (unit == "kg" && *number > 0.0) names_->masses[name] = *number;
  return name;
}

// A row states the torques of all joints or of none.
void TableRows::DropPartOfTorques(ImportedRow* row) const {
  std::vector<std::string> names;
  bool all = true;
  for (const PlannedColumn& column : plan_.columns) {
    if (!IsTorque(column)) continue;
    names.push_back(column.stem + "_" + column.unit);
    all = all && row->count(names.back());
  }
  for (const std::string& name : names) {
    if (!all) row->erase(name);
  }
}

std::vector<std::string> TableRows::Notes() const {
  std::vector<std::string> notes;
  const auto note = [&](const std::string& words) { notes.push_back(table_.path + ": " + words); };
  const auto count = [](size_t number) { return std::to_string(number); };
  if (!time_.why_not.empty()) note("'" + plan_.Find("time")->header + "' is not used: " + time_.why_not);
  if (lost_ > 0) {
    note(count(lost_) + " lost readings are left out (empty, NaN or -9999), the first in line " +
         std::to_string(first_lost_));
  }
  if (zeros_ > 0) note(count(zeros_) + " readings of 0, 0, 0 are read as lost and left out");
  if (without_sigma_ > 0) note(count(without_sigma_) + " rows have no standard deviation above 0");
  if (without_rotation_ > 0) {
    note("of " + count(without_rotation_) + " readings the rotation is lost; their points are used");
  }
  return notes;
}

}  // namespace sagitta
