#include "estimator/diagnosis/effect_view.h"

#include <algorithm>
#include <map>

#include "estimator/diagnosis/drivers.h"
#include "estimator/diagnosis/model_rows.h"
#include "estimator/diagnosis/refit.h"
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

// The joint that a setting names, or else the target.
std::string DrivingJoint(const EffectDefinition& definition, const EffectSpec& spec) {
  for (const SettingDefinition& setting : definition.settings) {
    if (setting.kind == SettingDefinition::Kind::kJoint) return spec.TextSetting(setting.name, spec.target);
  }
  return spec.target;
}

Driver DriverOf(const CalibrationProblem& problem, const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(problem.robot(), spec.effect);  // none of the compensator
  const EffectDriver by = definition == nullptr ? EffectDriver::kJoint : definition->driven_by;
  if (by == EffectDriver::kTemperature) return TemperatureOf(problem);
  if (by == EffectDriver::kTime) return TimeOf(problem);
  const std::string name = definition == nullptr ? spec.target : DrivingJoint(*definition, spec);
  const int joint = problem.robot().chain.FindJoint(name);
  return joint >= 0 ? AngleOf(problem, joint) : ConfigurationNumberOf(problem);
}

// The effect's contribution to the whitened rows: its columns times its values (neutral: 0). The torque of a
// compensator is proportional to its rate.
Eigen::VectorXd Contribution(const DiagnosedModel& with, const EffectSpec& spec, const Linearization& here) {
  const bool spring = IsGravityCompensator(spec);
  Eigen::VectorXd contribution = Eigen::VectorXd::Zero(here.num_rows());
  for (int c = 0; c < here.num_columns(); ++c) {
    const Coordinate& coordinate = with.estimate.parameters.coordinates()[here.columns[c]];
    if (!IsParameterOf(spec, coordinate.name)) continue;
    if (spring && coordinate.compensator_part != CompensatorPart::kKc) continue;
    contribution += here.jacobian.col(c) * with.estimate.parameters.Value(here.columns[c]);
  }
  return contribution;
}

struct VisitSums {
  double squared = 0.0, measured = 0.0, simulated = 0.0, x = 0.0;
};

// deviations: columns of each joint.
EffectView ViewEffect(const DiagnosedModel& with, const Linearization& here, const Eigen::MatrixXd& deviations,
                      const EffectSpec& spec) {
  const CalibrationProblem& problem = *with.problem;
  const Eigen::VectorXd contribution = Contribution(with, spec, here);
  const Driver driver = DriverOf(problem, spec);
  EffectView view{driver.name, driver.unit, "share of what was found", "", {}, {}, {}};
  Eigen::VectorXd along = contribution;
  const int joint = problem.robot().chain.FindJoint(spec.target);
  if (joint >= 0) {
    const bool turns = IsRevolute(problem, joint);
    along = deviations.col(joint);
    view.quantity = "deviation of " + spec.target;
    view.unit = turns ? "urad" : "um";
  }
  // Residuals are predicted - measured: without the effect they would be lower by its contribution.
  std::map<int, VisitSums> visits;
  for (size_t k = 0; k < here.observations.size(); ++k) {
    const int s = problem.data().observations[here.observations[k]].shot;
    VisitSums& sums = visits[problem.latent.visit_of_shot[s]];
    const auto rows = Eigen::seqN(static_cast<long>(3 * k), 3);
    sums.x = driver.of_shot[s];
    sums.squared += along(rows).squaredNorm();
    sums.simulated += along(rows).dot(contribution(rows));
    sums.measured += along(rows).dot(contribution(rows) - here.residual(rows));
  }
  double largest = 0.0;
  for (const auto& [visit, sums] : visits) largest = std::max(largest, sums.squared);
  for (const auto& [visit, sums] : visits) {
    if (sums.squared < 1e-3 * largest) continue;  // hardly seen in this visit
    view.x.push_back(sums.x);
    view.measured.push_back(sums.measured / sums.squared);
    view.simulated.push_back(sums.simulated / sums.squared);
  }
  return view;
}

}  // namespace

std::vector<EffectView> ViewEffects(const DiagnosedModel& with, const std::vector<EffectSpec>& specs) {
  std::vector<EffectView> views;
  if (specs.empty()) return views;
  const Linearization here = LinearizeEstimate(*with.problem, with.estimate.parameters);
  const Eigen::MatrixXd deviations = JointDeviationColumns(*with.problem, with.estimate.parameters);
  for (const EffectSpec& spec : specs) views.push_back(ViewEffect(with, here, deviations, spec));
  return views;
}

}  // namespace sagitta
