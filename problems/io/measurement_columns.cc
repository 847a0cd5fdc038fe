#include "problems/io/measurement_columns.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <set>

#include "problems/input_error.h"
#include "problems/io/pattern.h"
#include "problems/text.h"
#include "problems/unit_words.h"

namespace sagitta {
namespace {

// 3 of "q3_deg", "tau3_Nm" or "approach3"; nothing where the name is no such.
std::optional<int> NumberAfter(const std::string& name, const std::string& prefix) {
  if (name.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
  int number = 0;
  const char* end_of_name = name.data() + name.size();
  const auto [end, error] = std::from_chars(name.data() + prefix.size(), end_of_name, number);
  if (error != std::errc() || (end != end_of_name && *end != '_')) return std::nullopt;
  return number;
}

// In any letters; a range in any unit.
bool IsReserved(const std::string& name) {
  static const std::vector<std::string> reserved = {"kind", "to", "range_mm", "sigma_range_mm", "session"};
  const std::string lower = LowerCaseOf(name);
  return std::find(reserved.begin(), reserved.end(), lower) != reserved.end() || ForeignUnitOf(lower, reserved);
}

// Too short for a slip of the pen to be distinguished from another name.
bool IsQuaternion(const std::string& name) {
  return name.size() == 2 && name[0] == 'o' && name.find_first_of("wxyz", 1) == 1;
}

// Columns that our own commands write: no slips, whatever they resemble.
bool IsOwnOutput(const std::string& name) {
  for (const char* prefix : {"pred_", "psig_", "res_", "whitened_"}) {
    if (name.compare(0, std::string(prefix).size(), prefix) == 0) return true;
  }
  return false;
}

// A target, commanded or nominal point is not a measured one, whatever its name resembles. Joint values are commanded.
bool IsOtherMeaning(const std::string& name) {
  static const std::regex other = MakePattern(
      "[xyz]_?(t|tgt|target|c|cmd|command|commanded|n|nom|nominal|ref|reference|set|setpoint|des|desired|goal|prog|"
      "programmed)(_(mm|m|um))?",
      true);
  return MatchPattern(name, other);
}

class ColumnFinder {
 public:
  ColumnFinder(const CsvTable& table, const std::vector<std::string>& joints, const std::vector<bool>& prismatic)
      : table_(table), joints_(joints), prismatic_(prismatic) {}

  MeasurementColumns Find(bool points_required);

 private:
  int Plain(const std::string& name);
  NumberColumn Number(const std::string& name);
  NumberColumn Quantity(const std::string& stem, Dimension dimension);
  void FindAll(MeasurementColumns* columns);

  void CheckJointUnits() const;
  void CheckTorques(const MeasurementColumns& columns) const;
  std::string TorqueColumn(size_t joint) const {
    return "tau" + std::to_string(joint + 1) + (prismatic_[joint] ? "_N" : "_Nm");
  }
  void CheckJointCount() const;
  void CheckUnlisted() const;
  void CheckComplete(const std::array<NumberColumn, 3>& columns, const std::string& stem, bool required,
                     Dimension dimension = Dimension::kLength) const;
  void CheckRotation(const MeasurementColumns& columns, bool points_required) const;
  void CheckRequired(const MeasurementColumns& columns, bool points_required) const;

  [[noreturn]] void Fail(const std::string& key, const std::string& what, const std::string& hint) const {
    throw InputError({table_.file.path, table_.header_line, key}, what, hint);
  }
  [[noreturn]] void FailMissing(const std::string& name, const std::string& allowed = "") const;
  Dimension JointDimension(int joint) const { return prismatic_[joint] ? Dimension::kLength : Dimension::kAngle; }

  const CsvTable& table_;
  const std::vector<std::string>& joints_;
  const std::vector<bool>& prismatic_;
  std::vector<std::string> listed_;  // every name that was asked for
};

int ColumnFinder::Plain(const std::string& name) {
  listed_.push_back(name);
  return table_.file.FindColumn(name);
}

NumberColumn ColumnFinder::Number(const std::string& name) {
  NumberColumn column;
  column.index = Plain(name);
  column.name = name;
  return column;
}

NumberColumn ColumnFinder::Quantity(const std::string& stem, Dimension dimension) {
  NumberColumn found;
  for (const Unit& unit : UnitsOf(dimension)) {
    NumberColumn column = Number(stem + "_" + unit.suffix);
    if (!column.present()) continue;
    if (found.present()) Fail(column.name, "'" + stem + "' is given in two units", "keep one of them");
    column.unit = unit;
    found = column;
  }
  return found;
}

void ColumnFinder::FindAll(MeasurementColumns* columns) {
  columns->config = Plain("config");
  columns->marker = Plain("marker");
  columns->station = Plain("station");
  columns->visit = Plain("visit");
  columns->repeat = Plain("repeat");
  columns->load = Plain("load");
  columns->set = Plain("set");
  for (size_t j = 0; j < joints_.size(); ++j) {
    columns->q.push_back(Quantity("q" + std::to_string(j + 1), JointDimension(static_cast<int>(j))));
    columns->approach.push_back(Number("approach" + std::to_string(j + 1)));
    columns->torque.push_back(Number(TorqueColumn(j)));
  }
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, kAxisLetters[i]);
    columns->point[i] = Quantity(axis, Dimension::kLength);
    columns->sigma[i] = Quantity("sigma_" + axis, Dimension::kLength);
    columns->sim[i] = Quantity("sim_" + axis, Dimension::kLength);
    columns->rotation[i] = Quantity("r" + axis, Dimension::kAngle);
    columns->rotation_sigma[i] = Quantity("sigma_r" + axis, Dimension::kAngle);
    columns->wrench[i] = Number("f" + axis + "_N");
    columns->wrench[i + 3] = Number("m" + axis + "_Nm");
  }
  for (int i = 0; i < 4; ++i) {
    const std::string name = std::string("o") + "wxyz"[i];
    columns->quaternion[i].index = table_.file.FindColumn(name);
    columns->quaternion[i].name = name;
  }
  columns->common_rotation_sigma = Quantity("sigma_rot", Dimension::kAngle);
  columns->time = Number("time_s");
  columns->temperature = Number("temperature_degC");
}

void ColumnFinder::CheckJointUnits() const {
  for (size_t j = 0; j < joints_.size(); ++j) {
    const std::string stem = "q" + std::to_string(j + 1);
    const Dimension right = JointDimension(static_cast<int>(j));
    const Dimension wrong = right == Dimension::kAngle ? Dimension::kLength : Dimension::kAngle;
    for (const Unit& unit : UnitsOf(wrong)) {
      const std::string name = stem + "_" + unit.suffix;
      if (table_.file.FindColumn(name) < 0) continue;
      Fail(name, "joint '" + joints_[j] + "' is " + (prismatic_[j] ? "prismatic" : "revolute"),
           "allowed: " + NamesWithUnits(stem, right));
    }
  }
}

void ColumnFinder::CheckJointCount() const {
  std::set<int> numbers;
  for (const std::string& name : table_.file.header) {
    if (const auto number = NumberAfter(name, "q")) numbers.insert(*number);
  }
  if (numbers.empty()) return;  // CheckRequired names what is missing, as where there is a gap
  const int count = static_cast<int>(numbers.size());
  const bool without_gap = *numbers.begin() == 1 && *numbers.rbegin() == count;
  if (count == static_cast<int>(joints_.size()) || (!without_gap && *numbers.rbegin() <= joints_.size())) return;
  Fail("q" + std::to_string(*numbers.rbegin()),
       "the robot has " + std::to_string(joints_.size()) + " joints (" + joints_.front() + " .. " + joints_.back() +
           "), the file has joint values q1 .. q" + std::to_string(*numbers.rbegin()),
       "columns q1 .. q" + std::to_string(joints_.size()) + " are expected");
}

// All joints or none: a torque that is left out would be read as zero, or as the model's.
void ColumnFinder::CheckTorques(const MeasurementColumns& columns) const {
  for (const std::string& name : table_.file.header) {
    const auto number = NumberAfter(name, "tau");
    if (!number || name.rfind("_N") == std::string::npos) continue;
    if (*number < 1 || *number > static_cast<int>(joints_.size())) {
      Fail(name, "the robot has " + std::to_string(joints_.size()) + " joints", "remove the column");
    }
    const std::string right = TorqueColumn(static_cast<size_t>(*number - 1));
    if (name == right) continue;
    const bool slides = prismatic_[static_cast<size_t>(*number - 1)];
    Fail(name, "joint '" + joints_[static_cast<size_t>(*number - 1)] + "' is " + (slides ? "prismatic" : "revolute"),
         "its measured " + std::string(slides ? "force" : "torque") + " is the column " + right);
  }
  const auto present = [](const NumberColumn& column) { return column.present(); };
  if (std::none_of(columns.torque.begin(), columns.torque.end(), present)) return;
  for (const NumberColumn& column : columns.torque) {
    if (column.present()) continue;
    Fail(column.name, "column '" + column.name + "' is missing: measured joint torques are given for other joints",
         "give those of all joints, or of none");
  }
}

void ColumnFinder::CheckUnlisted() const {
  for (const std::string& name : table_.file.header) {
    if (std::find(listed_.begin(), listed_.end(), name) != listed_.end() || IsOwnOutput(name)) continue;
    if (IsOtherMeaning(name)) continue;
    if (IsQuaternion(name)) continue;
    if (IsQuaternion(LowerCaseOf(name)))
      Fail(name, "unknown column '" + name + "'", "did you mean '" + LowerCaseOf(name) + "'?");
    if (IsReserved(name)) {
      Fail(name, "this column name is reserved for measurements that are not read by this version",
           "rename or remove the column");
    }
    if (const auto number = NumberAfter(name, "approach")) {
      Fail(name, "the robot has " + std::to_string(joints_.size()) + " joints", "remove the column");
    }
    if (LowerCaseOf(name) == "approach") {
      Fail(name, "of which joint?", "the direction of the last motion has a column per joint: approach1, approach2 …");
    }
    if (const auto foreign = ForeignUnitOf(name, listed_)) Fail(name, foreign->Words(), foreign->Hint());
    std::vector<std::string> meant;
    for (const std::string& listed : listed_) {
      if (IsSlipOfColumn(name, listed)) meant.push_back(listed);
    }
    if (!meant.empty()) Fail(name, "unknown column '" + name + "'", SpellingHint(name, meant));
  }
}

void ColumnFinder::FailMissing(const std::string& name, const std::string& allowed) const {
  std::string hint = allowed.empty() ? "" : "allowed: " + allowed;
  const auto other = std::find_if(table_.file.header.begin(), table_.file.header.end(), IsOtherMeaning);
  if (other != table_.file.header.end() && name.size() > 1 && name[1] == '_')
    hint += (hint.empty() ? "" : "; ") + ("'" + *other + "' reads like a target, not like a measured point");
  Fail(name, "column '" + name + "' is missing", hint);
}

void ColumnFinder::CheckComplete(const std::array<NumberColumn, 3>& columns, const std::string& stem, bool required,
                                 Dimension dimension) const {
  const bool any = columns[0].present() || columns[1].present() || columns[2].present();
  if (!any && !required) return;
  for (int i = 0; i < 3; ++i) {
    const std::string name = stem + kAxisLetters[i];
    if (columns[i].present()) continue;
    FailMissing(name + (dimension == Dimension::kLength ? "_mm" : "_mrad"), NamesWithUnits(name, dimension));
  }
}

void ColumnFinder::CheckRotation(const MeasurementColumns& columns, bool points_required) const {
  CheckComplete(columns.rotation, "r", false, Dimension::kAngle);
  CheckComplete(columns.rotation_sigma, "sigma_r", false, Dimension::kAngle);
  const auto present = [](const NumberColumn& column) { return column.present(); };
  const auto& q = columns.quaternion;
  const bool any = std::any_of(q.begin(), q.end(), present);
  for (const NumberColumn& part : q) {
    if (any && !part.present()) FailMissing(part.name, "ow, ox, oy, oz: a unit quaternion, scalar first");
  }
  if (any && columns.rotation[0].present()) {
    Fail("ow", "the rotation is given twice: as rotation vector and as quaternion", "keep one of them");
  }
  const NumberColumn& common = columns.common_rotation_sigma;
  if (common.present() && columns.rotation_sigma[0].present()) {
    Fail(common.name, "the rotation's standard deviation is given twice: for all axes and per axis",
         "keep one of them");
  }
  if (any || columns.rotation[0].present() || !points_required) return;  // to be simulated: nothing is read yet
  const NumberColumn& sigma = common.present() ? common : columns.rotation_sigma[0];
  if (sigma.present()) {
    Fail(sigma.name, "standard deviations of rotations are given, but no rotations",
         "add rx_mrad, ry_mrad, rz_mrad or ow, ox, oy, oz");
  }
}

void ColumnFinder::CheckRequired(const MeasurementColumns& columns, bool points_required) const {
  if (columns.config < 0) {
    Fail("config", "column 'config' is missing: it names the joint configuration of each row",
         "'sagitta import ROBOT FILE --out=DIR' brings over tables that other programs wrote");
  }
  if (columns.marker < 0) FailMissing("marker");
  for (size_t j = 0; j < joints_.size(); ++j) {
    const std::string stem = "q" + std::to_string(j + 1);
    const Dimension dimension = JointDimension(static_cast<int>(j));
    if (!columns.q[j].present()) {
      FailMissing(stem + "_" + UnitsOf(dimension).front().suffix, NamesWithUnits(stem, dimension));
    }
  }
  CheckComplete(columns.point, "", points_required);
  CheckComplete(columns.sigma, "sigma_", false);
  CheckComplete(columns.sim, "sim_", false);
  CheckRotation(columns, points_required);
}

MeasurementColumns ColumnFinder::Find(bool points_required) {
  MeasurementColumns columns;
  FindAll(&columns);
  CheckJointUnits();
  CheckTorques(columns);
  CheckUnlisted();
  CheckJointCount();
  CheckRequired(columns, points_required);
  for (const std::string& name : table_.file.header) {
    if (!IsQuaternion(name) && std::find(listed_.begin(), listed_.end(), name) == listed_.end())
      columns.unread.push_back(name);
  }
  return columns;
}

}  // namespace

MeasurementColumns FindMeasurementColumns(const CsvTable& table, const std::vector<std::string>& joints,
                                          const std::vector<bool>& prismatic, bool points_required) {
  return ColumnFinder(table, joints, prismatic).Find(points_required);
}

}  // namespace sagitta
