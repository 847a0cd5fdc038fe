#include "estimator/diagnosis/cautions.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <set>

#include "estimator/agreement/breaks.h"
#include "estimator/calibration/coupled_joints.h"
#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/diagnosis/gap.h"
#include "estimator/diagnosis/noise_check.h"
#include "estimator/diagnosis/outlier_rules.h"
#include "estimator/diagnosis/stated_effects.h"
#include "estimator/diagnosis/unstated_rows.h"
#include "estimator/explanations/drivers.h"
#include "estimator/inspection/load_lint.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/report/diagnosis_caution_words.h"
#include "estimator/report/validation_words.h"
#include "estimator/validation/prior_conflict.h"
#include "estimator/validation/suspects.h"
#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "models/steel.h"
#include "problems/split.h"

namespace sagitta {
namespace {

// rad: a joint that moves less is assumed to stand. What goes with its angle, 75 urad and three times as much
// (learnt_deviation.h), changes by a twelfth of that: at 2 m by 0.01 to 0.04 mm, as much as readings scatter.
constexpr double kStandingJoint = 5.0 * kDegree;
constexpr double kStandingSlide = 0.05;  // m, prismatic: as far as 5 deg move what is 0.6 m away
constexpr int kFewConfigurations = 15;   // with three markers 135 equations, for some fifty parameters
constexpr double kInOrder = 0.9;         // rank correlation: of 15 values in random order one in 80 000 has more
constexpr double kFarBelowFloor = 3.1;   // standard deviations, one in a thousand

// Configurations with equal joint values count once.
struct Counts {
  int fitted = 0;
  int held_out = 0;
  int in_both = 0;
};

Counts CountConfigurations(const Measurements& data) {
  Counts counts;
  for (const std::vector<int>& group : GroupsOfEqualJointValues(data)) {
    bool fitted = false, held_out = false;
    for (const int c : group) (data.configurations[c].is_validation ? held_out : fitted) = true;
    counts.fitted += fitted;
    counts.held_out += held_out;
    counts.in_both += fitted && held_out;
  }
  return counts;
}

// Joints that hardly move over the fitted configurations.
std::vector<std::string> StandingJoints(const CalibrationProblem& problem) {
  std::vector<std::string> standing;
  for (int j = 0; j < problem.robot().num_joints(); ++j) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Configuration& configuration : problem.data().configurations) {
      if (configuration.is_validation) continue;
      low = std::min(low, configuration.q[j]);
      high = std::max(high, configuration.q[j]);
    }
    const double least = IsRevolute(problem, j) ? kStandingJoint : kStandingSlide;
    if (high - low < least) standing.push_back(problem.robot().chain.joints[j].name);
  }
  return standing;
}

// Each of the following is "" where nothing is to be said.

// Of a problem that asks for components it is known.
std::string OfNoise(const CalibrationProblem& problem) {
  const bool is_asked = problem.experiment().noise.from == NoiseSpec::From::kVarianceComponents;
  return problem.sigma_is_stated() || is_asked ? "" : NoNoiseIsStated(RowsShareVisits(problem));
}

// The search compares chi-squares of one least-squares model: other ways to weigh the rows are not used.
std::string OfUnusedKeys(const Experiment& experiment) {
  std::vector<std::string> keys;
  if (experiment.method.loss != LossKind::kNone) keys.push_back("loss: " + WordOf(experiment.method.loss));
  if (experiment.method.weights != Weights::kSigma) keys.push_back("weights: " + WordOf(experiment.method.weights));
  const bool is_judged = experiment.method.covariance == CovarianceKind::kModel ||
                         experiment.method.covariance == CovarianceKind::kSandwich;
  if (!is_judged) keys.push_back("covariance: " + WordOf(experiment.method.covariance));
  if (experiment.noise.from == NoiseSpec::From::kResiduals) keys.push_back("noise from residuals");
  return keys.empty() ? "" : MethodKeysUnused(keys);
}

std::string OfFew(const CalibrationProblem& problem, const Counts& counts) {
  const int unknowns = static_cast<int>(problem.parameters.EstimatedCoordinates().size());
  const int rows = 3 * static_cast<int>(problem.CalibrationObservations().size());
  const bool are_enough = counts.fitted >= kFewConfigurations && rows >= 2 * unknowns;
  return are_enough ? "" : FewAreFitted(counts.fitted, rows, unknowns);
}

std::string OfStandingJoints(const CalibrationProblem& problem) {
  const std::vector<std::string> standing = StandingJoints(problem);
  const bool all = static_cast<int>(standing.size()) == problem.robot().num_joints();
  return standing.empty() ? "" : JointsStandStill(standing, all);
}

// An effect acts in every shot or is not looked for: where more than a few cells are empty, the column is silent.
std::string OfPartlyStated(const CalibrationProblem& problem) {
  const Measurements& data = problem.data();
  std::vector<std::string> partly;
  for (const DrivingColumn& column : DrivingColumns(problem.robot().num_joints())) {
    const auto stating = std::count_if(problem.shot_inputs().begin(), problem.shot_inputs().end(),
                                       [&](const ShotInput& shot) { return column.is_stated(shot.conditions); });
    if (stating == 0 || stating == static_cast<long>(problem.shot_inputs().size())) continue;
    const auto empty = std::count_if(data.observations.begin(), data.observations.end(), [&](const Observation& row) {
      return row.is_point() && data.Cell(row, column.name).empty();
    });
    partly.push_back(PartlyStated(column.name, empty, data.NumRows()));
  }
  return partly.empty() ? "" : ColumnsArePartlyStated(partly);
}

std::string OfHeldParameters(const Estimate& estimate) {
  if (estimate.identifiability.unidentifiable.empty()) return "";
  std::vector<std::string> held;
  for (const Coordinate& coordinate : estimate.parameters.coordinates()) {
    if (coordinate.held) held.push_back(coordinate.name);
  }
  return ParametersAreHeld(held);
}

// What the robot file states and the experiment holds is neither estimated nor a candidate.
std::string OfHeldEffects(const CalibrationProblem& problem) {
  std::vector<std::string> held;
  for (const EffectSpec& spec : HeldEffects(problem)) held.push_back(spec.Path());
  return held.empty() ? "" : EffectsAreHeld(held);
}

std::string OfHoldout(const Counts& counts) {
  if (counts.held_out == 0) return NothingHeldOut();
  return counts.held_out < kFewHeldOut ? FewHeldOut(counts.held_out) : "";
}

// A tool that moved on the flange halfway is no effect of the robot: of what moves the catalogue has single markers,
// stations and joints.
std::string OfTool(const DiagnosedModel& believed) {
  const std::optional<Break> moved = FindBreak(*believed.problem, believed.estimate);
  const bool is_tool = moved && moved->of == BreakOf::kTool;
  return is_tool ? ToolMoved(SomethingMoved(*believed.problem, *moved)) : "";
}

// Spearman's correlation of a joint's values with their order: of ranks, equal values having the mean of theirs.
double CorrelationWithOrder(const Eigen::VectorXd& values) {
  const long n = values.size();
  std::vector<int> order(static_cast<size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return values[a] < values[b]; });
  Eigen::VectorXd ranks(n);
  for (long first = 0, end = 0; first < n; first = end) {
    while (end < n && values[order[end]] == values[order[first]]) ++end;
    for (long k = first; k < end; ++k) ranks[order[k]] = 0.5 * static_cast<double>(first + end - 1);
  }
  const Eigen::ArrayXd centred = ranks.array() - 0.5 * static_cast<double>(n - 1);
  const Eigen::ArrayXd place =
      Eigen::ArrayXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) - 0.5 * static_cast<double>(n - 1);
  return (centred * place).sum() / std::sqrt(std::max(1e-300, centred.square().sum() * place.square().sum()));
}

// Without a clock nothing distinguishes a drift from an error of a joint that moved one way all the time.
std::string OfOrder(const CalibrationProblem& problem) {
  const Measurements& data = problem.data();
  const bool any_time =
      std::any_of(data.shots.begin(), data.shots.end(), [](const Shot& shot) { return shot.has_time; });
  if (any_time || data.configurations.size() < kFewConfigurations) return "";
  const std::vector<std::string> standing = StandingJoints(problem);
  std::vector<std::string> in_order;
  for (int j = 0; j < problem.robot().num_joints(); ++j) {
    const std::string& name = problem.robot().chain.joints[j].name;
    Eigen::VectorXd values(static_cast<long>(data.configurations.size()));
    for (long c = 0; c < values.size(); ++c) values[c] = data.configurations[static_cast<size_t>(c)].q[j];
    const bool is_still = std::find(standing.begin(), standing.end(), name) != standing.end();
    if (!is_still && std::abs(CorrelationWithOrder(values)) > kInOrder) in_order.push_back(name);
  }
  return in_order.empty() ? "" : JointsFollowTheOrder(in_order);
}

// Where the believed model is as far off as no arm is: rows that cannot be what they say, which the search would
// explain.
std::string OfSuspects(const DiagnosedModel& believed) {
  if (believed.estimate.fit.distance_rms <= SuspiciousMisfit(*believed.problem)) return "";
  const std::vector<Suspect> suspects = FindSuspects(*believed.problem, believed.estimate);
  if (suspects.empty()) return "";
  return LookAtSuspectsFirst(RowsAreSuspect(suspects.size(), suspects[0].row + ": " + suspects[0].words));
}

// A prior that is contradicted is fitted by the rows as far as it is narrow: what that leaves looks like an effect.
std::string OfPriors(const CalibrationProblem& problem, const Estimate& estimate) {
  const std::vector<PriorConflict> priors = PriorsAgainstRows(problem, estimate);
  return priors.empty() ? "" : PriorsFirst(RowsContradictPrior(estimate.parameters, priors[0], priors.size()));
}

void CautionOfAFew(const DiagnosedModel& final, double significance, std::vector<std::string>* cautions) {
  const Measurements& data = final.problem->data();
  std::vector<std::string> names;
  for (const int i : RowsOfTheWorst(*final.problem, final.estimate.parameters, significance)) {
    const std::string& name = data.ConfigurationOf(data.observations[i]).id;
    if (names.empty() || names.back() != name) names.push_back(name);
  }
  if (!names.empty()) cautions->push_back(MostIsOf(names));
}

bool IsCompliance(const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(spec.effect);
  return definition == &JointComplianceEffect() || definition == &TransverseCompliance() ||
         definition == &BaseCompliance();
}

// An arm that is warmer is longer by one share of its place in the base, a reading of the station by one share of that
// in the station: the base is moved by the difference, and that is estimated.
void CautionOfTemperature(const CalibrationProblem& problem, const std::vector<FoundEffect>& effects,
                          std::vector<std::string>* cautions) {
  const std::vector<ShotInput>& shots = problem.shot_inputs();
  const auto is_known = [](const ShotInput& shot) { return shot.conditions.has_temperature; };
  if (std::any_of(shots.begin(), shots.end(), is_known)) return;
  for (const FoundEffect& effect : effects) {
    if (!IsUseOf(StationScale(), effect.candidate.spec) || effect.parameters.empty()) continue;
    cautions->push_back(ScaleMayBeWarmth(effect.candidate.spec, effect.parameters[0].value / kSteelPerKelvin));
  }
}

void CautionOfOneLoad(const CalibrationProblem& problem, const std::vector<FoundEffect>& effects,
                      std::vector<std::string>* cautions) {
  if (problem.experiment().torques_measured) return;  // those of the links are in them
  std::set<std::string> loads;
  for (const int i : problem.CalibrationObservations()) {
    loads.insert(problem.data().shots[problem.data().observations[i].shot].load);
  }
  std::vector<EffectSpec> bent;
  for (const FoundEffect& effect : effects) {
    if (IsCompliance(effect.candidate.spec)) bent.push_back(effect.candidate.spec);
  }
  if (loads.size() == 1 && !bent.empty()) cautions->push_back(LinksBendToo(bent));
}

}  // namespace

std::vector<std::string> CautionsOfReadings(const CalibrationProblem& problem) {
  std::vector<std::string> cautions;
  for (const std::vector<Finding>& findings : {LintReadingsOfGoodRows(problem).findings, LintDeflections(problem)}) {
    for (const Finding& finding : findings) {
      if (finding.severity != Severity::kSerious) continue;
      cautions.push_back(LookAtThisFirst(finding));
    }
  }
  return cautions;
}

std::vector<std::string> FindCautions(const CalibrationProblem& stated, const DiagnosedModel& believed) {
  const Counts counts = CountConfigurations(stated.data());
  std::vector<std::string> cautions = {
      OfSuspects(believed),   OfPriors(stated, believed.estimate),
      OfNoise(stated),        OfUnusedKeys(stated.experiment()),
      OfFew(stated, counts),  OfStandingJoints(stated),
      OfPartlyStated(stated), OfHeldParameters(believed.estimate),
      OfHeldEffects(stated),  counts.in_both > 0 ? FittedAndHeldOut(counts.in_both) : "",
      OfHoldout(counts),      OfTool(believed),
      OfOrder(stated),
  };
  cautions.erase(std::remove(cautions.begin(), cautions.end(), ""), cautions.end());
  for (const std::string& coupled : WarningsOfCouplings(stated, true)) cautions.push_back(coupled + ".");
  return cautions;
}

void CautionOfStatedEffects(const DiagnosedModel& lacking, const JointOptions& options,
                            std::vector<FoundEffect>* effects, std::vector<std::string>* cautions) {
  std::vector<Candidate> found;
  for (const FoundEffect& effect : *effects) found.push_back(effect.candidate);
  for (size_t k = 0; k < found.size(); ++k) {
    (*effects)[k].stated_instead = StatedInPlaceOf(lacking, found, k, options);
    for (const EffectSpec& stated : (*effects)[k].stated_instead) {
      cautions->push_back(StatedOneDoesAsWell(found[k].spec, stated));
    }
  }
}

void CautionOfHalves(const std::vector<FoundEffect>& effects, std::vector<std::string>* cautions) {
  std::vector<EffectSpec> contradicted;
  for (const FoundEffect& effect : effects) {
    const double p = effect.confirmation.compatible_p;
    if (p * static_cast<double>(effects.size()) < kHalvesContradict) contradicted.push_back(effect.candidate.spec);
  }
  if (!contradicted.empty()) cautions->push_back(HalvesContradict(contradicted));
}

void CautionOfLookAlikes(const CalibrationProblem& problem, const std::vector<FoundEffect>& effects,
                         std::vector<std::string>* cautions) {
  CautionOfOneLoad(problem, effects, cautions);
  CautionOfTemperature(problem, effects, cautions);
}

void CautionOfNotNamed(const std::vector<std::pair<EffectSpec, double>>& unconfirmed, Diagnosis* diagnosis) {
  const Robot& robot = diagnosis->final.problem->robot();
  std::set<std::string> said;
  for (const FoundEffect& effect : diagnosis->effects) said.insert(NameOfExplanation(robot, effect.candidate.spec));
  for (const auto& [spec, probability] : unconfirmed) said.insert(NameOfExplanation(robot, spec));
  std::set<std::string> leading;
  const ReportedPosterior& posterior = diagnosis->posterior;
  if (!posterior.sets.empty()) {
    for (const EffectSpec& spec : posterior.sets[0].specs) leading.insert(NameOfExplanation(robot, spec));
  }
  std::vector<std::pair<EffectSpec, double>> in_leading, elsewhere;
  for (const auto& [spec, probability] : posterior.explanations) {
    const std::string name = NameOfExplanation(robot, spec);
    if (probability <= kEvenOdds || said.count(name) > 0) continue;
    (leading.count(name) > 0 ? in_leading : elsewhere).emplace_back(spec, probability);
  }
  if (!in_leading.empty()) diagnosis->cautions.push_back(NotInFullModel(robot, in_leading));
  if (!elsewhere.empty()) diagnosis->cautions.push_back(NotInLeading(robot, elsewhere));
}

void CautionOfHoldout(const DiagnosedModel& final, bool has_unexplained, bool is_sigma_stated, double significance,
                      std::vector<std::string>* cautions) {
  if (has_unexplained) CautionOfAFew(final, significance, cautions);
  const double rms = final.estimate.validation.rms, floor = final.estimate.noise_floor;
  if (CountHeldOut(final) < kFewHeldOut) return;
  if (!has_unexplained && IsFarFromFloor(final, is_sigma_stated, significance))
    cautions->push_back(HoldoutFarAboveFloor(rms, floor));
  const double scatter = 1.0 / std::sqrt(2.0 * FreedomOfHoldout(final));  // of an RMS, relative
  if (is_sigma_stated && rms < (1.0 - kFarBelowFloor * scatter) * floor)
    cautions->push_back(HoldoutBelowFloor(rms, floor));
}

}  // namespace sagitta
