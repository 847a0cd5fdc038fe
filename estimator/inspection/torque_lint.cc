#include "estimator/inspection/torque_lint.h"

#include <algorithm>
#include <cmath>

#include "estimator/report/inspection_words.h"
#include "estimator/statistics/distributions.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Correlations that are words: 0.5 explains a quarter of the variance, less is no agreement worth a name.
constexpr double kAgrees = 0.5;
// A slope further than that from 1 is no calibration error of a torque sensor (some per cent).
constexpr double kSlopeError = 0.2;

// One row per shot that states torques, one column per joint.
struct TorqueTable {
  Eigen::MatrixXd measured, modelled;
};

TorqueTable CollectTorques(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const int joints = problem.robot().num_joints();
  const std::vector<double> theta = parameters.ModelValues();
  TorqueTable table{Eigen::MatrixXd(problem.data().shots.size(), joints), Eigen::MatrixXd()};
  table.modelled = table.measured;
  long rows = 0;
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    const Shot& shot = problem.data().shots[s];
    if (shot.joint_torques.size() != joints) continue;
    const Eigen::VectorXd modelled = problem.model().ModelledJointTorques(
        problem.shot_inputs()[s], theta.data(), parameters.BaseInStation(shot.station).rotation);
    if (modelled.size() != joints) continue;
    table.measured.row(rows) = shot.joint_torques.transpose();
    table.modelled.row(rows++) = modelled.transpose();
  }
  table.measured.conservativeResize(rows, Eigen::NoChange);
  table.modelled.conservativeResize(rows, Eigen::NoChange);
  return table;
}

double Rms(const Eigen::VectorXd& values) { return std::sqrt(values.squaredNorm() / std::max<long>(values.size(), 1)); }

JointTorqueComparison CompareTorquesOfJoint(int joint, const Eigen::VectorXd& measured,
                                            const Eigen::VectorXd& modelled) {
  JointTorqueComparison line;
  line.joint = joint;
  line.shots = static_cast<int>(measured.size());
  line.measured_rms = Rms(measured);
  line.modelled_rms = Rms(modelled);
  line.difference_rms = Rms(measured - modelled);
  const Eigen::VectorXd x = modelled.array() - modelled.mean();
  const Eigen::VectorXd y = measured.array() - measured.mean();
  // What does not vary beyond rounding has no slope; 1e-9 N m is rounding for every arm.
  line.varies = x.norm() > 1e-9 * std::max(modelled.norm(), 1.0);
  if (!line.varies || y.norm() <= 1e-9 * measured.norm()) return line;
  line.slope = x.dot(y) / x.squaredNorm();
  line.offset = measured.mean() - line.slope * modelled.mean();
  line.correlation = x.dot(y) / (x.norm() * y.norm());
  const double left = std::max(0.0, y.squaredNorm() - line.slope * x.dot(y));
  line.slope_sigma = std::sqrt(left / std::max<long>(1, x.size() - 2)) / x.norm();
  return line;
}

std::string InWords(const CalibrationProblem& problem, const TorqueComparison& comparison) {
  TorqueGroups joints;
  for (const JointTorqueComparison& line : comparison.joints) {
    const std::string& name = problem.robot().chain.joints[line.joint].name;
    if (!line.varies) {
      joints.untold.push_back(name);
    } else if (line.correlation < -kAgrees) {
      joints.opposite.push_back(name);
    } else if (line.correlation < kAgrees) {
      joints.differ.push_back(name);
    } else if (std::abs(line.slope - 1.0) > kSlopeError) {
      joints.scaled.push_back(name + " (measured = " + Significant(line.slope, 2) + " x modelled)");
    } else {
      joints.agree.push_back(name);
    }
  }
  return TorquesInWords(comparison.measured_count, joints);
}

}  // namespace

std::vector<ScaledTorque> TorquesOffByAFactor(const TorqueComparison& comparison, double significance) {
  const double tail = 0.5 * significance / std::max<size_t>(1, comparison.joints.size());
  std::vector<ScaledTorque> off;
  for (const JointTorqueComparison& line : comparison.joints) {
    if (!line.varies || line.correlation < kAgrees || line.shots < 3) continue;
    const double least = std::abs(line.slope - 1.0) - StudentQuantile(1.0 - tail, line.shots - 2) * line.slope_sigma;
    if (least > kSlopeError) off.push_back({line.joint, line.slope});
  }
  const auto away = [](const ScaledTorque& torque) { return std::abs(std::log(torque.slope)); };
  std::stable_sort(off.begin(), off.end(), [&](const auto& a, const auto& b) { return away(a) > away(b); });
  return off;
}

TorqueComparison CompareTorques(const CalibrationProblem& problem, const ParameterSet& parameters) {
  TorqueComparison comparison;
  comparison.measured_count = problem.experiment().torques_measured;
  const TorqueTable table = CollectTorques(problem, parameters);
  if (table.measured.rows() == 0) return comparison;
  for (int j = 0; j < problem.robot().num_joints(); ++j) {
    comparison.joints.push_back(CompareTorquesOfJoint(j, table.measured.col(j), table.modelled.col(j)));
  }
  comparison.words = InWords(problem, comparison);
  return comparison;
}

}  // namespace sagitta
