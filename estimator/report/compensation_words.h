// How a target was met, and why the joint solution that a pose of a program means is not known. Numbers come in SI.
#pragma once

#include <string>
#include <vector>

namespace sagitta {

// Of a target that is met but for what too few joints leave: rotation, rad.
std::string OrientationLeft(int joints, double rotation);
std::string LimitMadeUpFor(const std::string& joints);
// is_met: the position and the rotation are; else `position` (m) and `rotation` (rad) are left.
std::string CloseToSingularity(bool is_met, double position, double rotation, double least_singular);
std::string WouldLeaveLimits(const std::string& joints, double position, double rotation);
std::string OutOfReach(bool joints_are_given, double position, double rotation);
std::string LoadFoldsArm();
// Of effects with a memory.
std::string TargetsAreAWay(const std::vector<std::string>& effects);
// Of a list whose rx, ry, rz are in degrees: what they are read as, and which columns angles about axes have.
std::string TargetsHaveRotationVectors();
std::string IterationUnsettled(double position, double rotation);

// Why a pose of a program has no joint solution.
std::string SolutionNotStated();
std::string NoSolutionNearBefore();
std::string NoSolutionNearStated();      // near the joints that an inverse kinematics starts from
std::string StatedIsFarOff(double off);  // rad: of a joint
std::string TwoSolutionsMeant();
std::string SolutionsAreSeveral(size_t found);
std::string NoSolutionAsStated();
std::string TurnsInWords();  // poses whose whole turns may be of several joints
std::string PoseOutOfReach();
std::string ControllersFlangeFacesTheArm();  // by how it is stated

}  // namespace sagitta
