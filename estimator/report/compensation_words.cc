#include "estimator/report/compensation_words.h"

#include "models/constants.h"
#include "problems/text.h"

namespace sagitta {
namespace {

std::string Left(double position, double rotation) {
  return Significant(1e3 * position, 3) + " mm and " + Significant(1e3 * rotation, 3) + " mrad";
}

}  // namespace

std::string OrientationLeft(int joints, double rotation) {
  return "the position is met, the orientation as far as " + std::to_string(joints) +
         " joints can: " + Significant(1e3 * rotation, 3) + " mrad are left";
}

std::string LimitMadeUpFor(const std::string& joints) { return joints + " at the limit, the others make up for it"; }

std::string CloseToSingularity(bool is_met, double position, double rotation, double least_singular) {
  return (is_met ? "on target" : Left(position, rotation) + " are left") +
         ", close to a singularity (smallest singular value " + Significant(least_singular, 2) +
         "): small corrections need large joint motions there";
}

std::string WouldLeaveLimits(const std::string& joints, double position, double rotation) {
  return joints + " would leave the limits; the nearest pose within them is " + Left(position, rotation) + " off";
}

std::string OutOfReach(bool joints_are_given, double position, double rotation) {
  return std::string("no joint values ") + (joints_are_given ? "near those given " : "") +
         "reach it; the nearest pose is " + Left(position, rotation) + " off";
}

std::string TargetsAreAWay(const std::vector<std::string>& effects) {
  return Enumerate(effects) + (effects.size() == 1 ? " depends" : " depend") +
         " on the way to a target: they are corrected for being gone to in the order given (by time where all state "
         "one), "
         "straight from one to the next, the first as if nothing had been before it; on another way they are off by "
         "more "
         "than u95";
}

std::string TargetsHaveRotationVectors() {
  return "rx, ry, rz of the targets are read as a rotation vector, the axis times the angle; angles about one axis "
         "after "
         "the other have other columns: a_deg, b_deg, c_deg for A, B, C of a KUKA, roll_deg, pitch_deg, yaw_deg about "
         "fixed axes x, y, z";
}

std::string LoadFoldsArm() { return "the load folds the arm: no equilibrium of load and compliances was found"; }

std::string IterationUnsettled(double position, double rotation) {
  return "the iteration did not settle (a law that jumps, such as backlash by torque?); " + Left(position, rotation) +
         " are left";
}

std::string SolutionNotStated() {
  return "the file does not say with which joint solution it is reached, and no joint values come before it: "
         "--start_deg states where the arm is when the program starts";
}

std::string NoSolutionNearBefore() { return "no joint values near those before it reach it"; }

std::string NoSolutionNearStated() {
  return "no joint values near those that its inverse kinematics starts from reach it";
}

std::string StatedIsFarOff(double off) {
  return "the joint values that its inverse kinematics starts from are up to " + Significant(off / kDegree, 3) +
         " deg off the solution found: which one the controller chooses is not certain";
}

std::string TwoSolutionsMeant() {
  return "the program moves to it with more than one joint solution, each of which would need a correction of its own";
}

std::string SolutionsAreSeveral(size_t found) {
  return std::to_string(found) +
         " joint solutions are of the configuration that the file states; joint limits in the robot file would "
         "distinguish them";
}

std::string NoSolutionAsStated() {
  return "no joint values of the nominal robot reach it in the configuration that the file states";
}

std::string TurnsInWords() {
  return "a joint has made a whole turn, and which one the file does not say: --turn_joints=1,4,6 states it (the "
         "controller's $SCR_GRP[1].$TURN_AXIS), and joint limits in the robot file may determine it";
}

std::string PoseOutOfReach() { return "the nominal robot does not reach it; is its frame or tool another?"; }

std::string ControllersFlangeFacesTheArm() {
  return "as 'flange' is stated, the z axis of the controller's flange points back into the arm; those of controllers "
         "point away from it. Where the robot file ends in a frame that faces the arm, as tables of KUKA and FANUC do, "
         "flange=same is wrong: compare a pose that the controller shows with its joint values "
         "(flange=0,0,0,180,0,0 is half a turn about x, flange=0,0,0,0,180,0 about y)";
}

}  // namespace sagitta
