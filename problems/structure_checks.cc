#include "problems/structure_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "models/constants.h"
#include "models/effects/effect.h"
#include "problems/limits.h"
#include "problems/robot_structure.h"
#include "problems/structure_failure.h"

namespace sagitta {
namespace {

// As many as there are joints, or none.
void CheckOnePerJoint(Eigen::Index count, int joints, const ItemName& item, const char* what) {
  if (count == joints) return;
  FailStructure(item, std::to_string(count) + " " + what + ", the robot has " + std::to_string(joints) + " joints");
}

void CheckConfigurations(const Measurements& data, int joints) {
  for (const Configuration& configuration : data.configurations) {
    const std::string item = "configuration " + configuration.id;
    CheckCanBeWritten(configuration.id, item, "its id");
    CheckOnePerJoint(configuration.q.size(), joints, item, "joint values");
    CheckAreNumbers(configuration.q, item, "a joint value");
  }
}

bool MovesWithAnother(const Chain& chain, int joint) {
  return std::any_of(chain.couplings.begin(), chain.couplings.end(),
                     [joint](const Coupling& coupling) { return coupling.joint == joint; });
}

// A joint that is held has its one value in every row; another would be counted in addition to what it mimics.
void CheckHeldJoints(const Chain& chain, const Measurements& data, const Shot& shot) {
  const Eigen::VectorXd& q = data.configurations[shot.configuration].q;
  for (int j = 0; j < chain.num_joints(); ++j) {
    const Joint& joint = chain.joints[j];
    if (joint.Allows(q[j])) continue;
    const bool turns = joint.type == JointType::kRevolute;
    const double per_si = turns ? 180.0 / kPi : 1e3;
    const char* hint =
        MovesWithAnother(chain, j)
            ? "what a joint with <mimic> moves with another is not in its own column"
            : "the robot file has this value as its lower and as its upper limit: a joint that moves has "
              "two, and one that is locked has this value in every row, to 0.0005 deg or mm";
    throw InputError(data.WhereOf(shot, "q" + std::to_string(j + 1)),
                     fmt::format("joint '{}' does not move by itself: its value is {:.9g}, not {:.9g} {}", joint.name,
                                 *joint.min * per_si, q[j] * per_si, turns ? "deg" : "mm"),
                     hint);
  }
}

void CheckShot(const Measurements& data, size_t s, int joints) {
  const Shot& shot = data.shots[s];
  const ItemName item("shot", s);
  CheckIndex(shot.configuration, data.configurations.size(), item, "configuration");
  CheckIndex(shot.station, data.stations.size(), item, "station");
  CheckCanBeWritten(shot.visit, item, "its visit");
  CheckCanBeWritten(shot.repeat, item, "its repeat");
  CheckCanBeWritten(shot.load, item, "its load");
  if (shot.joint_torques.size() > 0) CheckOnePerJoint(shot.joint_torques.size(), joints, item, "joint torques");
  if (!shot.approach.empty()) {
    CheckOnePerJoint(static_cast<Eigen::Index>(shot.approach.size()), joints, item, "directions of approach");
  }
  for (const int direction : shot.approach) {
    if (direction < -1 || direction > kApproachNotStated) FailStructure(item, "a direction of approach is -1, 0 or 1");
  }
  CheckAreNumbers(shot.joint_torques, item, "a joint torque");
  CheckAreNumbers(shot.wrench.force, item, "its force");
  CheckAreNumbers(shot.wrench.moment, item, "its moment");
  if (shot.has_time && !(std::abs(shot.time) < limits::kTime)) FailStructure(item, "its time is no number");
  if (shot.has_temperature) CheckIsNumber(shot.temperature, item, "its temperature");
  for (const int i : shot.observations) {
    CheckIndex(i, data.observations.size(), item, "observation");
    if (data.observations[i].shot != static_cast<int>(s)) {
      FailStructure(item, fmt::format("it lists observation {}, which is of shot {}", i, data.observations[i].shot));
    }
  }
}

// 0: none is stated.
void CheckSigmas(const Vector3<double>& sigmas, double least, double largest, const ItemName& item) {
  for (const double sigma : sigmas) {
    if (sigma == 0.0 || (sigma >= least && sigma <= largest)) continue;  // not so: NaN
    FailStructure(item, "a standard deviation is none of a measurement", "m or rad; 0: none is stated");
  }
}

void CheckRotation(const ObservedRotation& rotation, const ItemName& item) {
  CheckSigmas(rotation.sigma, limits::kLeastRotationSigma, limits::kLargestRotationSigma, item);
  if (rotation.in_station.array().isNaN().any()) return;  // not measured
  CheckIsRotation(rotation.in_station, item, "its rotation");
}

void CheckObservation(const Measurements& data, size_t i, MarkerlessRows markerless) {
  const Observation& row = data.observations[i];
  const ItemName item("observation", i);
  CheckIndex(row.shot, data.shots.size(), item, "shot");
  const bool is_of_flange = markerless == MarkerlessRows::kAllowed && data.markers.empty() && row.marker < 0;
  if (!is_of_flange) CheckIndex(row.marker, data.markers.size(), item, "marker");
  if (row.file >= 0) {
    CheckIndex(row.file, data.files.size(), item, "file");
    CheckIndex(row.row, data.files[row.file].rows.size(), item, "row of its file");
  }
  if (row.partner >= 0 || !row.is_point()) CheckIndex(row.partner, data.observations.size(), item, "partner");
  CheckAreNumbersOrNaN(row.point_in_station, item, "a coordinate");
  CheckSigmas(row.sigma, limits::kLeastSigma, limits::kLargestSigma, item);
  if (!row.is_point()) CheckRotation(row.rotation(), item);
}

// Every observation is in the list of its shot, once.
void CheckListed(const Measurements& data) {
  std::vector<int> listed(data.observations.size(), 0);
  for (const Shot& shot : data.shots) {
    for (const int i : shot.observations) ++listed[i];
  }
  for (size_t i = 0; i < listed.size(); ++i) {
    if (listed[i] == 1) continue;
    FailStructure({"observation", i},
                  fmt::format("its shot {}: shot {}", listed[i] == 0 ? "does not list it" : "lists it more than once",
                              data.observations[i].shot),
                  "Shot::observations has each observation of the shot once");
  }
}

}  // namespace

void CheckStructure(const Robot& robot, const Measurements& data, MarkerlessRows markerless) {
  CheckRobotStructure(robot);
  if (data.observations.empty()) FailStructure("measurements", "there is no row");
  CheckNamesDiffer(data.markers, "markers");
  CheckNamesDiffer(data.stations, "stations");
  CheckConfigurations(data, robot.num_joints());
  for (size_t i = 0; i < data.observations.size(); ++i) CheckObservation(data, i, markerless);
  for (size_t s = 0; s < data.shots.size(); ++s) CheckShot(data, s, robot.num_joints());
  for (const Shot& shot : data.shots) CheckHeldJoints(robot.chain, data, shot);
  CheckListed(data);
}

}  // namespace sagitta
