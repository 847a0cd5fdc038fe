#include "estimator/results/measured_joints.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "estimator/inspection/data_lint.h"
#include "models/constants.h"
#include "problems/io/units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Of n poses drawn from a range of width w the next one lies outside by more than 3 w / n with probability
// exp(-3) / n: a tenth of the range for the 30 poses that a calibration has at least.
constexpr double kMargin = 0.1;                // of the range
constexpr double kLeastAngle = 1.0 * kDegree;  // a joint that covers less has not moved
constexpr double kLeastLength = 1e-3;          // m, prismatic

double Outside(const Joint& joint, const MeasuredInterval& range, double q) {
  return OutsideBy(range, q, joint.type == JointType::kRevolute ? kLeastAngle : kLeastLength);
}

std::string NamedBy(const Joint& joint, double by) {
  const JointUnit unit = UnitOf(joint);
  return joint.name + " by " + Significant(by * unit.factor, 2) + " " + unit.name;
}

}  // namespace

double OutsideBy(const MeasuredInterval& range, double value, double least) {
  const double by = std::max(range.least - value, value - range.most);
  return by > std::max(least, kMargin * (range.most - range.least)) ? by : 0.0;
}

nlohmann::ordered_json MeasuredJointsToJson(const CalibrationProblem& problem) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const MeasuredRange& range : MeasuredRangesOf(problem)) {
    const Joint& joint = problem.robot().chain.joints[static_cast<size_t>(range.joint)];
    const JointUnit unit = UnitOf(joint);
    list.push_back({{"joint", joint.name},
                    {std::string("min_") + unit.name, range.least * unit.factor},
                    {std::string("max_") + unit.name, range.most * unit.factor}});
  }
  return list;
}

std::vector<MeasuredInterval> MeasuredJointsFrom(const JsonValue& list, const Chain& chain) {
  std::vector<MeasuredInterval> ranges;
  for (const JsonValue& entry : list.Items()) {
    const JsonValue name = entry.Get("joint");
    if (ranges.size() >= chain.joints.size() || name.Text() != chain.joints[ranges.size()].name) {
      name.Fail("the robot's joints are expected, in their order");
    }
    const JointUnit unit = UnitOf(chain.joints[ranges.size()]);
    ranges.push_back({entry.Get(std::string("min_") + unit.name).Number() / unit.factor,
                      entry.Get(std::string("max_") + unit.name).Number() / unit.factor});
  }
  if (ranges.size() != chain.joints.size())
    list.Fail("the robot has " + std::to_string(chain.joints.size()) + " joints");
  return ranges;
}

std::vector<std::string> OutsideMeasured(const KnownRobot& known, const Eigen::VectorXd& q) {
  std::vector<std::string> joints;
  for (size_t j = 0; j < known.measured_joints.size() && static_cast<Eigen::Index>(j) < q.size(); ++j) {
    const Joint& joint = known.robot.chain.joints[j];
    const double by = Outside(joint, known.measured_joints[j], q[static_cast<Eigen::Index>(j)]);
    if (by > 0.0) joints.push_back(NamedBy(joint, by));
  }
  return joints;
}

std::string OutsideMeasuredInWords(const KnownRobot& known, const std::vector<Configuration>& configurations) {
  size_t outside = 0;
  std::vector<double> most(known.measured_joints.size(), 0.0);
  for (const Configuration& configuration : configurations) {
    if (OutsideMeasured(known, configuration.q).empty()) continue;
    ++outside;
    for (size_t j = 0; j < most.size(); ++j) {
      const double q = configuration.q[static_cast<Eigen::Index>(j)];
      most[j] = std::max(most[j], Outside(known.robot.chain.joints[j], known.measured_joints[j], q));
    }
  }
  if (outside == 0) return "";
  std::vector<std::string> joints;
  for (size_t j = 0; j < most.size(); ++j) {
    if (most[j] > 0.0) joints.push_back(NamedBy(known.robot.chain.joints[j], most[j]));
  }
  return PosesOutsideMeasured(outside, configurations.size(), joints);
}

size_t AddOutsideMeasured(const KnownRobot& known, std::vector<CompensatedTarget>* results) {
  size_t outside = 0;
  for (CompensatedTarget& result : *results) {
    const std::vector<std::string> joints = OutsideMeasured(known, result.solution.q);
    if (joints.empty()) continue;
    ++outside;
    result.words += (result.words.empty() ? "" : "; ") + TargetOutsideMeasured(joints);
  }
  return outside;
}

}  // namespace sagitta
