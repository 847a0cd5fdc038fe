#include "problems/io/robot_units.h"

#include <cmath>

#include "models/kinematics.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kLongestReach = 30.0;    // m
constexpr double kLongestTrack = 200.0;   // m
constexpr double kMostTurns = 8.0 * kPi;  // rad; wrists have up to 2.5 turns, limits in degrees are beyond 30
constexpr const char* kMetres = "lengths are in m here: 400 mm are 0.4";
constexpr const char* kRadians = "angles are in rad here: 90 deg are 1.5708";

void CheckLimit(const std::optional<double>& limit, const UrdfJoint& joint, const InputError::Where& where) {
  if (!limit) return;
  const bool slides = joint.type == UrdfJoint::Type::kPrismatic;
  if (std::abs(*limit) <= (slides ? kLongestTrack : kMostTurns)) return;
  throw InputError(where, "the joint has a limit of " + FormatNumber(*limit) + (slides ? " m" : " rad"),
                   slides ? "limits of joints that slide are in m"
                          : "limits of joints that turn are in rad: 120 deg are 2.0944; of more than four turns: "
                            "type continuous, with the limits in robot.yaml (joints:, min_deg, max_deg)");
}

}  // namespace

void CheckMetres(double value, const std::string& name, const InputError::Where& where) {
  if (std::abs(value) <= kLongestLink) return;
  throw InputError(where, name + " is " + FormatNumber(value) + " m, which no link is long", kMetres);
}

void CheckRadians(double value, const std::string& name, const InputError::Where& where) {
  if (std::abs(value) <= kFullTurn) return;
  throw InputError(where, name + " is " + FormatNumber(value) + " rad, more than a full turn", kRadians);
}

void CheckRowUnits(const DhLink& row, const InputError::Where& where) {
  CheckMetres(row.a, "a", where);
  CheckRadians(row.alpha, "alpha", where);
  CheckRadians(row.theta, "theta", where);
}

void CheckReach(double distance, const InputError::Where& where) {
  if (distance <= kLongestReach) return;
  throw InputError(where,
                   "with all joints at zero the flange is " + std::to_string(std::lround(distance)) +
                       " m from the first joint, which no robot reaches",
                   kMetres);
}

void CheckReach(const Chain& chain, const InputError::Where& where) {
  std::vector<double> values;
  for (const ElementaryTransform& transform : chain.transforms) values.push_back(transform.nominal);
  ChainState<double> state;
  EvaluateChain(chain, values.data(), &state);
  const Vector3<double> first = state.frames[chain.JointTransform(0)].translation;
  CheckReach((state.frames.back().translation - first).norm(), where);
}

void CheckTrack(double limit, const InputError::Where& where) {
  if (std::abs(limit) <= kLongestTrack) return;
  throw InputError(where, "the joint has a limit of " + FormatNumber(limit) + " m, which no track is long",
                   "state the unit of limits in the header: min [mm], max [mm]");
}

void CheckLimitUnits(const UrdfJoint& joint, const InputError::Where& where) {
  CheckLimit(joint.min, joint, where);
  CheckLimit(joint.max, joint, where);
}

}  // namespace sagitta
