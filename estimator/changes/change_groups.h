// What can have changed on a robot or between two campaigns, each as what it moves.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimator/changes/campaigns.h"
#include "problems/calibration_problem.h"
#include "problems/choices.h"

namespace sagitta {

// What can have changed between two estimates.
enum class ChangeKind {
  kJointZero,
  kTool,
  kMarker,
  kMarkers,  // all those on the flange, each by its own amount
  kBase,
  kScale,
  kGeometry,
  kCompliance,
  kCompensator,
  kEffect
};
// "joint_zero", ...
std::string WordOf(ChangeKind kind);

// One explanation: what moves, per typical size of each of its parameters.
struct ChangeGroup {
  ChangeKind kind;
  std::string target;
  int index = -1;                       // joint, station or marker
  std::vector<int> coordinates = {};    // of the problem's parameters, one per parameter; zero, tool, scale: none
  std::vector<int> carried = {};        // markers that move with the tool
  bool of_campaign = false;             // of each campaign, under a name that is not shared: any amount, nothing said
  std::vector<std::string> names = {};  // of the parameters
  std::vector<double> unit = {};        // SI value of the unit of each
  std::vector<std::string> units = {};
  std::vector<double> typical = {};    // SI
  std::vector<std::string> same = {};  // other parameters that would move the points alike

  int size() const { return static_cast<int>(names.size()); }
  // Translation and rotation vector.
  bool is_motion() const { return kind == ChangeKind::kTool || kind == ChangeKind::kBase; }
  // A joint's zero, the base, the tool or markers: a cause that needs no design parameter to be another, and that can
  // be of any size (set up anew, mastered anew, mounted anew).
  bool is_plain() const {
    return is_motion() || kind == ChangeKind::kJointZero || kind == ChangeKind::kMarker || kind == ChangeKind::kMarkers;
  }
};

// problem: predicts the rows of both with the old robot.
std::vector<ChangeGroup> ListChangeGroups(const CalibrationProblem& problem, const KnownRobot& old_estimate,
                                          const KnownRobot& new_estimate, const CampaignsOwn& own);

// Whether `all` are markers that were mounted anew, and `part` is one of these or the tool that carries them.
bool IsPartOf(const ChangeGroup& part, const ChangeGroup& all);

// A change further: sums, of motions translations and products of rotations. In typical sizes.
Eigen::VectorXd Further(const ChangeGroup& group, const Eigen::VectorXd& change, const Eigen::VectorXd& step);

// Rotation of a motion that has gone so far.
Matrix3<double> RotationOf(const ChangeGroup& group, const Eigen::VectorXd& change);

}  // namespace sagitta
