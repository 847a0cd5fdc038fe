// Two estimates of one robot as one linear problem: how far their predictions are apart, how sure that is, and what
// each possible change would do.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimator/results/estimate_json.h"
#include "problems/choices.h"

namespace sagitta {

// What can have changed between two estimates.
enum class ChangeKind { kJointZero, kTool, kMarker, kBase, kGeometry, kCompliance, kCompensator, kEffect };
template <>
struct ChoiceWords<ChangeKind> {
  static constexpr const char* kWords[] = {"joint_zero", "tool",       "marker",      "base",
                                           "geometry",   "compliance", "compensator", "effect"};
};

// One explanation: what moves, per typical size of each of its parameters.
struct ChangeGroup {
  ChangeKind kind;
  std::string target;
  Eigen::MatrixXd coordinates = {};  // of the old problem's coordinates (SI) by parameter
  int joint = -1;                    // whose encoder zero moves; -1: none
  double joint_size = 0.0;           // rad or m, typical
  std::vector<std::string> names = {};
  std::vector<double> unit = {};  // SI value of the unit of each parameter
  std::vector<std::string> units = {};
  std::vector<double> typical = {};  // SI
  int size() const { return static_cast<int>(names.size()); }
};

class EstimateComparison {
 public:
  // Throws InputError where the robots differ or nothing is shared.
  EstimateComparison(const KnownRobot& old_estimate, const KnownRobot& new_estimate);

  const std::vector<ChangeGroup>& groups() const { return groups_; }
  const std::vector<std::string>& notes() const { return notes_; }

  // Whitened difference and columns, linearised where the old estimate has been moved to; the difference is that from
  // where it was: what is left plus what has been applied.
  struct Linear {
    Eigen::VectorXd difference;
    Eigen::MatrixXd columns;
    std::vector<std::vector<int>> of_group;
  };
  Linear Linearise() const;
  // applied: per group, in typical sizes; moves the old estimate there, from where it is.
  void MoveTo(const std::vector<Eigen::VectorXd>& applied);
  double Rms() const;  // m, 3-D distances of what is left

 private:
  void CheckSameRobot(const KnownRobot& a, const KnownRobot& b) const;
  Measurements MakeRows(const KnownRobot& a, const KnownRobot& b);
  void ListGroups();
  ChangeGroup Motion(ChangeKind kind, const std::string& target) const;
  void AddMarkers();
  void FactorCovariance();
  Eigen::MatrixXd SpreadOf(const CalibrationProblem& problem, const KnownRobot& known, const KnownRobot& other) const;
  Eigen::VectorXd Difference() const;

  KnownRobot old_, new_;
  std::vector<CalibrationProblem> problems_;  // old, new
  std::vector<int> rows_;
  std::vector<ChangeGroup> groups_;
  std::vector<Eigen::VectorXd> applied_;
  Eigen::MatrixXd whitener_;  // lower factor of C
  std::vector<std::string> notes_;
};

}  // namespace sagitta
