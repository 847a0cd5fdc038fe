// Two estimates of one robot as one problem: how far their predictions are apart, how sure that is, and what each
// possible change would do. The old estimate is moved, exactly, by any set of changes; columns are derivatives there.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimator/changes/campaigns.h"
#include "estimator/changes/change_groups.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {

// How markers on the flange are brought to where the new campaign has them: each by itself, or as one body and then
// each by itself. Both reach the same points; which of them is a small step further than the other depends on what
// happened, and a turn by much is not a sum of shifts.
enum class MarkerStart { kEach, kBody };

class EstimateComparison {
 public:
  // Throws InputError where the robots differ or nothing can be compared.
  EstimateComparison(const KnownRobot& old_estimate, const KnownRobot& new_estimate);

  const std::vector<ChangeGroup>& groups() const { return groups_; }
  const std::vector<std::string>& notes() const { return notes_; }

  // Moves the old estimate by what can be of any size (bases, markers, joint zeros) next to the new one, and finds the
  // covariance of the difference there.
  void Align(MarkerStart start);

  // Leaves those groups out that explain nothing of their own: what lies within the columns of zeros, bases, tool and
  // markers is one of these; of two that move the points alike the first stays and names the other.
  void LeaveOutIndistinguishable();

  // Whitened: what is left of new - old, and columns per typical size, where the old estimate has been moved to.
  struct Linear {
    Eigen::VectorXd left;
    Eigen::MatrixXd columns;
    Eigen::VectorXd applied;  // where that is, one per column
    std::vector<std::vector<int>> of_group;
  };
  Linear Linearise() const;
  double LogDeterminant() const { return log_determinant_; }  // of the covariance

  // Per group, in typical sizes, from where the old estimate was at first.
  void MoveTo(const std::vector<Eigen::VectorXd>& applied);
  const std::vector<Eigen::VectorXd>& applied() const { return applied_; }
  double Rms() const;        // m, 3-D distances of what is left
  double NumRandom() const;  // of the numbers in `left`, how many the estimates leave open: tr C^-1 (C - e^2 I)
  // Joints whose zero is within the columns of these groups.
  std::vector<std::string> ZerosWithin(const Linear& linear, const std::vector<size_t>& set) const;

 private:
  Eigen::MatrixXd SpreadOf(const CalibrationProblem& problem, const KnownRobot& known, const KnownRobot& other,
                           const Eigen::MatrixXd& jacobian, const Eigen::MatrixXd& where_it_was) const;
  double ModelErrorOf(int which) const;
  double UnseenModelErrorOf(int which) const;
  Eigen::MatrixXd RegionSpread(const Linearization& all) const;
  void FactorCovariance();
  void NoteWhatOneAssumed();
  void SetMoments();
  void AssumeAlike(int which, const KnownRobot& other);
  void CheckKnown() const;
  void AllowForHalves();
  void AllowForClusters();
  void AllowForRegions();
  Eigen::VectorXd Difference() const;
  Eigen::Matrix3Xd MovedPoints() const;  // of the old estimate, where it has been moved to
  // m: what a change of all lengths by 1 moves the points by; those of the arm, and its distance to the instrument.
  struct Lengths {
    Eigen::Matrix3Xd arm, distance;
  };
  Lengths LengthsAt(const Eigen::Matrix3Xd& points) const;
  // m per typical size.
  Eigen::MatrixXd ColumnsOf(size_t group, const Linearization& all) const;
  Eigen::MatrixXd MetricColumns(const std::vector<size_t>& groups) const;  // side by side
  Eigen::MatrixXd TurnedWithTheChanges(Eigen::MatrixXd jacobian) const;
  void RegisterBases();
  void RegisterTool();
  void Fit(const std::vector<ChangeKind>& kinds);
  void Drop(const std::vector<bool>& stays);

  KnownRobot old_, new_;
  CampaignsOwn own_;
  std::vector<CalibrationProblem> problems_;  // old, new
  ParameterSet start_;                        // of the old one
  std::vector<Eigen::VectorXd> start_joints_;
  std::vector<Vector3<double>> moved_by_events_;  // markers of the old one (MovedByEvents)
  std::vector<int> rows_;
  std::vector<ChangeGroup> groups_;
  std::vector<Eigen::VectorXd> applied_;
  double arm_grown_ = 0.0, distance_grown_ = 0.0;  // of the old one, shares
  double of_region_ = 0.0;                         // m, RMS: by what the model may err in one region alone
  Eigen::MatrixXd spread_;                         // S with C = S S' + e^2 I
  Eigen::MatrixXd whitener_;                       // lower factor of C
  double log_determinant_ = 0.0;
  std::vector<std::string> notes_;
};

}  // namespace sagitta
