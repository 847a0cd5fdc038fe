#include "problems/io/target_file.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "models/effects/effect.h"
#include "problems/input_error.h"
#include "problems/io/csv_table.h"
#include "problems/io/files.h"
#include "problems/io/load_names.h"
#include "problems/io/units.h"
#include "problems/limits.h"
#include "problems/unit_words.h"

namespace sagitta {
namespace {

struct TargetColumn {
  int index = -1;
  Unit unit{"", 1.0, 1.0};
};

class TargetReader {
 public:
  TargetReader(CsvTable table, const Robot& robot, const std::string& station)
      : table_(std::move(table)), robot_(robot), station_(station) {}

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
  void FindColumns();
  void CheckUnlisted();

  std::string Cell(const TargetColumn& column) const;
  std::optional<double> Number(const TargetColumn& column) const;
  // All of a group or none.
  std::optional<Eigen::VectorXd> Numbers(const std::vector<TargetColumn>& columns) const;
  Target ReadTarget();
  void AddShot(const Target& target, Measurements* data);

  CsvTable table_;
  const Robot& robot_;
  const std::string station_;
  const MeasurementFile::Row* row_ = nullptr;
  std::vector<std::string> listed_;
  std::vector<std::string> unread_;
  TargetColumn name_, load_, stations_, time_, temperature_;
  std::vector<TargetColumn> q_, pose_, approach_;
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

void TargetReader::FindColumns() {
  name_ = Plain("target");
  if (name_.index < 0) Fail("target", "column 'target' is missing", "it names each row");
  std::vector<std::string> joints;
  std::vector<Dimension> units;
  for (int j = 0; j < robot_.num_joints(); ++j) {
    joints.push_back("q" + std::to_string(j + 1));
    const bool turns = robot_.chain.joints[j].type == JointType::kRevolute;
    units.push_back(turns ? Dimension::kAngle : Dimension::kLength);
    approach_.push_back(Plain("approach" + std::to_string(j + 1)));
  }
  bool has_joints = false, has_pose = false;
  q_ = Group(joints, units, &has_joints);
  const Dimension length = Dimension::kLength, angle = Dimension::kAngle;
  pose_ = Group({"x", "y", "z", "rx", "ry", "rz"}, {length, length, length, angle, angle, angle}, &has_pose);
  for (int i = 0; i < 3; ++i) {
    wrench_[i] = Plain(std::string("f") + "xyz"[i] + "_N");
    wrench_[i + 3] = Plain(std::string("m") + "xyz"[i] + "_Nm");
  }
  load_ = Plain("load");
  stations_ = Plain("station");
  time_ = Plain("time_s");
  temperature_ = Plain("temperature_degC");
  CheckUnlisted();
  if (!has_joints && !has_pose) {
    Fail("", "the targets have neither joint values nor poses",
         "columns q1_deg …, or x_mm, y_mm, z_mm, rx_mrad, ry_mrad, rz_mrad in the base frame");
  }
}

// Other columns are carried along, slips of ours and joints that the robot does not have are not.
void TargetReader::CheckUnlisted() {
  for (const std::string& name : table_.file.header) {
    if (std::find(listed_.begin(), listed_.end(), name) != listed_.end()) continue;
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
  if (const std::optional<Eigen::VectorXd> pose = Numbers(pose_)) {
    target.flange_in_base = Pose<double>{RotationFromVector(Vector3<double>(pose->tail<3>())), pose->head<3>()};
  }
  if (!target.q && !target.flange_in_base)
    Fail("target", "target '" + target.name + "' has neither joint values nor a pose");
  return target;
}

void TargetReader::AddShot(const Target& target, Measurements* data) {
  const int i = static_cast<int>(data->shots.size());
  const Eigen::VectorXd q = target.q.value_or(Eigen::VectorXd::Zero(robot_.num_joints()));
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

Targets TargetReader::Read() {
  FindColumns();
  Targets targets;
  for (const Joint& joint : robot_.chain.joints) targets.joint_types.push_back(joint.type);
  for (const MeasurementFile::Row& row : table_.file.rows) {
    row_ = &row;
    targets.rows.push_back(ReadTarget());
    AddShot(targets.rows.back(), &targets.shots);
  }
  targets.shots.files.push_back(std::move(table_.file));
  targets.shots.unread_columns = unread_;
  return targets;
}

}  // namespace

Targets ReadTargets(const std::string& path, const Robot& robot, const std::string& station) {
  return TargetsFromTable(ReadCsvTable(path), robot, station);
}

Targets TargetsFromTable(CsvTable table, const Robot& robot, const std::string& station) {
  return TargetReader(std::move(table), robot, station).Read();
}

}  // namespace sagitta
