#include "estimator/report/inspection_reading_words.h"

#include "models/constants.h"
#include "problems/text.h"

namespace sagitta {
namespace {

const char* const kCheckOrder = "check the order of the columns q1, q2, … against that of the joints";

std::string InDegrees(double angle) { return Significant(angle / kDegree, 3) + " deg"; }

}  // namespace

Advice JointsFlipped(const std::vector<std::string>& joints) {
  const std::string names = Enumerate(joints);
  return {(joints.size() == 1 ? "joint " : "joints ") + names + " counted the other way",
          "state sign: -1 on the joint's transform (a chain), turn the sign of the q columns, or check "
          "the axis directions of the table: " +
              names};
}

Advice ZeroTurned(const std::string& joint, int quarters, bool is_flipped) {
  const std::string degrees = std::to_string(90 * quarters);
  return {
      "joint " + joint + " with its zero " + degrees + " deg away" + (is_flipped ? " and counted the other way" : ""),
      "add " + degrees + " deg to the joint's theta_deg or offset_deg" + (is_flipped ? ", and turn its sign" : "")};
}

Advice TableIn(DhConvention convention) {
  return {"the table as " + WordOf(convention) + " DH", "state convention: " + WordOf(convention)};
}

Advice TableOneRowOff() {
  return {"the table with a and alpha one row off",
          "check whether a and alpha belong to the joint's own row or the next"};
}

Advice BetaTurned() { return {"Hayati's beta of the other sign", "check the sign of beta_deg"}; }

Advice AlphaTurned(const std::string& joint) {
  return {"alpha of joint " + joint + " of the other sign", "check the sign of alpha_deg in the row of " + joint};
}

Advice ColumnsExchanged(const std::string& one, const std::string& other) {
  return {"the columns of joints " + one + " and " + other + " exchanged", kCheckOrder};
}

Advice ColumnsInCyclicOrder(const std::vector<std::string>& joints) {
  return {"the columns of joints " + Enumerate(joints) + " in cyclic order", kCheckOrder};
}

Advice ColumnsReversed() { return {"the joint columns in reverse order", kCheckOrder}; }

Advice ColumnsBeginWith(const std::string& first) {
  return {"the joint columns beginning with joint " + first, kCheckOrder};
}

Advice JointCoupled(const std::string& joint, const std::string& driver, int ratio) {
  return {"joint " + joint + " coupled to " + driver + " by " + std::to_string(ratio),
          "state coupling: [{joint: " + joint + ", driver: " + driver + ", ratio: " + std::to_string(ratio) +
              "}] in the robot file"};
}

Advice FrameMirrored() {
  return {"the measurement frame as a mirrored (left-handed) one",
          "the measured points are in a left-handed frame: turn the sign of one of x, y, z, or exchange "
          "two of them"};
}

Advice RobotReadIn(RobotNumbers unit) {
  switch (unit) {
    case RobotNumbers::kMetres:
      return {"the robot's lengths as metres", "the robot file's lengths are in m: write _m"};
    case RobotNumbers::kMillimetres:
      return {"the robot's lengths as millimetres",
              "the robot file's lengths are in mm: write _mm; a URDF states them in m, 1000 times smaller numbers"};
    case RobotNumbers::kInches:
      return {"the robot's lengths as inches", "convert the robot file's lengths to mm"};
    case RobotNumbers::kRadians:
      return {"the robot's angles as radians", "the robot file's angles are in rad: write _rad"};
  }
  return {};
}

Advice PointsInInches() { return {"the measured points as inches", "convert x, y, z to mm"}; }

Advice JointInRadians(const std::string& joint) {
  return {"joint " + joint + " alone in radians", "convert the column of " + joint + " to degrees"};
}

Advice LinearJointsIn(bool metres, const std::vector<int>& joints) {
  const std::string unit = metres ? "metres" : "millimetres";
  std::vector<std::string> names;
  for (const int joint : joints) names.push_back("q" + std::to_string(joint + 1) + (metres ? "_m" : "_mm"));
  return {"the values of the linear joints as " + unit,
          "their columns are in " + unit + ": name them so (" + Enumerate(names, 4) + ")"};
}

Advice RowsShifted(bool is_after) {
  return {std::string("every point read as that of the configuration ") + (is_after ? "after" : "before") + " its own",
          "joint values and points are one row apart: shift one of them"};
}

Advice RotationsMiss(const RotationsAsStated& stated, const std::vector<std::string>& fitting, double misfit) {
  const std::string columns = Enumerate(stated.columns);
  const std::string words = "the points fit within " + InMillimetres(stated.points) +
                            " (RMS), the rotations do not: " + columns + " read as " + stated.reading + " miss by " +
                            InDegrees(stated.misfit) + " (RMS)";
  if (fitting.empty()) {
    return {words + ", and no other kind of rotation, unit or direction fits (the best by " + InDegrees(misfit) + ")",
            "check what " + columns +
                " mean, and the signs of joints that turn the target and hardly move it, as the last one may"};
  }
  std::string others = fitting.front() + " by " + InDegrees(misfit);
  for (size_t k = 1; k < fitting.size(); ++k) others += (k == 1 ? ", and as well as " : " and ") + fitting[k];
  return {words + ", as " + others,
          "write the rotation of the target in the measurement frame as a rotation vector (rx_mrad, ry_mrad, rz_mrad) "
          "or as a quaternion, scalar first (ow, ox, oy, oz); 'sagitta import' converts foreign tables"};
}

}  // namespace sagitta
