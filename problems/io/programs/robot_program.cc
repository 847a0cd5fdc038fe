#include "problems/io/programs/robot_program.h"

#include <algorithm>
#include <cmath>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/programs/program_text.h"
#include "problems/text.h"

namespace sagitta {

void UseLoad(const std::string& load, bool is_first, ProgramPoint* point) {
  if (is_first) {
    point->load = load;
  } else if (point->load != load) {
    point->other_load = load;
  }
}

int AddComputedPoint(const std::string& name, int line, size_t used_at, const std::string& why, RobotProgram* program) {
  ProgramPoint point;
  point.name = name;
  point.line = line;
  point.used_at = used_at;
  point.untouched = why;
  program->points.push_back(point);
  return static_cast<int>(program->points.size()) - 1;
}

int AddPointElsewhere(const std::string& name, int line, size_t used_at, RobotProgram* program) {
  const int index = AddComputedPoint(name, line, used_at, kPointElsewhere, program);
  program->points.back().is_elsewhere = true;
  return index;
}

Pose<double> PoseFrom(PoseNotation notation, const std::vector<double>& n) {
  const Vector3<double> translation(n[0], n[1], n[2]);
  switch (notation) {
    case PoseNotation::kAbcDegrees:
      return {RotationFromRpy(kDegree * Vector3<double>(n[5], n[4], n[3])), translation / 1e3};
    case PoseNotation::kWprDegrees:
      return {RotationFromRpy(kDegree * Vector3<double>(n[3], n[4], n[5])), translation / 1e3};
    case PoseNotation::kQuaternion:
      return {Eigen::Quaterniond(n[3], n[4], n[5], n[6]).normalized().toRotationMatrix(), translation / 1e3};
    case PoseNotation::kRotationVectorMetres:
      return {RotationFromVector(Vector3<double>(n[3], n[4], n[5])), translation};
  }
  return {};
}

std::vector<double> NumbersOf(PoseNotation notation, const Pose<double>& pose) {
  const Vector3<double> m = pose.translation, mm = 1e3 * m, rpy = RpyFromRotation(pose.rotation) / kDegree;
  switch (notation) {
    case PoseNotation::kAbcDegrees:
      return {mm.x(), mm.y(), mm.z(), rpy.z(), rpy.y(), rpy.x()};
    case PoseNotation::kWprDegrees:
      return {mm.x(), mm.y(), mm.z(), rpy.x(), rpy.y(), rpy.z()};
    case PoseNotation::kQuaternion: {
      const Eigen::Quaterniond q(pose.rotation);
      return {mm.x(), mm.y(), mm.z(), q.w(), q.x(), q.y(), q.z()};
    }
    case PoseNotation::kRotationVectorMetres: {
      const Vector3<double> v = RotationVector(pose.rotation);
      return {m.x(), m.y(), m.z(), v.x(), v.y(), v.z()};
    }
  }
  return {};
}

std::vector<double> RobotProgram::JointValues(const ProgramPoint& point) const {
  std::vector<double> values;
  for (const TextNumber& n : point.numbers) {
    values.push_back(traits().joints_in_rad ? n.value : n.value * kDegree);
  }
  return values;
}

RobotProgram ReadRobotProgram(const std::string& path, int joints) {
  RobotProgram program;
  program.path = path;
  program.dialect = DialectOfFile(path);
  program.text = ReadTextFile(path);
  if (program.text.find('\0') != std::string::npos) {
    throw InputError({path, 0, ""}, "this is no text of one byte per character (UTF-16?)",
                     "save it as UTF-8 or ANSI, as controllers do");
  }
  program.traits().read(joints, &program);
  if (std::all_of(program.points.begin(), program.points.end(), [](const auto& p) { return p.is_elsewhere; })) {
    throw InputError({path, 0, ""}, std::string("there is no target in this ") + program.traits().name + " file",
                     "points that stand in another file (a .dat next to a .src) are corrected there");
  }
  return program;
}

namespace {

// Finer than controllers resolve: 0.1 um, 0.02 urad; quaternions 0.02 urad.
int Decimals(const RobotProgram& program, const ProgramPoint& point, size_t i) {
  if (point.is_joints) return program.traits().joints_in_rad ? 8 : 6;
  switch (program.traits().notation) {
    case PoseNotation::kAbcDegrees:
    case PoseNotation::kWprDegrees:
      return i < 3 ? 4 : 6;
    case PoseNotation::kQuaternion:
      return i < 3 ? 4 : 9;
    case PoseNotation::kRotationVectorMetres:
      break;
  }
  return 8;
}

// Near the angles of the file: A = 180 stays 180 and does not become -179.99.
double NearestTurn(double value, double written, double turn) {
  return value + turn * std::round((written - value) / turn);
}

// Each of the following writes the rotation in values[3], ... as near as can be to how the file has it.

// Three angles, deg; yaw: which of them is about z.
void TurnToWrittenAngles(size_t yaw, const std::vector<TextNumber>& written, std::vector<double>* values) {
  const size_t pitch = 4, roll = 8 - yaw;
  std::vector<double>& angles = *values;
  const auto to_nearest_turns = [&written](std::vector<double>* of) {
    for (size_t i = 3; i < 6; ++i) (*of)[i] = NearestTurn((*of)[i], written[i].value, 360.0);
  };
  // Roll and yaw turn about one axis: only their sum (difference) is determined, and the file says what is of either.
  if (std::abs(std::cos(angles[pitch] * kDegree)) < 1e-9) {
    const double turn = written[yaw].value - angles[yaw];
    angles[yaw] += turn;
    angles[roll] += angles[pitch] > 0.0 ? turn : -turn;
    to_nearest_turns(values);
    return;
  }
  // The other set of angles, (x + 180, 180 - y, z + 180), where the file has that one.
  const auto distance = [&written](const std::vector<double>& from) {
    double sum = 0.0;
    for (size_t i = 3; i < 6; ++i) sum += std::abs(from[i] - written[i].value);
    return sum;
  };
  std::vector<double> other = angles;
  other[roll] += 180.0, other[yaw] += 180.0, other[pitch] = 180.0 - other[pitch];
  to_nearest_turns(values);
  to_nearest_turns(&other);
  if (distance(other) < distance(angles)) angles = other;
}

// q and -q are one rotation.
void TurnToWrittenQuaternion(const std::vector<TextNumber>& written, std::vector<double>* values) {
  double product = 0.0;
  for (size_t i = 3; i < 7; ++i) product += (*values)[i] * written[i].value;
  for (size_t i = 3; i < 7 && product < 0.0; ++i) (*values)[i] = -(*values)[i];
}

// A vector of the same direction, whose angle is on the other side of half a turn.
void TurnToWrittenVector(const std::vector<TextNumber>& written, std::vector<double>* values) {
  Vector3<double> v((*values)[3], (*values)[4], (*values)[5]);
  const Vector3<double> before(written[3].value, written[4].value, written[5].value);
  const Vector3<double> other = v.norm() > 0.0 ? Vector3<double>(v * (1.0 - 2.0 * kPi / v.norm())) : v;
  if ((other - before).norm() < (v - before).norm()) v = other;
  for (int i = 0; i < 3; ++i) (*values)[3 + i] = v[i];
}

std::vector<double> Values(const RobotProgram& program, const ProgramPoint& point, const CorrectedPoint& corrected) {
  if (point.is_joints) {
    std::vector<double> values = corrected.joints;
    for (double& value : values) value /= program.traits().joints_in_rad ? 1.0 : kDegree;
    return values;
  }
  const PoseNotation notation = program.traits().notation;
  std::vector<double> values = NumbersOf(notation, corrected.tool_in_frame);
  switch (notation) {
    case PoseNotation::kAbcDegrees:
      TurnToWrittenAngles(3, point.numbers, &values);
      break;
    case PoseNotation::kWprDegrees:
      TurnToWrittenAngles(5, point.numbers, &values);
      break;
    case PoseNotation::kQuaternion:
      TurnToWrittenQuaternion(point.numbers, &values);
      break;
    case PoseNotation::kRotationVectorMetres:
      TurnToWrittenVector(point.numbers, &values);
      break;
  }
  return values;
}

}  // namespace

std::string WithCorrectedPoints(const RobotProgram& program, const std::vector<CorrectedPoint>& corrected) {
  std::vector<std::pair<TextNumber, std::string>> edits;
  for (const CorrectedPoint& c : corrected) {
    const ProgramPoint& point = program.points[static_cast<size_t>(c.point)];
    const std::vector<double> values = Values(program, point, c);
    for (size_t i = 0; i < point.numbers.size(); ++i) {
      edits.emplace_back(point.numbers[i], Fixed(values[i], Decimals(program, point, i)));
    }
  }
  std::sort(edits.begin(), edits.end(), [](const auto& a, const auto& b) { return a.first.begin < b.first.begin; });
  std::string text;
  size_t from = 0;
  for (const auto& [place, number] : edits) {
    text.append(program.text, from, place.begin - from);
    text += number;
    from = place.end;
  }
  return text.append(program.text, from, std::string::npos);
}

}  // namespace sagitta
