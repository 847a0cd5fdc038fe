#include "problems/io/target_file.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "models/constants.h"
#include "models/effects/effect.h"
#include "models/geometry.h"
#include "problems/input_error.h"
#include "problems/io/csv_table.h"
#include "problems/io/import/target_table.h"
#include "problems/io/load_names.h"
#include "problems/io/measurement_row.h"
#include "problems/io/units.h"
#include "problems/limits.h"
#include "problems/text.h"
#include "problems/unit_words.h"

namespace sagitta {
namespace {

struct TargetColumn {
  int index = -1;
  Unit unit{"", 1.0, 1.0};
};

constexpr const char* kRotations =
    "rx_mrad, ry_mrad, rz_mrad (rotation vector), ow, ox, oy, oz (unit quaternion, scalar first), a_deg, b_deg, c_deg "
    "(KUKA: Rz(a) Ry(b) Rx(c)) or roll_deg, pitch_deg, yaw_deg (Rz(yaw) Ry(pitch) Rx(roll))";

// The columns of a rotation; those of a quaternion have no unit.
struct RotationNames {
  RotationForm form;
  std::vector<std::string> stems;
};

const std::vector<RotationNames>& AllRotationNames() {
  static const std::vector<RotationNames> names = {{RotationForm::kVector, {"rx", "ry", "rz"}},
                                                   {RotationForm::kQuaternion, {"ow", "ox", "oy", "oz"}},
                                                   {RotationForm::kQuaternion, {"qw", "qx", "qy", "qz"}},
                                                   {RotationForm::kAbc, {"a", "b", "c"}},
                                                   {RotationForm::kRollPitchYaw, {"roll", "pitch", "yaw"}}};
  return names;
}

class TargetReader {
 public:
  TargetReader(TargetTable table, const Robot& robot, const std::string& station, std::vector<std::string> notes)
      : table_(std::move(table.table)),
        decimal_comma_(table.decimal_comma),
        robot_(robot),
        station_(station),
        notes_(std::move(notes)) {}

  Targets Read();

 private:
  [[noreturn]] void Fail(const std::string& key, const std::string& what, const std::string& hint = "") const {
    throw InputError({table_.file.path, row_ == nullptr ? table_.header_line : row_->line, key}, what, hint);
  }
  TargetColumn Plain(const std::string& name);
  TargetColumn Quantity(const std::string& stem, Dimension dimension);
  // One per joint, or per axis; `any`: whether the file has one of them.
  std::vector<TargetColumn> Group(const std::vector<std::string>& stems, const std::vector<Dimension>& dimensions,
                                  bool* any);
  std::vector<TargetColumn> Quaternion(const std::vector<std::string>& names, bool* any);
  void FindColumns();
  void FindPose();
  void CheckUnlisted();
  void CheckOtherLetters(const std::string& name) const;
  // What is read and is no text.
  std::vector<size_t> ColumnsOfNumbers() const;

  std::string Cell(const TargetColumn& column) const;
  std::optional<double> Number(const TargetColumn& column) const;
  // All of a group or none.
  std::optional<Eigen::VectorXd> Numbers(const std::vector<TargetColumn>& columns) const;
  std::optional<Matrix3<double>> Rotation() const;
  std::optional<Pose<double>> PoseOfRow() const;
  Target ReadTarget();
  bool MayBeNoVector() const;
  Eigen::VectorXd ValuesOfNone() const;
  void AddShot(const Target& target, Measurements* data);

  CsvTable table_;
  const bool decimal_comma_;
  const Robot& robot_;
  const std::string station_;
  std::vector<std::string> notes_;
  const MeasurementFile::Row* row_ = nullptr;
  std::vector<std::string> listed_;
  std::vector<std::string> short_;  // too short for a slip of the pen to be distinguished from another name
  std::vector<std::string> unread_;
  TargetColumn name_, load_, stations_, time_, temperature_;
  std::vector<TargetColumn> q_, position_, rotation_, approach_;
  RotationForm form_ = RotationForm::kVector;
  std::array<TargetColumn, 6> wrench_;
};

TargetColumn TargetReader::Plain(const std::string& name) {
  listed_.push_back(name);
  return {table_.file.FindColumn(name), {"", 1.0, 1.0}};
}

TargetColumn TargetReader::Quantity(const std::string& stem, Dimension dimension) {
  TargetColumn found;
  for (const Unit& unit : UnitsOf(dimension)) {
    const TargetColumn column = Plain(stem + "_" + unit.suffix);
    if (column.index < 0) continue;
    if (found.index >= 0) Fail(listed_.back(), "'" + stem + "' is given in two units", "keep one of them");
    found = {column.index, unit};
  }
  return found;
}

std::vector<TargetColumn> TargetReader::Group(const std::vector<std::string>& stems,
                                              const std::vector<Dimension>& dimensions, bool* any) {
  std::vector<TargetColumn> columns;
  *any = false;
  for (size_t i = 0; i < stems.size(); ++i) {
    columns.push_back(Quantity(stems[i], dimensions[i]));
    *any |= columns.back().index >= 0;
  }
  for (size_t i = 0; *any && i < stems.size(); ++i) {
    if (columns[i].index < 0)
      Fail(stems[i], "column '" + stems[i] + "' is missing", "allowed: " + NamesWithUnits(stems[i], dimensions[i]));
  }
  return columns;
}

// x, y, z and one rotation, or nothing of both.
void TargetReader::FindPose() {
  bool has_position = false;
  position_ = Group({"x", "y", "z"}, std::vector<Dimension>(3, Dimension::kLength), &has_position);
  for (const RotationNames& names : AllRotationNames()) {
    const size_t listed = listed_.size();
    bool any = false;
    std::vector<TargetColumn> columns;
    if (names.form == RotationForm::kQuaternion) {
      columns = Quaternion(names.stems, &any);
    } else {
      columns = Group(names.stems, std::vector<Dimension>(3, Dimension::kAngle), &any);
    }
    if (names.stems.front().size() == 1 || names.form == RotationForm::kQuaternion) {
      short_.insert(short_.end(), listed_.begin() + static_cast<long>(listed), listed_.end());
      listed_.resize(listed);
    }
    if (!any) continue;
    const std::string first = table_.file.header[columns.front().index];
    if (!rotation_.empty()) {
      Fail(first,
           "the rotation is given twice: '" + table_.file.header[rotation_.front().index] + "' and '" + first + "'",
           "keep one of them");
    }
    rotation_ = columns;
    form_ = names.form;
  }
  if (has_position && rotation_.empty()) Fail("rx", "the poses have no rotation", std::string("add ") + kRotations);
  if (!has_position && !rotation_.empty()) {
    Fail("x", "column 'x' is missing: rotations are given", "allowed: " + NamesWithUnits("x", Dimension::kLength));
  }
}

std::vector<TargetColumn> TargetReader::Quaternion(const std::vector<std::string>& names, bool* any) {
  std::vector<TargetColumn> columns;
  for (const std::string& name : names) columns.push_back(Plain(name));
  const auto is_there = [](const TargetColumn& column) { return column.index >= 0; };
  *any = std::any_of(columns.begin(), columns.end(), is_there);
  for (size_t i = 0; *any && i < names.size(); ++i) {
    if (!is_there(columns[i])) {
      Fail(names[i], "column '" + names[i] + "' is missing", Joined(names) + ": a unit quaternion, scalar first");
    }
  }
  return columns;
}

void TargetReader::FindColumns() {
  name_ = Plain("target");
  if (name_.index < 0) {
    const std::string meant = NearestName("target", table_.file.header);
    Fail("target", "column 'target' is missing",
         meant.empty() ? "it names each row" : "it names each row; did you mean '" + meant + "'?");
  }
  std::vector<std::string> joints;
  std::vector<Dimension> units;
  for (int j = 0; j < robot_.num_joints(); ++j) {
    joints.push_back("q" + std::to_string(j + 1));
    const bool turns = robot_.chain.joints[j].type == JointType::kRevolute;
    units.push_back(turns ? Dimension::kAngle : Dimension::kLength);
    approach_.push_back(Plain("approach" + std::to_string(j + 1)));
  }
  bool has_joints = false;
  q_ = Group(joints, units, &has_joints);
  FindPose();
  for (int i = 0; i < 3; ++i) {
    wrench_[i] = Plain(std::string("f") + "xyz"[i] + "_N");
    wrench_[i + 3] = Plain(std::string("m") + "xyz"[i] + "_Nm");
  }
  load_ = Plain("load");
  stations_ = Plain("station");
  time_ = Plain("time_s");
  temperature_ = Plain("temperature_degC");
  CheckUnlisted();
  if (!has_joints && rotation_.empty()) {
    const std::string last = "q" + std::to_string(robot_.num_joints());
    Fail("", "the targets have neither joint values nor poses",
         "columns q1_deg (" + robot_.chain.joints.front().name + ") … " + last + "_deg (" +
             robot_.chain.joints.back().name +
             "), of joints that slide q1_mm …, or x_mm, y_mm, z_mm in the base frame with " + kRotations);
  }
}

// "A_deg" is a_deg or a column of its own: it is asked.
void TargetReader::CheckOtherLetters(const std::string& name) const {
  for (const std::string& listed : short_) {
    if (LowerCaseOf(name) == listed) Fail(name, "unknown column '" + name + "'", SpellingHint(name, {listed}));
  }
}

// Other columns are carried along, slips of ours and joints that the robot does not have are not.
void TargetReader::CheckUnlisted() {
  for (const std::string& name : table_.file.header) {
    if (std::find(listed_.begin(), listed_.end(), name) != listed_.end()) continue;
    if (std::find(short_.begin(), short_.end(), name) != short_.end()) continue;
    CheckOtherLetters(name);
    if (name.size() > 1 && name[0] == 'q' && std::isdigit(static_cast<unsigned char>(name[1])) &&
        name.find("_cmd") == std::string::npos) {
      Fail(name, "the robot has no such joint value: it has " + std::to_string(robot_.num_joints()) + " joints",
           "q1_deg …; prismatic joints q1_mm …");
    }
    if (const auto foreign = ForeignUnitOf(name, listed_)) Fail(name, foreign->Words(), foreign->Hint());
    for (const std::string& listed : listed_) {
      if (IsSlipOfColumn(name, listed)) Fail(name, "unknown column '" + name + "'", SpellingHint(name, {listed}));
    }
    if (LowerCaseOf(name).rfind("approach", 0) == 0) {
      Fail(name, "the robot has " + std::to_string(robot_.num_joints()) + " joints",
           "the direction of the last motion has a column per joint: approach1, approach2 …");
    }
    unread_.push_back(name);
  }
}

std::vector<size_t> TargetReader::ColumnsOfNumbers() const {
  std::vector<size_t> columns;
  for (size_t c = 0; c < table_.file.header.size(); ++c) {
    const auto is_here = [c](const TargetColumn& column) { return column.index == static_cast<int>(c); };
    const bool is_text = is_here(name_) || is_here(load_) || is_here(stations_);
    const bool is_read = std::find(unread_.begin(), unread_.end(), table_.file.header[c]) == unread_.end();
    if (is_read && !is_text) columns.push_back(c);
  }
  return columns;
}

std::string TargetReader::Cell(const TargetColumn& column) const {
  return column.index < 0 ? "" : std::string(row_->cells[column.index]);
}

std::optional<double> TargetReader::Number(const TargetColumn& column) const {
  const std::string& cell = Cell(column);
  if (cell.empty()) return std::nullopt;
  const std::optional<double> number = ParseNumber(cell);
  if (!number) Fail(table_.file.header[column.index], "'" + cell + "' is not a finite number");
  const double si = column.unit.ToSi(*number);
  if (std::abs(si) > (column.index == time_.index ? limits::kTime : limits::kForce)) {
    Fail(table_.file.header[column.index], "'" + cell + "' is beyond anything that a robot can do");
  }
  return si;
}

std::optional<Eigen::VectorXd> TargetReader::Numbers(const std::vector<TargetColumn>& columns) const {
  Eigen::VectorXd values(columns.size());
  size_t stated = 0;
  std::string missing;
  for (size_t i = 0; i < columns.size(); ++i) {
    const std::optional<double> number = Number(columns[i]);
    if (number) ++stated, values[i] = *number;
    if (!number && columns[i].index >= 0) missing = table_.file.header[columns[i].index];
  }
  if (stated == 0) return std::nullopt;
  if (stated < columns.size()) Fail(missing, "the cell is empty, a number is expected");
  return values;
}

std::optional<Matrix3<double>> TargetReader::Rotation() const {
  const std::optional<Eigen::VectorXd> n = Numbers(rotation_);
  if (!n) return std::nullopt;
  switch (form_) {
    case RotationForm::kVector:
      return RotationFromVector(Vector3<double>(*n));
    case RotationForm::kAbc:
      return RotationFromRpy(n->reverse());
    case RotationForm::kRollPitchYaw:
      return RotationFromRpy(*n);
    case RotationForm::kQuaternion:
      break;
  }
  if (std::abs(n->norm() - 1.0) > kUnitQuaternion) {
    Fail(table_.file.header[rotation_.front().index], "the quaternion has the length " + FormatNumber(n->norm()),
         "a unit quaternion is expected, scalar first");
  }
  return Eigen::Quaterniond((*n)[0], (*n)[1], (*n)[2], (*n)[3]).normalized().toRotationMatrix();
}

// Position and rotation, or neither.
std::optional<Pose<double>> TargetReader::PoseOfRow() const {
  const std::optional<Eigen::VectorXd> position = Numbers(position_);
  const std::optional<Matrix3<double>> rotation = Rotation();
  if (position.has_value() != rotation.has_value()) {
    const TargetColumn& empty = (position ? rotation_ : position_).front();
    Fail(table_.file.header[empty.index], "the cell is empty, a number is expected");
  }
  if (!position) return std::nullopt;
  return Pose<double>{*rotation, *position};
}

Target TargetReader::ReadTarget() {
  Target target;
  target.name = Cell(name_);
  if (target.name.empty()) Fail("target", "the cell is empty");
  target.q = Numbers(q_);
  for (int j = 0; target.q && j < robot_.num_joints(); ++j) {
    const Joint& joint = robot_.chain.joints[j];
    if (joint.Allows((*target.q)[j])) continue;
    Fail(table_.file.header[q_[j].index], "joint '" + joint.name + "' does not move by itself");
  }
  target.flange_in_base = PoseOfRow();
  if (!target.q && !target.flange_in_base)
    Fail("target", "target '" + target.name + "' has neither joint values nor a pose");
  return target;
}

// 0, but of joints that have one value only.
Eigen::VectorXd TargetReader::ValuesOfNone() const {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(robot_.num_joints());
  for (int j = 0; j < robot_.num_joints(); ++j) {
    if (robot_.chain.joints[j].IsHeld()) q[j] = *robot_.chain.joints[j].min;
  }
  return q;
}

void TargetReader::AddShot(const Target& target, Measurements* data) {
  const int i = static_cast<int>(data->shots.size());
  const Eigen::VectorXd q = target.q ? *target.q : ValuesOfNone();
  data->configurations.push_back({target.name, q, false});
  Shot shot;
  shot.configuration = i;
  const std::string station = Cell(stations_).empty() ? station_ : Cell(stations_);
  const auto found = std::find(data->stations.begin(), data->stations.end(), station);
  shot.station = static_cast<int>(found - data->stations.begin());
  if (found == data->stations.end()) data->stations.push_back(station);
  for (int a = 0; a < 3; ++a) {
    shot.wrench.force[a] = Number(wrench_[a]).value_or(0.0);
    shot.wrench.moment[a] = Number(wrench_[a + 3]).value_or(0.0);
  }
  if (load_.index < 0 && !shot.wrench.IsZero()) shot.load = "unnamed";
  if (!Cell(load_).empty()) shot.load = Cell(load_);
  if (IsNoneInOtherLetters(shot.load)) Fail("load", "'" + shot.load + "': " + kLoadOrNone, kHowNoneIsWritten);
  if (const std::optional<double> time = Number(time_)) shot.has_time = true, shot.time = *time;
  if (const std::optional<double> degrees = Number(temperature_)) {
    shot.has_temperature = true, shot.temperature = *degrees;
  }
  bool states_approach = false;
  for (const TargetColumn& column : approach_) {
    const std::optional<double> direction = Number(column);
    states_approach |= direction.has_value();
    if (direction && *direction != -1.0 && *direction != 0.0 && *direction != 1.0) {
      Fail(table_.file.header[column.index], "the direction of the last motion is -1, 0 or 1");
    }
    shot.approach.push_back(direction ? static_cast<int>(*direction) : kApproachNotStated);
  }
  if (!states_approach) shot.approach.clear();
  shot.observations = {i};
  data->shots.push_back(shot);
  Observation observation;
  observation.shot = i;
  observation.file = 0;
  observation.row = i;
  data->observations.push_back(observation);
}

// About one axis a vector and angles are the same.
bool TargetReader::MayBeNoVector() const {
  if (form_ != RotationForm::kVector) return false;
  int turning = 0;
  for (const TargetColumn& column : rotation_) {
    if (column.unit.multiplier == kDegree && Number(column).value_or(0.0) != 0.0) ++turning;
  }
  return turning > 1;
}

Targets TargetReader::Read() {
  RenameTargetColumns(robot_.chain.joints, &table_.file.header, &notes_);
  FindColumns();
  if (decimal_comma_) WriteNumbersAsOurs(ColumnsOfNumbers(), &table_.file);
  Targets targets;
  targets.rotation_form = form_;
  for (const Joint& joint : robot_.chain.joints) targets.joint_types.push_back(joint.type);
  for (const MeasurementFile::Row& row : table_.file.rows) {
    row_ = &row;
    targets.rows.push_back(ReadTarget());
    targets.may_be_no_vector |= MayBeNoVector();
    AddShot(targets.rows.back(), &targets.shots);
  }
  targets.shots.files.push_back(std::move(table_.file));
  targets.shots.unread_columns = unread_;
  targets.notes = std::move(notes_);
  return targets;
}

}  // namespace

Targets ReadTargets(const std::string& path, const Robot& robot, const std::string& station) {
  std::vector<std::string> notes;
  TargetTable table = ReadTargetTable(path, &notes);
  return TargetReader(std::move(table), robot, station, std::move(notes)).Read();
}

Targets TargetsFromTable(CsvTable table, const Robot& robot, const std::string& station) {
  return TargetReader({std::move(table), false}, robot, station, {}).Read();
}

}  // namespace sagitta
