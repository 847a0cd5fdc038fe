// A robot out of a foreign file, with what was understood and what was guessed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/robot.h"
#include "problems/io/urdf_chain.h"

namespace sagitta {

struct RobotReading {
  Robot robot;
  std::string format;                // in words
  std::vector<std::string> notes;    // what was understood
  std::vector<std::string> guesses;  // what could be meant otherwise
  // A DH table that does not say its convention, read as standard: only with leave_convention_open.
  bool convention_is_open = false;
};

struct RobotReadOptions {
  std::optional<DhConvention> convention;  // where a table does not say
  bool leave_convention_open = false;      // neither guess nor refuse: somebody has readings that decide
  UrdfEnds ends;
  std::string nominal_file;  // the robot that a calibration.conf of deltas belongs to
};

// robot.yaml, URDF, DH tables as text, Universal Robots' calibration.yaml and
// .conf, MATLAB text; by content, not by the name. Throws InputError.
RobotReading ReadAnyRobot(const std::string& path, const RobotReadOptions& options = {});

// The same of text that was read: `path` is what messages call it.
RobotReading ReadAnyRobotText(const std::string& bytes, const std::string& path, const RobotReadOptions& options = {});

// True for a file that ReadAnyRobot reads as a robot and not as a table of measurements.
bool LooksLikeRobot(const std::string& path);

// The formats, one file each.
bool LooksLikeDhTable(const std::string& text, const std::string& path);
RobotReading ReadDhText(const std::string& text, const std::string& path, const RobotReadOptions& options);
bool LooksLikeMatlab(const std::string& text);
RobotReading ReadMatlabText(const std::string& text, const std::string& path, const RobotReadOptions& options);
bool LooksLikeUrCalibration(const std::string& text);  // ROS' calibration.yaml
RobotReading ReadUrCalibration(const std::string& text, const std::string& path);
bool LooksLikeUrConf(const std::string& text);  // the controller's urcontrol.conf, calibration.conf
RobotReading ReadUrConf(const std::string& text, const std::string& path, const RobotReadOptions& options);

// A DH robot of such links: joints called j1 … unless named; both guesses of ReadDhText for tables without words.
std::optional<DhConvention> ConventionByShape(const std::vector<DhLink>& links);
// What to state for a table that does not say its convention.
std::string ConventionHint();
Robot RobotOfTable(const std::vector<Joint>& joints, const std::vector<Coupling>& couplings, const DhTable& table);

}  // namespace sagitta
