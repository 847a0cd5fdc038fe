#include "problems/io/import/dh_units.h"

#include <algorithm>
#include <cmath>

#include "problems/input_error.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/mapped_columns.h"
#include "problems/io/pattern.h"
#include "problems/io/robot_units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

const char* KindOf(DhColumn column) { return IsLength(column) ? "a length" : IsAngle(column) ? "an angle" : "a limit"; }

bool IsNamed(const Unit* unit, const char* suffix) { return unit && std::string(unit->suffix) == suffix; }

}  // namespace

DhUnits::DhUnits(const TextTable& table, const std::vector<DhColumn>& columns, RobotReading* reading)
    : table_(table), columns_(columns), units_(columns.size(), nullptr) {
  for (size_t c = 0; c < columns_.size(); ++c) ReadHeader(c);
  const Unit* stated = nullptr;
  for (size_t c = 0; c < columns_.size(); ++c) {
    if (IsLength(columns_[c]) && units_[c]) stated = units_[c];
  }
  GuessLengths(reading);
  if (!length_) length_ = stated;
  GuessAngles(reading);
  CheckThousands();
}

void DhUnits::Fail(const TextTable::Row& row, size_t c, const std::string& what, const std::string& hint) const {
  throw InputError({table_.path, row.line, table_.header[c]}, what, hint);
}

void DhUnits::ReadHeader(size_t c) {
  const DhColumn column = columns_[c];
  if (!IsLength(column) && !IsAngle(column) && !IsLimit(c)) return;
  const std::string unit = UnitInHeader(table_.header[c]);
  if (unit.empty()) return;
  const bool fits = IsLengthUnit(unit) ? !IsAngle(column) : IsAngleUnit(unit) && !IsLength(column);
  if (!fits) {
    throw InputError({table_.path, table_.header_line, table_.header[c]}, std::string(KindOf(column)) + " in " + unit,
                     "lengths in mm, cm, m, um or in, angles in deg, rad, mrad or urad");
  }
  units_[c] = &UnitNamed(unit);
  if (column == DhColumn::kD) length_ = units_[c];
  angles_are_in_rad_ |= column == DhColumn::kAlpha && IsNamed(units_[c], "rad");
}

// A number, or the constant of an expression with a joint variable.
std::optional<TypedNumber> DhUnits::ConstantOf(const std::string& cell) const {
  if (const auto number = ParseTypedNumber(cell, table_.decimal_comma)) return number;
  const auto joint = ParseJointExpression(cell, table_.decimal_comma);
  return joint ? std::optional<TypedNumber>(joint->offset) : std::nullopt;
}

void DhUnits::GuessLengths(RobotReading* reading) {
  double largest = 0.0;
  bool any = false;
  const auto is_open = [this](size_t c) { return !units_[c] && IsLength(columns_[c]); };
  for (size_t c = 0; c < columns_.size(); ++c) {
    if (!is_open(c)) continue;
    any = true;
    for (const TextTable::Row& row : table_.rows) {
      const std::optional<TypedNumber> number = ConstantOf(row.cells[c]);
      if (number) largest = std::max(largest, std::abs(number->value));
    }
  }
  if (!any) return;
  const std::string unit = largest < kLongestLink ? "m" : "mm";  // and no arm is made of links below 10 mm
  for (size_t c = 0; c < columns_.size(); ++c) {
    if (is_open(c)) units_[c] = &UnitNamed(unit);
  }
  if (largest == 0.0) return;
  if (!length_) length_ = &UnitNamed(unit);
  reading->guesses.push_back("lengths are in " + unit + ": the header does not say, the largest is " +
                             FormatNumber(largest));
}

void DhUnits::GuessAngles(RobotReading* reading) {
  using Angles = AnglesWithoutUnit::Unit;
  bool of_alpha = false;
  for (size_t c = 0; c < columns_.size(); ++c) {
    if (units_[c] || !IsAngle(columns_[c])) continue;
    of_alpha |= columns_[c] == DhColumn::kAlpha;
    for (const TextTable::Row& row : table_.rows) {
      if (const auto number = ConstantOf(row.cells[c])) angles_.Add(*number);
    }
  }
  angles_are_in_rad_ |= of_alpha && angles_.unit() == Angles::kRad;
  if (angles_.unit() == Angles::kEach) reading->notes.push_back("angles with pi are in rad, the others in deg");
  if (!angles_.is_guess()) return;
  reading->guesses.push_back(std::string("angles are in ") + (angles_.unit() == Angles::kDeg ? "deg" : "rad") +
                             ": the header does not say, the largest is " + FormatNumber(angles_.largest()));
}

// 1.250 of a table without commas: 1250, where a point groups digits. m; nothing where it cannot.
std::optional<double> DhUnits::Thousands(const std::string& cell) const {
  static const std::regex kGrouped[] = {MakePattern(R"([-+]?[1-9][0-9]{0,2}\.[0-9]{3})"),
                                        MakePattern(R"([-+]?[1-9][0-9]{0,2},[0-9]{3})")};
  if (!MatchPattern(cell, kGrouped[table_.decimal_comma ? 1 : 0])) return std::nullopt;
  const std::optional<double> number = ParseLocalNumber(cell, table_.decimal_comma);
  return number ? std::optional<double>(1e3 * *number) : std::nullopt;
}

// A sign before three digits is the decimal one where another number says so, or where as thousands it would be no
// link.
void DhUnits::CheckThousands() const {
  const char sign = table_.decimal_comma ? ',' : '.';
  const TextTable::Row* in_doubt = nullptr;
  size_t column = 0;
  for (const TextTable::Row& row : table_.rows) {
    for (size_t c = 0; c < columns_.size(); ++c) {
      const std::string& cell = row.cells[c];
      if (cell.find(sign) == std::string::npos || !ParseLocalNumber(cell, table_.decimal_comma)) continue;
      const std::optional<double> thousands = IsLength(columns_[c]) ? Thousands(cell) : std::nullopt;
      if (!thousands || std::abs(units_[c]->ToSi(*thousands)) > kLongestLink) return;
      in_doubt = &row;
      column = c;
    }
  }
  if (!in_doubt) return;
  const std::string cell = in_doubt->cells[column];
  Fail(*in_doubt, column,
       "'" + cell + "' may be " + FormatNumber(*ParseLocalNumber(cell, table_.decimal_comma)) + " or " +
           FormatNumber(*Thousands(cell)) + ": which sign is the decimal one cannot be seen in this table",
       "write numbers without signs between thousands, and at least one with other than three decimals");
}

double DhUnits::ToSi(const TextTable::Row& row, size_t c, const TypedNumber& number) const {
  const std::string& cell = row.cells[c];
  if (IsLength(columns_[c])) {
    if (number.is_degrees || number.uses_pi) Fail(row, c, "'" + cell + "' is no length", "a number is expected");
    const double length = units_[c]->ToSi(number.value);
    if (IsNamed(units_[c], "m")) CheckMetres(length, "'" + cell + "'", {table_.path, row.line, table_.header[c]});
    return length;
  }
  if (number.uses_pi) return number.value;
  if (number.is_degrees) return UnitNamed("deg").ToSi(number.value);
  if (units_[c]) {
    const double angle = units_[c]->ToSi(number.value);
    if (IsNamed(units_[c], "rad")) CheckRadians(angle, "'" + cell + "'", {table_.path, row.line, table_.header[c]});
    return angle;
  }
  if (angles_.IsUndecided(number))
    Fail(row, c, "'" + cell + "' may be in deg or in rad, and other angles are in either",
         "state the unit in the header: alpha [rad], theta [deg]");
  return angles_.ToRad(number);
}

// Of a cell that states a limit; "-", "inf" and the like state none.
std::optional<TypedNumber> DhUnits::LimitOf(const TextTable::Row& row, size_t c) const {
  const std::string& cell = row.cells[c];
  if (IsLostCell(cell) || cell == "∞" || cell == "-∞" || cell == "+∞") return std::nullopt;
  const std::optional<TypedNumber> number = ParseTypedNumber(cell, table_.decimal_comma);
  if (!number) Fail(row, c, "'" + cell + "' is no limit", "a number is expected, or nothing where there is no limit");
  return number;
}

// Of limits whose header does not say, of joints that turn or of those that slide.
const Unit& DhUnits::UnitOfLimits(const std::vector<Joint>& joints, JointType type, RobotReading* reading) const {
  const TextTable::Row* largest_row = nullptr;
  size_t column = 0;
  double largest = 0.0;
  for (size_t r = 0; r < joints.size(); ++r) {
    for (size_t c = 0; c < columns_.size(); ++c) {
      if (!IsLimit(c) || units_[c] || joints[r].type != type) continue;
      const std::optional<TypedNumber> number = LimitOf(table_.rows[r], c);
      if (!number || number->uses_pi || number->is_degrees || std::abs(number->value) <= largest) continue;
      largest = std::abs(number->value);
      largest_row = &table_.rows[r];
      column = c;
    }
  }
  const bool slides = type == JointType::kPrismatic;
  if (!largest_row) return UnitNamed(slides ? "m" : "deg");  // of nothing
  if (slides && !length_) {
    Fail(*largest_row, column, "whether limits of up to " + FormatNumber(largest) + " are in m or mm cannot be seen",
         "state the unit in the header: min [mm], max [mm]");
  }
  if (!slides && largest <= kFullTurn && !angles_are_in_rad_) {
    Fail(*largest_row, column, "whether limits of up to " + FormatNumber(largest) + " are in deg or rad cannot be seen",
         "state the unit in the header: min [deg], max [deg]");
  }
  const Unit& unit = slides ? *length_ : UnitNamed(largest > kFullTurn ? "deg" : "rad");
  reading->guesses.push_back(std::string("limits of joints that ") + (slides ? "slide" : "turn") + " are in " +
                             unit.suffix + ": the header does not say, the largest is " + FormatNumber(largest));
  return unit;
}

// Zeros without a unit, for limits that nobody knows.
bool DhUnits::StatesNone(const TextTable::Row& row) const {
  for (size_t c = 0; c < columns_.size(); ++c) {
    const std::optional<TypedNumber> number = IsLimit(c) ? LimitOf(row, c) : std::nullopt;
    if (number && number->value != 0.0) return false;
  }
  return true;
}

// Limits in the unit of the other kind of joint are none of this one.
void DhUnits::ReadLimits(std::vector<Joint>* joints, RobotReading* reading) const {
  const Unit* without_unit[] = {&UnitOfLimits(*joints, JointType::kRevolute, reading),
                                &UnitOfLimits(*joints, JointType::kPrismatic, reading)};
  for (size_t r = 0; r < joints->size(); ++r) {
    Joint& joint = (*joints)[r];
    const bool slides = joint.type == JointType::kPrismatic;
    for (size_t c = 0; c < columns_.size(); ++c) {
      if (!IsLimit(c)) continue;
      const std::optional<TypedNumber> number = LimitOf(table_.rows[r], c);
      const Unit& unit = units_[c] ? *units_[c] : *without_unit[slides ? 1 : 0];
      if (!number || IsLengthUnit(unit.suffix) != slides || (!units_[c] && StatesNone(table_.rows[r]))) continue;
      if (slides && (number->uses_pi || number->is_degrees))
        Fail(table_.rows[r], c, "the joint slides, and its limit is an angle", "a length is expected");
      if (slides) CheckTrack(unit.ToSi(number->value), {table_.path, table_.rows[r].line, table_.header[c]});
      const double in_deg = UnitNamed("deg").ToSi(number->value);
      (columns_[c] == DhColumn::kMin ? joint.min : joint.max) = number->uses_pi      ? number->value
                                                                : number->is_degrees ? in_deg
                                                                                     : unit.ToSi(number->value);
    }
    if (joint.min && joint.max && *joint.min > *joint.max)
      throw InputError({table_.path, table_.rows[r].line, ""}, "the limits of the joint are swapped");
  }
}

}  // namespace sagitta
