#include "estimator/calibration/noise_loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "estimator/calibration/load_remedy.h"
#include "estimator/calibration/marker_remedy.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/noise/outliers.h"
#include "estimator/noise/repeatability.h"
#include "estimator/noise/residual_noise.h"
#include "estimator/noise/robot_scatter.h"
#include "estimator/noise/robust.h"
#include "estimator/noise/rotation_noise.h"
#include "estimator/noise/weighting.h"
#include "estimator/report/calibration_words.h"
#include "estimator/report/noise_words.h"
#include "problems/problem_checks.h"

namespace sagitta {
namespace {

constexpr double kTinySigma = 1e-6;      // m, where none is stated: below any noise, so that nothing is held for it
constexpr int kMostNoiseRounds = 60;     // each may leave 6/7 of the last one's change: 1e-4 after all
constexpr double kSettledSigma = 1e-4;   // largest change of a standard deviation: 5 10^7 rows leave as much open
constexpr double kWeightSettled = 1e-4;  // largest change of the root of a weight: the same
constexpr double kSmallWeight = 0.2;     // an outlier to variance components: Huber's at 10 deviations, Cauchy's at 5
constexpr double kSettledResiduals = 0.01;  // eq. (14) runs a stated number of times

bool UsesResiduals(const Experiment& experiment) { return experiment.noise.from == NoiseSpec::From::kResiduals; }

// Whether weights move with the residuals that they are found from.
bool WeightsFollow(const Experiment& experiment) {
  return UsesResiduals(experiment) && experiment.method.weights != Weights::kEqual;
}

// What the rounds carry.
struct Loop {
  CalibrationProblem problem;  // at the noise of this round
  CalibrationProblem given;
  NoiseRoots base;               // roots before weights and components
  bool are_open = false;         // rotations
  bool rotations_apart = false;  // their noise is found in the rounds, points' stated or not
  double rotation = 1.0;         // times base that rotations scatter, where no component says it
  bool stated = false;           // something states the instrument's noise
  LossKind loss = LossKind::kNone;
  std::vector<double> weights;  // of the calibration observations
  std::vector<Outlier> outliers;
  RepeatabilityChoice choice;
  RowGroups groups;
  NoiseRoots spread;  // of residuals
  NoiseReport report;

  explicit Loop(const CalibrationProblem& as_given)
      : problem(as_given), given(as_given), base(NoiseOfAll(as_given, kTinySigma)) {
    stated = given.sigma_is_stated();
    are_open = RotationsAreOpen(given);
    loss = given.experiment().method.loss;
    report.loss = given.experiment().method.loss;
    report.loss_tuning = loss == LossKind::kNone ? 0.0 : LossTuning(loss);
    weights.assign(given.CalibrationObservations().size(), 1.0);
    if (UsesResiduals(given.experiment())) groups = GroupRows(given.data(), given.experiment().noise.group);
  }
};

// Huber's weight leaves a row that is d standard deviations off a square of c d: one that is 10^7 off would decide
// alone how much the rows scatter, and with that what counts as measured. Beyond kFar its square grows no more.
double WeightInFit(LossKind loss, double weight) {
  constexpr double kFar = 100.0, kLeast = 1e-20;  // kFar: an arm that misses by 0.5 mm, read to 5 um
  const double there = LossWeight(LossKind::kHuber, kFar);
  if (loss == LossKind::kHuber && weight < there) weight *= weight / there;
  return std::max(kLeast, weight);
}

// By component or robust ratio: those of points and of rotations, before weights.
NoiseRoots RootsFound(const Loop& loop) {
  const bool by_components = EstimatesComponents(loop.problem.experiment());
  const double of_rotations = by_components && loop.rotations_apart ? loop.choice.rotation
                              : loop.rotations_apart                ? loop.rotation
                                                                    : loop.choice.instrument;
  NoiseRoots roots = loop.base;
  for (size_t i = 0; i < roots.size(); ++i) {
    roots[i] *= loop.problem.data().observations[i].is_point() ? loop.choice.instrument : of_rotations;
  }
  return roots;
}

// Roots over the root of the weights: the next round's least squares.
void ApplyWeights(const std::vector<int>& observations, double scale, Loop* loop) {
  if (loop->loss == LossKind::kNone) return;
  if (loop->problem.resolved_noise.empty()) loop->problem.resolved_noise = loop->base;
  for (size_t k = 0; k < observations.size(); ++k) {
    loop->problem.resolved_noise[observations[k]] *= scale / std::sqrt(WeightInFit(loop->loss, loop->weights[k]));
  }
}

// The problem without weights; what they reveal as an outlier is left out.
CalibrationProblem Cleaned(const Loop& loop, const NoiseRoots& roots) {
  CalibrationProblem cleaned = loop.problem;
  cleaned.resolved_noise = roots;
  const std::vector<int> observations = loop.problem.CalibrationObservations();
  for (size_t k = 0; k < observations.size(); ++k) {
    if (loop.weights[k] < kSmallWeight) cleaned.mutable_data()->observations[observations[k]].excluded = true;
  }
  for (const Outlier& outlier : loop.outliers) cleaned.mutable_data()->ExcludeRow(outlier.observation);
  return cleaned;
}

double UpdateComponents(const Estimate& estimate, int round, Loop* loop, NoiseRoots* roots) {
  if (!EstimatesComponents(loop->problem.experiment())) return 0.0;
  const CalibrationProblem at_base = Cleaned(*loop, loop->base);
  loop->choice.rotations_apart = loop->rotations_apart;
  const double change = FindComponents(at_base, estimate.parameters, loop->stated, round, &loop->choice);
  loop->problem.latent = loop->choice.latent;
  *roots = RootsFound(*loop);
  return change;
}

// {from: residuals} weighs by eq. (14), unless equal weights are asked for.
NoiseRoots ResidualWeights(const Experiment& experiment, const NoiseRoots& spread) {
  if (experiment.method.weights == Weights::kEqual) return RootsOfWeights(experiment, spread);
  return Eq14Roots(spread, experiment.noise.sigma0, experiment.noise.lambda);
}

double UpdateSpread(const Estimate& estimate, Loop* loop, NoiseRoots* roots) {
  const Experiment& experiment = loop->problem.experiment();
  if (!UsesResiduals(experiment)) return 0.0;
  const NoiseRoots before = loop->spread;
  loop->spread = SpreadOfResiduals(loop->problem, estimate, loop->groups, &loop->report.groups);
  *roots = loop->spread;
  loop->problem.weight_roots = ResidualWeights(experiment, loop->spread);
  double change = before.empty() ? 1.0 : 0.0;
  for (size_t i = 0; i < before.size(); ++i) {
    // |ln(s / s before)|: relative, whichever way.
    const Vector3<double> ratio = loop->spread[i].diagonal().cwiseQuotient(before[i].diagonal());
    change = std::max(change, ratio.array().log().abs().maxCoeff());
  }
  return change;
}

// What rotations scatter by over what points do, where no component says it; returns its change.
double UpdateRatio(const Estimate& estimate, const PointCheck& check, Loop* loop, NoiseRoots* roots) {
  if (!loop->rotations_apart || EstimatesComponents(loop->problem.experiment())) return 0.0;
  const double ratio = RobustRatio(loop->problem, estimate.parameters, check);
  loop->rotation *= ratio;
  *roots = RootsFound(*loop);
  return std::abs(std::log(ratio));
}

// Weights at this fit; returns the largest change of their roots.
double UpdateWeights(const Estimate& estimate, Loop* loop, NoiseRoots* roots, double* scale) {
  *scale = 1.0;
  if (loop->loss == LossKind::kNone) return 0.0;
  CalibrationProblem& problem = loop->problem;
  const std::vector<int> observations = problem.CalibrationObservations();
  const auto check_at = [&](double at) {
    NoiseRoots noise;
    for (const int i : observations) noise.push_back((*roots)[i]);
    return CheckPoints(problem, estimate.parameters, noise, loop->weights, at);
  };
  PointCheck check = check_at(loop->report.robust_scale);
  const double ratio_change = UpdateRatio(estimate, check, loop, roots);
  if (ratio_change > 0.0) check = check_at(loop->report.robust_scale);
  // Median of u^2 / expected over that of chi2_3, times the scale that u was divided by.
  *scale = loop->report.robust_scale * RobustScale(check);
  // Where components are estimated they set the scale; where sigmas are stated it only grows.
  if (loop->stated && !EstimatesComponents(problem.experiment())) *scale = std::max(1.0, *scale);
  check = check_at(*scale);
  double change = std::max(ratio_change, std::abs(*scale / loop->report.robust_scale - 1.0));
  for (size_t k = 0; k < observations.size(); ++k) {
    const double weight = LossWeight(loop->loss, check.distance[k]);
    change = std::max(change, std::abs(std::sqrt(weight) - std::sqrt(loop->weights[k])));
    loop->weights[k] = weight;
  }
  loop->report.robust_scale = *scale;
  loop->outliers = FlagOutliers(problem, check, estimate.parameters, problem.experiment().significance);
  return change;
}

// The noise at a fit; true when it stands still.
bool Update(const Estimate& estimate, int round, Loop* loop) {
  if (round == 0) {
    const CalibrationProblem& problem = loop->problem;
    loop->rotations_apart = loop->are_open && RotationsAreDetermined(problem, estimate.parameters);
  }
  NoiseRoots roots = RootsFound(*loop);
  const double component_change = UpdateComponents(estimate, round, loop, &roots);
  const double spread_change = UpdateSpread(estimate, loop, &roots);
  double scale = 1.0;
  const double weight_change = UpdateWeights(estimate, loop, &roots, &scale);
  loop->problem.resolved_noise = roots;
  ApplyWeights(loop->problem.CalibrationObservations(), scale, loop);
  if (UsesResiduals(loop->problem.experiment())) {
    loop->report.converged = spread_change < kSettledResiduals;
    return round >= loop->problem.experiment().noise.iterations;
  }
  loop->report.converged = component_change < kSettledSigma && weight_change < kWeightSettled;
  return loop->report.converged;
}

// Isolated outliers are left out of every figure, a pattern is not; the price of the loss is in the intervals.
void FinishRobust(Loop* loop, CalibrationProblem* judged, Estimate* estimate) {
  NoiseReport& report = loop->report;
  report.outliers = loop->outliers;
  report.shared =
      WhatTheyShare(loop->problem, estimate->parameters, loop->outliers, loop->problem.experiment().significance);
  report.systematic = !report.shared.empty();
  const std::vector<int> observations = loop->problem.CalibrationObservations();
  NoiseRoots noise;
  for (const int i : observations) noise.push_back(judged->SqrtCovariance(i));
  for (Matrix3<double>& root : noise) {
    if (!IsStated(root)) root = kTinySigma * Matrix3<double>::Identity();
  }
  const PointCheck check = CheckPoints(loop->problem, estimate->parameters, noise, loop->weights, report.robust_scale);
  std::vector<bool> kept(observations.size(), true);
  for (size_t k = 0; k < observations.size(); ++k) {
    const int i = observations[k], partner = judged->data().observations[i].partner;
    for (const Outlier& o : loop->outliers) kept[k] = kept[k] && o.observation != i && o.observation != partner;
  }
  report.loss_inflation = report.systematic ? 1.0 : std::max(1.0, LossInflation(loop->loss, check, kept));
  if (report.systematic) return;
  for (const Outlier& outlier : loop->outliers) judged->mutable_data()->ExcludeRow(outlier.observation);
}

// Degrees of freedom of each interval where variances were estimated. The sandwich has its own: it does not use them.
Eigen::VectorXd IntervalDof(const Loop& loop, const Estimate& estimate) {
  if (estimate.intervals.method == CovarianceKind::kSandwich) return estimate.interval_dof;
  if (estimate.sigma.scaled || !estimate.sigma.stated) {
    return Eigen::VectorXd::Constant(estimate.covariance.rows(), std::max(1, estimate.dof));
  }
  if (loop.choice.interval_dof.size() == estimate.covariance.rows()) return loop.choice.interval_dof;
  return estimate.interval_dof;
}

// From factors on the roots before the rounds to what they scatter by.
void ToUnits(const Loop& loop, std::vector<VarianceComponent>* components) {
  if (!loop.stated) ScaleComponent(kTinySigma, &(*components)[0]);
  for (size_t i = 0; i < loop.base.size() && loop.rotations_apart; ++i) {
    if (loop.problem.data().observations[i].is_point()) continue;
    return ScaleComponent(loop.base[i](0, 0), &(*components)[1]);
  }
}

// With a loss, by the readings that are judged: outliers are out of them, others count in full. `judged` has the ratio.
void JudgeRotations(Loop* loop, CalibrationProblem* judged, Estimate* estimate) {
  NoiseReport& report = loop->report;
  if (loop->stated) {
    for (const bool by_points : {false, true}) {
      ComputeStatistics(*judged, estimate);
      if (by_points && !estimate->sigma.scaled) return;
      const auto scatter = FindRotationScatter(loop->given, *judged, *estimate, by_points);
      if (!scatter) return;
      KeepRotationNoise(*scatter, judged);
    }
    return;
  }
  std::optional<TwoNoises> noises = TwoSpreads(*judged, *estimate);
  if (!noises) {
    judged->resolved_noise.clear();
    return;
  }
  judged->resolved_noise = noises->roots;
  const FreedomOfTwo freedom = FindFreedom(*judged, estimate->parameters);
  SetIntervals(freedom, &noises->components);
  loop->choice.interval_dof = freedom.of_intervals;
  report.components = noises->components;
  report.instrument_is_factor = false;
  report.instrument_rms = report.components[0].value;
}

// Judged without weights: chi2, residuals and hold-out are those of the noise that was found.
CalibrationProblem JudgeRound(Loop* loop, Estimate* estimate) {
  const Experiment& experiment = loop->problem.experiment();
  CalibrationProblem judged = loop->problem;
  judged.resolved_noise = RootsFound(*loop);
  const bool by_ratio = loop->rotations_apart && !EstimatesComponents(experiment);
  if (UsesResiduals(experiment)) {
    judged.resolved_noise = loop->spread;
    judged.weight_roots = ResidualWeights(experiment, loop->spread);
  } else if (!loop->stated && !EstimatesComponents(experiment) && !by_ratio) {
    judged.resolved_noise.clear();  // one common sigma, estimated
  }
  if (loop->loss != LossKind::kNone) FinishRobust(loop, &judged, estimate);
  if (by_ratio) JudgeRotations(loop, &judged, estimate);
  ComputeStatistics(judged, estimate);
  if (EstimatesComponents(experiment)) {
    FinishComponents(judged, estimate->parameters, &loop->choice, &loop->report);
    loop->report.instrument_is_factor = loop->stated;
    ToUnits(*loop, &loop->report.components);
  }
  if (WeightsFollow(experiment) && estimate->covariance.size() > 0) {
    const Eigen::MatrixXd factor = FollowedByWeights(judged, *estimate, loop->groups, loop->report.groups);
    ReplaceCovariance(judged, factor * estimate->covariance * factor.transpose(), estimate->interval_dof, estimate);
  }
  if (loop->loss != LossKind::kNone || loop->choice.interval_dof.size() > 0) {
    ReplaceCovariance(judged, loop->report.loss_inflation * estimate->covariance, IntervalDof(*loop, *estimate),
                      estimate);
  }
  return judged;
}

ParameterSet Align(const JointOptions& options, Loop* loop) {
  if (options.progress) options.progress(AligningNominal());
  ParameterSet aligned = loop->problem.parameters;
  if (loop->loss == LossKind::kNone) {
    AlignNominal(loop->problem, &aligned);
    return aligned;
  }
  loop->weights = AlignRobustly(loop->problem, loop->loss, &aligned);
  ApplyWeights(loop->problem.CalibrationObservations(), 1.0, loop);
  return aligned;
}

// As the problem weighs its rows.
ResolvedEstimate EstimateOnce(CalibrationProblem problem, const JointOptions& options) {
  ResolvedEstimate once{std::move(problem), {}, {}};
  JointOptions own = options;
  own.fitted = &once.rows;
  once.estimate = EstimateJointly(once.problem, own);
  return once;
}

constexpr int kScatterRounds = 3;  // residuals that hardly change: of unequal weights first, then of nearly equal ones

// Two spreads in a row that differ by less than kSettledResiduals: from f degrees of freedom they are known to
// sqrt(1 / (2 f)), ten times as much with the thousands that a campaign has at most.
bool IsSettled(double before, double now) { return std::abs(std::log(now / before)) < kSettledResiduals; }

// Student's distribution: the variances were found from these rows.
void JudgeTwoNoises(ResolvedEstimate* found) {
  Estimate& estimate = found->estimate;
  const FreedomOfTwo freedom = FindFreedom(found->problem, estimate.parameters);
  SetIntervals(freedom, &estimate.noise_report.components);
  if (estimate.intervals.method == CovarianceKind::kSandwich) return;  // it does not use them
  ReplaceCovariance(found->problem, Eigen::MatrixXd(estimate.covariance), freedom.of_intervals, &estimate);
}

// Points and rotations weighed by the spread of each, where nothing states any noise.
ResolvedEstimate EstimateWithTwoNoises(ResolvedEstimate plain, const JointOptions& options) {
  double ratio = 0.0;
  for (int round = 0; round < kMostNoiseRounds; ++round) {
    const std::optional<TwoNoises> noises = FindTwoNoises(plain.problem, plain.estimate);
    if (!noises) break;
    const double before = std::exchange(ratio, noises->components[1].value / noises->components[0].value);
    if (round > 0 && IsSettled(before, ratio)) break;
    CalibrationProblem weighed = plain.problem;
    weighed.resolved_noise = noises->roots;
    ResolvedEstimate next = EstimateOnce(std::move(weighed), options);
    if (!IsUsable(next.estimate.status)) break;
    plain = std::move(next);
    plain.estimate.noise_report.components = noises->components;
    plain.estimate.noise_report.instrument_is_factor = false;
    plain.estimate.noise_report.instrument_rms = noises->components[0].value;
  }
  if (HasTwoNoises(plain.estimate.noise_report)) JudgeTwoNoises(&plain);
  return plain;
}

// Where the robot scatters by far more than the instrument, weighed by both.
ResolvedEstimate EstimateWithRobotScatter(ResolvedEstimate plain, const JointOptions& options) {
  if (!options.judge || !ScattersByRobot(plain.problem, plain.estimate)) return plain;
  const CalibrationProblem stated = plain.problem;
  for (int round = 0; round < kScatterRounds; ++round) {
    const RobotScatter scatter = FindRobotScatter(stated, plain.estimate);
    CalibrationProblem weighed = stated;
    weighed.resolved_noise = scatter.roots;
    ResolvedEstimate next = EstimateOnce(std::move(weighed), options);
    if (!IsUsable(next.estimate.status)) break;
    plain = std::move(next);
    plain.estimate.noise_report.words = {RobotScatterInWords(scatter.tau)};
  }
  return plain;
}

// The rows of `stated`, with rotations weighed by what they scatter (rotation_noise.h), until that stands still.
ResolvedEstimate EstimateByScatter(const CalibrationProblem& stated, ResolvedEstimate plain, bool by_points,
                                   const JointOptions& options) {
  const std::vector<std::string> words = plain.estimate.noise_report.words;
  const bool is_in_addition = !NoRotationIsStated(stated);
  double spread = 0.0;
  for (int round = 0; round < kMostNoiseRounds; ++round) {
    const auto scatter = FindRotationScatter(stated, plain.problem, plain.estimate, by_points);
    if (!scatter) break;
    const double before = std::exchange(spread, scatter->spread / scatter->unit);
    if (round > 0 && IsSettled(before, spread)) break;
    CalibrationProblem weighed = stated;
    weighed.resolved_noise = scatter->roots;
    if (!is_in_addition) KeepRotationNoise(*scatter, &weighed);
    ResolvedEstimate next = EstimateOnce(std::move(weighed), options);
    if (!IsUsable(next.estimate.status)) break;
    plain = std::move(next);
    plain.estimate.noise_report.words = words;
    if (stated.repeat_scatter) continue;  // it has that
    plain.estimate.noise_report.words.push_back(RotationScatterInWords(scatter->spread, is_in_addition));
  }
  return plain;
}

// Where the stated noise is not what is left, or repeats left rotations open; asked at what is stated: by their own
// spread they always look right. Next to repeats in units of points only where these then refute their noise.
ResolvedEstimate EstimateWithRotationScatter(ResolvedEstimate plain, const JointOptions& options) {
  if (!options.judge || !RotationsScatterOtherwise(plain.problem, plain.estimate)) return plain;
  const CalibrationProblem stated = plain.problem;
  const bool by_points = !stated.repeat_scatter;
  plain = EstimateByScatter(stated, std::move(plain), by_points, options);
  if (by_points || !plain.estimate.sigma.scaled) return plain;
  return EstimateByScatter(stated, std::move(plain), true, options);
}

// As the noise is stated, weighed by what scatters where that is something else.
ResolvedEstimate EstimatePlainly(CalibrationProblem problem, const JointOptions& options) {
  ResolvedEstimate plain = EstimateOnce(std::move(problem), options);
  if (options.judge && !plain.estimate.sigma.stated && plain.problem.resolved_noise.empty()) {
    return EstimateWithTwoNoises(std::move(plain), options);
  }
  return EstimateWithRotationScatter(EstimateWithRobotScatter(std::move(plain), options), options);
}

}  // namespace

bool FindsNoise(const CalibrationProblem& problem) {
  const Experiment& experiment = problem.experiment();
  return EstimatesComponents(experiment) || UsesResiduals(experiment) || WeighsOtherwise(problem) ||
         experiment.method.loss != LossKind::kNone;
}

namespace {

// Fit -> noise -> fit.
ResolvedEstimate EstimateInRounds(const CalibrationProblem& problem, const JointOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Loop loop(problem);
  const ParameterSet aligned = Align(options, &loop);
  JointOptions inner = options;
  inner.judge = false;
  inner.aligned = &aligned;
  ParameterSet values = aligned;
  Estimate estimate;
  int iterations = 0;
  for (int round = 0; round < kMostNoiseRounds; ++round) {
    estimate = EstimateFrom(loop.problem, values, inner);
    iterations += estimate.iterations;
    if (!IsUsable(estimate.status)) break;
    values = estimate.parameters;
    loop.report.rounds = round + 1;
    if (options.progress) options.progress("noise, round " + std::to_string(round + 1));
    if (Update(estimate, round, &loop)) break;
  }
  estimate.iterations = iterations;
  ResolvedEstimate result{loop.problem, std::move(estimate), {}};
  if (IsUsable(result.estimate.status)) {
    result.problem = JudgeRound(&loop, &result.estimate);
    AddLoadRemedies(result.problem, &result.estimate);
    AddMarkerRemedies(result.problem, &result.estimate);
  }
  result.estimate.noise_report = loop.report;
  result.estimate.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  DescribeNoise(result.problem, &result.estimate);
  return result;
}

// As the keys of the experiment ask for.
ResolvedEstimate EstimateByKeys(CalibrationProblem problem, const JointOptions& options) {
  CheckOptions(options);
  CheckRowsAreRead(problem);
  if (!FindsNoise(problem)) {
    ResolvedEstimate plain = EstimatePlainly(std::move(problem), options);
    DescribeNoise(plain.problem, &plain.estimate);
    return plain;
  }
  if (WeighsOtherwise(problem)) {
    problem.weight_roots = RootsOfWeights(problem.experiment(), NoiseOfAll(problem, kTinySigma));
    ResolvedEstimate result = EstimateOnce(std::move(problem), options);
    DescribeNoise(result.problem, &result.estimate);
    return result;
  }
  return EstimateInRounds(problem, options);
}

// Rotations whose noise was to be found and was not.
bool AreStillOpen(const ResolvedEstimate& found) {
  const std::optional<RepeatScatter>& repeats = found.problem.repeat_scatter;
  return RotationComponent(found.estimate.noise_report) == nullptr &&
         !(repeats && repeats->rotation_sigma.minCoeff() > 0.0);
}

}  // namespace

ResolvedEstimate EstimateWithNoise(CalibrationProblem problem, const JointOptions& options) {
  const bool are_open = options.judge && RotationsAreOpen(problem);
  ResolvedEstimate result = EstimateByKeys(std::move(problem), options);
  if (are_open && IsUsable(result.estimate.status) && AreStillOpen(result)) {
    SayRotationsAreAssumed(result.problem.repeat_scatter.has_value(), &result.estimate);
  }
  return result;
}

}  // namespace sagitta
