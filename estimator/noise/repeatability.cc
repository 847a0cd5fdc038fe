#include "estimator/noise/repeatability.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "estimator/least_squares/linearization.h"
#include "models/row_block.h"

namespace sagitta {
namespace {

constexpr int kChoosingRounds = 3;  // afterwards one value or one per joint is not asked again, so that it ends
constexpr double kBlind = 0.05;     // of the largest lever: a value of its own would be anybody's noise
constexpr double kNothing = 1e-9;   // rad or m: a deviation that is none

bool IsPrismatic(const CalibrationProblem& problem, int joint) {
  return problem.robot().chain.joints[joint].type == JointType::kPrismatic;
}

// A joint that hardly moves any marker (a marker on the last axis) has the value of the joint before it.
void JoinBlindJoints(const CalibrationProblem& problem, const Eigen::VectorXd& levers,
                     std::vector<DeviationGroup>* groups) {
  for (size_t g = 1; g < groups->size(); ++g) {
    DeviationGroup& own = (*groups)[g];
    DeviationGroup& before = (*groups)[g - 1];
    if (!own.estimated || !before.estimated || levers[own.joints[0]] > kBlind * levers.maxCoeff()) continue;
    if (IsPrismatic(problem, own.joints[0]) != IsPrismatic(problem, before.joints[0])) continue;
    before.joints.insert(before.joints.end(), own.joints.begin(), own.joints.end());
    groups->erase(groups->begin() + static_cast<long>(g--));
  }
}

// Joints that are estimated together, by kind; stated ones have a group of their own.
std::vector<DeviationGroup> MakeGroups(const CalibrationProblem& problem, bool per_joint,
                                       const Eigen::VectorXd& levers) {
  const RepeatabilitySpec& spec = problem.experiment().repeatability;
  std::vector<DeviationGroup> groups;
  DeviationGroup kinds[2];
  for (int j = 0; j < problem.robot().num_joints(); ++j) {
    const Joint& joint = problem.robot().chain.joints[j];
    const RepeatabilitySpec::OfKind& kind = spec.Of(joint.type);
    const std::optional<double> stated = kind.StatedFor(joint.name);
    if (stated || !kind.estimate) {
      const double sigma = stated.value_or(0.0);
      groups.push_back({{j}, sigma * sigma, false});
    } else if (per_joint) {
      groups.push_back({{j}, 0.0, true});
    } else {
      kinds[IsPrismatic(problem, j)].joints.push_back(j);
    }
  }
  for (const DeviationGroup& kind : kinds) {
    if (!kind.joints.empty()) groups.push_back(kind);
  }
  if (per_joint) JoinBlindJoints(problem, levers, &groups);
  return groups;
}

int CountEstimated(const std::vector<DeviationGroup>& groups) {
  return static_cast<int>(
      std::count_if(groups.begin(), groups.end(), [](const DeviationGroup& g) { return g.estimated; }));
}

void SetVariances(const RemlFit& fit, std::vector<DeviationGroup>* groups) {
  const Eigen::VectorXd of_groups = fit.variances.tail(static_cast<Eigen::Index>(groups->size()));
  for (size_t g = 0; g < groups->size(); ++g) (*groups)[g].variance = of_groups[static_cast<Eigen::Index>(g)];
}

LatentModel LatentOf(const CalibrationProblem& problem, const std::vector<DeviationGroup>& groups) {
  LatentModel latent = problem.latent;
  std::vector<double> of_joint(problem.robot().num_joints(), 0.0);
  for (const DeviationGroup& group : groups) {
    for (const int j : group.joints) of_joint[j] = std::sqrt(group.variance);
  }
  latent.joints.clear();
  std::vector<double> sigmas;
  for (size_t j = 0; j < of_joint.size(); ++j) {
    if (of_joint[j] <= kNothing) continue;
    latent.joints.push_back(static_cast<int>(j));
    sigmas.push_back(of_joint[j]);
  }
  latent.sigmas = Eigen::Map<Eigen::VectorXd>(sigmas.data(), static_cast<Eigen::Index>(sigmas.size()));
  return latent;
}

double RelativeChange(double a, double b) {
  const double larger = std::max(a, b);
  return larger <= kNothing ? 0.0 : std::abs(a - b) / larger;
}

double ChangeOf(const LatentModel& before, const LatentModel& after, int joints) {
  const auto of_joint = [joints](const LatentModel& latent) {
    Eigen::VectorXd sigmas = Eigen::VectorXd::Zero(joints);
    for (int i = 0; i < latent.size(); ++i) sigmas[latent.joints[i]] = latent.sigmas[i];
    return sigmas;
  };
  const Eigen::VectorXd a = of_joint(before), b = of_joint(after);
  double change = 0.0;
  for (int j = 0; j < joints; ++j) change = std::max(change, RelativeChange(a[j], b[j]));
  return change;
}

std::string GroupName(const CalibrationProblem& problem, const DeviationGroup& group, bool per_joint) {
  if (group.joints.size() == 1 || per_joint) {
    std::string names;
    for (const int j : group.joints) names += (names.empty() ? "" : " and ") + problem.robot().chain.joints[j].name;
    return names;
  }
  return IsPrismatic(problem, group.joints[0]) ? "prismatic joints" : "joints";
}

VarianceComponent RepeatabilityComponent(const RestrictedLikelihood& reml, const RemlFit& fit,
                                         const RepeatabilityChoice& choice, int i) {
  VarianceComponent component;
  const int of_readings = reml.num_noises();
  component.of_rotations = i == 1 && of_readings == 2;
  component.estimated =
      i == 0 ? choice.estimate_instrument : component.of_rotations || choice.groups[i - of_readings].estimated;
  component.value = std::sqrt(fit.variances[i]);
  component.low = component.high = component.value;
  if (!component.estimated) return component;
  // sd(sigma) = sd(sigma^2) / (2 sigma).
  if (component.value > 0.0) component.sigma = std::sqrt(fit.covariance(i, i)) / (2.0 * component.value);
  reml.ProfileInterval(fit, choice.estimate_instrument, choice.groups, i, &component.low, &component.high);
  return component;
}

}  // namespace

void ScaleComponent(double factor, VarianceComponent* component) {
  for (double* number : {&component->value, &component->sigma, &component->low, &component->high}) *number *= factor;
}

namespace {

// RMS per coordinate of the calibration points: the instrument's reading, and what deviating joints move.
void MeasureShares(const CalibrationProblem& problem, const ParameterSet& parameters, NoiseReport* report) {
  const std::vector<int> rows = problem.data().PointsAmong(problem.CalibrationObservations());
  const NoiseRoots noise = ObservationNoise(problem, rows, kFallbackSigma);
  const Linearization raw = Linearize(problem, parameters, rows, {}, noise, LatentTreatment::kIgnore);
  double instrument = 0.0, robot = 0.0;
  for (size_t k = 0; k < rows.size(); ++k) {
    instrument += noise[k].squaredNorm();
    robot += (noise[k] * RowBlock(raw.latent, 3 * static_cast<Eigen::Index>(k), 3)).squaredNorm();
  }
  report->instrument_rms = std::sqrt(instrument / (3.0 * rows.size()));
  report->robot_rms = std::sqrt(robot / (3.0 * rows.size()));
}

}  // namespace

bool EstimatesComponents(const Experiment& experiment) {
  return experiment.repeatability.IsEstimated() || experiment.noise.from == NoiseSpec::From::kVarianceComponents;
}

double FindComponents(const CalibrationProblem& problem, const ParameterSet& parameters, bool sigma_is_stated,
                      int round, RepeatabilityChoice* choice) {
  choice->estimate_instrument =
      !sigma_is_stated || problem.experiment().noise.from == NoiseSpec::From::kVarianceComponents;
  const RestrictedLikelihood reml(problem, parameters, choice->rotations_apart);
  RemlFit fit;
  if (round < kChoosingRounds) {
    std::vector<DeviationGroup> common = MakeGroups(problem, false, reml.Levers());
    std::vector<DeviationGroup> separate = MakeGroups(problem, true, reml.Levers());
    const RemlFit common_fit = reml.Maximise(choice->estimate_instrument, common);
    SetVariances(common_fit, &common);
    fit = common_fit;
    choice->per_joint = false;
    choice->groups = common;
    const int more = CountEstimated(separate) - CountEstimated(common);
    if (more > 0) {
      for (DeviationGroup& group : separate) {  // from the common optimum
        for (const DeviationGroup& kind : common) {
          const bool is_in = std::find(kind.joints.begin(), kind.joints.end(), group.joints[0]) != kind.joints.end();
          if (is_in) group.variance = kind.variance;
        }
      }
      const RemlFit separate_fit = reml.Maximise(choice->estimate_instrument, separate);
      // Schwarz (1978): a component earns its place where 2 ln L grows by more than ln(dof).
      choice->gain = common_fit.deviance - separate_fit.deviance;
      choice->penalty = more * std::log(static_cast<double>(std::max(2, reml.dof())));
      if (choice->gain > choice->penalty) {
        choice->per_joint = true;
        choice->groups = separate;
        fit = separate_fit;
      }
    }
  } else {
    fit = reml.Maximise(choice->estimate_instrument, choice->groups);
  }
  SetVariances(fit, &choice->groups);
  const LatentModel latent = LatentOf(problem, choice->groups);
  const double instrument = std::sqrt(fit.variances[0]);
  const double rotation = std::sqrt(fit.variances[reml.num_noises() - 1]);
  const double change =
      std::max({ChangeOf(choice->latent, latent, problem.robot().num_joints()),
                RelativeChange(choice->instrument, instrument), RelativeChange(choice->rotation, rotation)});
  choice->latent = latent;
  choice->instrument = instrument;
  choice->rotation = rotation;
  return fit.converged ? change : 1.0;
}

void FinishComponents(const CalibrationProblem& problem, const ParameterSet& parameters, RepeatabilityChoice* choice,
                      NoiseReport* report) {
  const RestrictedLikelihood reml(problem, parameters, choice->rotations_apart);
  const RemlFit fit = reml.Maximise(choice->estimate_instrument, choice->groups);
  choice->interval_dof = reml.Satterthwaite(fit, choice->groups);
  report->per_joint = choice->per_joint;
  report->gain_per_joint = choice->gain;
  report->penalty = choice->penalty;
  report->components.clear();
  for (int i = 0; i < fit.variances.size(); ++i) {
    VarianceComponent component = RepeatabilityComponent(reml, fit, *choice, i);
    if (i < reml.num_noises()) {
      component.name = component.of_rotations ? "rotations" : "instrument";
      ScaleComponent(component.of_rotations ? choice->rotation : choice->instrument, &component);
    } else {
      const DeviationGroup& group = choice->groups[i - reml.num_noises()];
      component.name = GroupName(problem, group, choice->per_joint);
      component.joints = group.joints;
      component.is_prismatic = IsPrismatic(problem, group.joints[0]);
    }
    report->components.push_back(component);
  }
  MeasureShares(problem, parameters, report);
}

}  // namespace sagitta
