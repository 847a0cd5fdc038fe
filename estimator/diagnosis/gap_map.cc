#include "estimator/diagnosis/gap_map.h"

#include <algorithm>

#include "estimator/diagnosis/model_rows.h"

namespace sagitta {
namespace {

// Of l' l: too small a part to divide by, which would draw noise.
constexpr double kHardlySeen = 1e-3;  // of the shot that sees the joint best
constexpr double kUnseen = 1e-12;     // of the joint seen best: rounding

// Of one joint, per shot.
struct AlongJoint {
  Eigen::VectorXd information;  // l' l
  Eigen::VectorXd gradient;     // l' r
};

std::vector<AlongJoint> AlongJoints(const DiagnosedModel& model) {
  const CalibrationProblem& problem = *model.problem;
  const ParameterSet& parameters = model.estimate.parameters;
  // The rows as they are: what the joints of one visit share is part of what is looked for.
  const Linearization here = LinearizeEstimate(problem, parameters, LatentTreatment::kIgnore);
  const Eigen::MatrixXd columns = JointDeviationColumns(problem, parameters, LatentTreatment::kIgnore);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(static_cast<long>(problem.data().shots.size()));
  std::vector<AlongJoint> along(columns.cols(), {none, none});
  for (size_t k = 0; k < here.observations.size(); ++k) {
    const int shot = problem.data().observations[here.observations[k]].shot;
    const auto rows = Eigen::seqN(static_cast<long>(3 * k), 3);
    for (long j = 0; j < columns.cols(); ++j) {
      along[j].information[shot] += columns(rows, j).squaredNorm();
      along[j].gradient[shot] -= columns(rows, j).dot(here.residual(rows));  // residual: predicted - measured
    }
  }
  return along;
}

double BestInformation(const std::vector<AlongJoint>& along) {
  double best = 0.0;
  for (const AlongJoint& joint : along) best = std::max(best, joint.information.maxCoeff());
  return best;
}

std::vector<Driver> DriversOf(const CalibrationProblem& problem, int joint, const Eigen::MatrixXd& torques) {
  std::vector<Driver> drivers = {AngleOf(problem, joint), TorqueOf(problem, joint, torques), ApproachOf(problem, joint),
                                 TimeOf(problem)};
  const auto is_constant = [](const Driver& driver) { return !driver.Varies(); };
  drivers.erase(std::remove_if(drivers.begin(), drivers.end(), is_constant), drivers.end());
  return drivers;
}

}  // namespace

std::vector<JointGap> MapGap(const DiagnosedModel& baseline, const DiagnosedModel& final) {
  const CalibrationProblem& problem = *baseline.problem;
  const std::vector<AlongJoint> before = AlongJoints(baseline), after = AlongJoints(final);
  const Eigen::MatrixXd torques = JointTorques(problem, baseline.estimate.parameters);
  const double rounding = kUnseen * BestInformation(before);
  std::vector<JointGap> gaps;
  for (size_t j = 0; j < before.size(); ++j) {
    const Joint& joint = problem.robot().chain.joints[j];
    JointGap gap{joint.name, joint.type == JointType::kRevolute ? "urad" : "um", {}, {}, {}, {}};
    const double least = std::max(rounding, kHardlySeen * before[j].information.maxCoeff());
    for (long s = 0; s < before[j].information.size(); ++s) {
      const double information = before[j].information[s], later = after[j].information[s];
      if (!(information > least) || !(later > 0.0)) continue;
      gap.shots.push_back(static_cast<int>(s));
      gap.before.push_back(before[j].gradient[s] / information);
      gap.after.push_back(after[j].gradient[s] / later);
    }
    if (gap.shots.empty()) continue;
    gap.over = DriversOf(problem, static_cast<int>(j), torques);
    gaps.push_back(std::move(gap));
  }
  return gaps;
}

}  // namespace sagitta
