// Other ways to read the same robot file and rows: what people mix up when they bring them together. Each is tried
// where the aligned nominal robot misses by far (reading_lint.h).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// The rows changed, or another robot.
struct Reading {
  std::string code;  // of the finding: sign_flip, joint_offset, dh_convention, joint_order, …
  std::string name;  // "joint A2 counted the other way"
  std::string remedy;
  std::function<void(Measurements*)> change;  // of joint values (SI) and points (m); empty: none
  bool changes_joints = false;                // joint values, which all rows of a configuration share
  std::optional<Robot> robot;
  double misfit = 0.0;       // distance RMS, aligned, m
  bool is_of_order = false;  // points go with the joint values of other rows
};

// Simple ones first: the first of those that fit alike is what is named. They can be tried on a part of the problem's
// configurations.
std::vector<Reading> AllReadings(const CalibrationProblem& problem);

// One of them: the lengths of the robot file 1000 times shorter.
Reading RobotInMillimetres(const CalibrationProblem& problem);

// The problem as read that way. Nothing is held out; rows without a counterpart are excluded.
CalibrationProblem Reread(const CalibrationProblem& problem, const Reading& reading);

}  // namespace sagitta
