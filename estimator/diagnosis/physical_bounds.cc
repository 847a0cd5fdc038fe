#include "estimator/diagnosis/physical_bounds.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "models/effects/catalogue.h"
#include "models/gravity_compensator.h"

namespace sagitta {
namespace {

using Kind = PhysicalBounds::Kind;

constexpr double kFarthestAnchor = 3.0;  // m, of a compensator's spring: two of kAnchorReach (compensator_shapes.cc)

// A spring within metres of the joint, with a rest length and a rate.
PhysicalBounds BoundsOfSpring(const std::vector<ParameterEstimate>& parameters) {
  for (const ParameterEstimate& row : parameters) {
    if (row.quantity == Quantity::kLength && std::abs(row.value) > kFarthestAnchor) return {Kind::kTooLarge};
    if (row.ci95.high < row.lower) return {Kind::kNegative};
  }
  return {};
}

// Of the robot file, rad/(N m), the least of a table: an effect adds to it.
double StatedCompliance(const Robot& robot, const std::string& joint) {
  for (const JointCompliance& own : robot.compliances) {
    if (robot.chain.joints[own.joint].name != joint || own.nodes.empty()) continue;
    const auto is_less = [](const auto& a, const auto& b) { return a.k < b.k; };
    return std::min_element(own.nodes.begin(), own.nodes.end(), is_less)->k;
  }
  return 0.0;
}

PhysicalBounds BoundsOfCompliance(double stated, const ParameterEstimate& k) {
  if (stated + k.ci95.high < 0.0) return {Kind::kNegative};
  return {stated > 0.0 ? Kind::kCorrection : Kind::kUsual, stated, stated + k.value, ""};
}

// kg, by label: force over gravity, mean over the shots.
std::map<std::string, double> StatedMasses(const CalibrationProblem& problem) {
  std::map<std::string, std::pair<double, int>> sums;
  for (const ShotInput& input : problem.shot_inputs()) {
    if (input.conditions.load_wrenches.empty()) continue;
    auto& [sum, count] = sums[input.conditions.load];
    sum += input.conditions.load_wrenches.front().force.norm() / input.conditions.gravity.norm();
    ++count;
  }
  std::map<std::string, double> masses;
  for (const auto& [load, sum] : sums) masses[load] = sum.first / sum.second;
  return masses;
}

// A load weighs m_a + d. With two masses exchanged that is the other's m_b; where compliances are estimated, too, only
// the ratio is known, (m_a + d) / m_b = m_b / m_a.
PhysicalBounds BoundsOfPayload(const CalibrationProblem& problem, const std::string& load,
                               const ParameterEstimate& off) {
  const std::map<std::string, double> masses = StatedMasses(problem);
  const auto own = masses.find(load);
  if (own == masses.end() || std::abs(off.value) <= own->second) return {};
  PhysicalBounds bounds{Kind::kMoreThanLoad, own->second, own->second + off.value, ""};
  const auto may_weigh = [&](double mass) {
    return own->second + off.ci95.low <= mass && mass <= own->second + off.ci95.high;
  };
  for (const auto& [other, mass] : masses) {
    if (other == load || !(may_weigh(mass) || may_weigh(mass * mass / own->second))) continue;
    bounds.kind = Kind::kLoadsExchanged;
    bounds.other = other;
  }
  return bounds;
}

// Whether d = -p, p the stated point of a load with moments: with moments about the flange it is counted twice.
bool CancelsItsPoint(const CalibrationProblem& problem, const std::string& load,
                     const std::vector<ParameterEstimate>& shift) {
  for (const ShotInput& input : problem.shot_inputs()) {
    if (input.conditions.load != load) continue;
    for (const AppliedWrench& wrench : input.conditions.load_wrenches) {
      if (wrench.moment.isZero() || wrench.point.isZero() || shift.size() != 3) continue;
      const auto holds = [&](int axis) {
        const Interval& interval = shift[static_cast<size_t>(axis)].ci95;
        return interval.low <= -wrench.point[axis] && -wrench.point[axis] <= interval.high;
      };
      return holds(0) && holds(1) && holds(2);
    }
  }
  return false;
}

// How much of a parameter moves the arm by 5 mm or 5 mrad; of an angle or a shift, which is a motion itself, its own.
double HoldLimit(const ParameterSet& parameters, const ParameterEstimate& row) {
  const bool is_motion = row.quantity == Quantity::kSmallAngle || row.quantity == Quantity::kShift;
  if (is_motion) return TraitsOf(row.quantity).hold_limit;
  const int coordinate = parameters.FindCoordinate(row.name);
  const double own = coordinate < 0 ? 0.0 : parameters.coordinates()[coordinate].hold_limit;
  return own > 0.0 ? own : TraitsOf(row.quantity).hold_limit;
}

}  // namespace

PhysicalBounds PhysicalBoundsOf(const DiagnosedModel& final, const EffectSpec& spec,
                                const std::vector<ParameterEstimate>& parameters) {
  const Robot& robot = final.problem->robot();
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition == nullptr) return BoundsOfSpring(parameters);
  if (parameters.empty()) return {};
  for (const ParameterEstimate& row : parameters) {
    const double limit = definition->largest * HoldLimit(final.estimate.parameters, row);
    if (std::abs(row.value) > limit) return {Kind::kTooLarge};
    for (const EffectParameter& own : definition->parameters(robot, spec)) {
      const bool is_it = row.name == spec.Path() + "/" + own.name;
      if (is_it && own.not_negative && row.ci95.high < 0.0) return {Kind::kNegative};
    }
  }
  if (definition == &JointComplianceEffect())
    return BoundsOfCompliance(StatedCompliance(robot, spec.target), parameters[0]);
  if (definition == &Payload()) return BoundsOfPayload(*final.problem, spec.target, parameters[0]);
  if (definition == &LoadCom() && CancelsItsPoint(*final.problem, spec.target, parameters))
    return {Kind::kAboutItsPoint};
  return {};
}

}  // namespace sagitta
