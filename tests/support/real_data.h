// The measured robots next to the tree (../shared/data), where they are there.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "problems/calibration_problem.h"
#include "problems/io/measurement_file.h"
#include "problems/io/robot_file.h"
#include "tests/support/paths.h"

namespace sagitta::test {

inline std::string RealData(const std::string& name) { return test::SharedFolder() + "/data/" + name; }
inline bool HasRealData() { return std::filesystem::exists(RealData("ur10_leica/robot.yaml")); }

inline CalibrationProblem RealProblem(const std::string& folder, const std::vector<std::string>& files,
                                      const Experiment& experiment) {
  const Robot robot = ReadRobotFile(RealData(folder + "/robot.yaml"));
  std::vector<std::string> paths;
  for (const std::string& file : files) paths.push_back(RealData(folder + "/" + file));
  return MakeCalibrationProblem(robot, ReadMeasurementsFor(robot, paths), experiment);
}

}  // namespace sagitta::test
