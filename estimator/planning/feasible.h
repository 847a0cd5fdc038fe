// Which poses can be measured: joint limits, and what the cell states (problems/cell.h). Geometry is that of the robot
// as its file states it, base and markers as registered, the arm unloaded; it deflects by less than a sensible
// clearance.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimator/planning/collision.h"
#include "problems/calibration_problem.h"
#include "problems/cell.h"

namespace sagitta {

// Station and marker of one line of sight.
struct Sight {
  int station = -1, marker = -1;
};
// Of the listed shots, none twice.
std::vector<Sight> SightsOf(const Measurements& data, const std::vector<int>& shots);

class FeasiblePoses {
 public:
  // placed: robot, stations and markers where they stand; it must outlive this, and so must the cell (null: only the
  // joint limits count). Throws InputError for a station or marker of the cell that `placed` does not have.
  FeasiblePoses(const CalibrationProblem& placed, const Cell* cell);

  // Empty, or the first thing that forbids the pose, in words that many poses share.
  std::string WhyNot(const Eigen::VectorXd& q, const std::vector<Sight>& sights) const;

  // What is checked and what is not, as ends of the sentences "Checked of each pose: …", "Not checked: …".
  std::vector<std::string> Checked() const;
  std::vector<std::string> NotChecked() const;

 private:
  std::string OutsideJoints(const Eigen::VectorXd& q) const;
  std::string OutsideBoxes(const std::vector<Pose<double>>& frames, const std::vector<Sight>& sights) const;
  std::string Unseen(const std::vector<Pose<double>>& frames, const Sight& sight) const;
  Vector3<double> MarkerInBase(const std::vector<Pose<double>>& frames, int marker) const;

  const CalibrationProblem& placed_;
  const Cell* cell_;
  std::optional<CollisionScene> bodies_;
  std::vector<const SightRange*> range_of_station_;
  std::vector<const DirectionCone*> cone_of_marker_;
};

}  // namespace sagitta
