// Programs as texts, and what is read of them.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "problems/io/programs/robot_program.h"
#include "tests/problems/file_test_support.h"

namespace sagitta {

class RobotProgramTest : public FileTest {
 protected:
  RobotProgram ReadAs(const std::string& name, const std::string& text) {
    return ReadRobotProgram(Write(name, text), 6);
  }
};

inline const ProgramPoint& PointNamed(const RobotProgram& program, const std::string& name) {
  for (const ProgramPoint& point : program.points) {
    if (point.name == name) return point;
  }
  throw std::runtime_error("no point " + name);
}

// Its numbers as they are written.
inline std::vector<double> ValuesOf(const ProgramPoint& point) {
  std::vector<double> values;
  for (const TextNumber& number : point.numbers) values.push_back(number.value);
  return values;
}

// The program with one point replaced: by joints in rad, or by a pose.
inline std::string WithOne(const RobotProgram& program, int index, const std::vector<double>& joints,
                           const Pose<double>* pose) {
  CorrectedPoint corrected;
  corrected.point = index;
  corrected.joints = joints;
  if (pose != nullptr) corrected.tool_in_frame = *pose;
  return WithCorrectedPoints(program, {corrected});
}

// "line name: reason" of every motion to what is not corrected, "line name" of the others.
inline std::vector<std::string> MotionsOf(const RobotProgram& program) {
  std::vector<std::string> lines;
  for (const ProgramMotion& motion : program.motions) {
    const ProgramPoint& point = program.points[static_cast<size_t>(motion.point)];
    lines.push_back(std::to_string(motion.line) + " " + motion.name +
                    (point.untouched.empty() ? "" : ": " + point.untouched));
  }
  return lines;
}

}  // namespace sagitta
