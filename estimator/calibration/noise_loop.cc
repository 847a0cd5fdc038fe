#include "estimator/calibration/noise_loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>

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
#include "estimator/statistics/distributions.h"
#include "problems/problem_checks.h"

namespace sagitta {
namespace {

constexpr double kTinySigma = 1e-6;  // m, where none is stated: below any noise, so that nothing is held for it
constexpr int kMostNoiseRounds = 60;
constexpr double kSettledSigma = 1e-4;      // largest relative change of a standard deviation
constexpr double kWeightSettled = 1e-4;     // largest change of the root of a weight
constexpr double kSmallWeight = 0.2;        // an outlier to variance components
constexpr double kSettledResiduals = 0.01;  // eq. (14) runs a stated number of times

bool UsesResiduals(const Experiment& experiment) { return experiment.noise.from == NoiseSpec::From::kResiduals; }

// Whether weights move with the residuals that they are found from.
bool WeightsFollow(const Experiment& experiment) {
  return UsesResiduals(experiment) && experiment.method.weights != Weights::kEqual;
}

// What the rounds carry.
struct Loop {
  CalibrationProblem problem;  // at the noise of this round
  NoiseRoots base;             // roots before weights and components
  bool stated = false;         // something states the instrument's noise
  LossKind loss = LossKind::kNone;
  std::vector<double> weights;  // of the calibration observations
  std::vector<Outlier> outliers;
  RepeatabilityChoice choice;
  RowGroups groups;
  NoiseRoots spread;  // of residuals
  NoiseReport report;

  explicit Loop(const CalibrationProblem& given) : problem(given), base(NoiseOfAll(given, kTinySigma)) {
    stated = given.sigma_is_stated();
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
  constexpr double kFar = 100.0, kLeast = 1e-20;
  const double there = LossWeight(LossKind::kHuber, kFar);
  if (loss == LossKind::kHuber && weight < there) weight *= weight / there;
  return std::max(kLeast, weight);
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
  const double change = FindComponents(at_base, estimate.parameters, loop->stated, round, &loop->choice);
  loop->problem.latent = loop->choice.latent;
  for (Matrix3<double>& root : *roots) root *= loop->choice.instrument;
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

// Weights at this fit; returns the largest change of their roots.
double UpdateWeights(const Estimate& estimate, const NoiseRoots& roots, Loop* loop, double* scale) {
  *scale = 1.0;
  if (loop->loss == LossKind::kNone) return 0.0;
  CalibrationProblem& problem = loop->problem;
  const std::vector<int> observations = problem.CalibrationObservations();
  NoiseRoots noise;
  for (const int i : observations) noise.push_back(roots[i]);
  PointCheck check = CheckPoints(problem, estimate.parameters, noise, loop->weights, loop->report.robust_scale);
  // Median of u^2 / expected over that of chi2_3, times the scale that u was divided by.
  *scale = loop->report.robust_scale * RobustScale(check);
  // Where components are estimated they set the scale; where sigmas are stated it only grows.
  if (loop->stated && !EstimatesComponents(problem.experiment())) *scale = std::max(1.0, *scale);
  check = CheckPoints(problem, estimate.parameters, noise, loop->weights, *scale);
  double change = std::abs(*scale / loop->report.robust_scale - 1.0);
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
  NoiseRoots roots = loop->base;
  const double component_change = UpdateComponents(estimate, round, loop, &roots);
  const double spread_change = UpdateSpread(estimate, loop, &roots);
  double scale = 1.0;
  const double weight_change = UpdateWeights(estimate, roots, loop, &scale);
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
    for (const Outlier& outlier : loop->outliers) kept[k] = kept[k] && outlier.observation != observations[k];
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
  return Eigen::VectorXd::Constant(estimate.covariance.rows(), std::numeric_limits<double>::infinity());
}

void ToMetres(VarianceComponent* instrument) {
  for (double* number : {&instrument->value, &instrument->sigma, &instrument->low, &instrument->high}) {
    *number *= kTinySigma;
  }
}

// Judged without weights: chi2, residuals and hold-out are those of the noise that was found.
CalibrationProblem JudgeRound(Loop* loop, Estimate* estimate) {
  const Experiment& experiment = loop->problem.experiment();
  CalibrationProblem judged = loop->problem;
  judged.resolved_noise = loop->base;
  for (Matrix3<double>& root : judged.resolved_noise) root *= loop->choice.instrument;
  if (UsesResiduals(experiment)) {
    judged.resolved_noise = loop->spread;
    judged.weight_roots = ResidualWeights(experiment, loop->spread);
  } else if (!loop->stated && !EstimatesComponents(experiment)) {
    judged.resolved_noise.clear();  // one common sigma, estimated
  }
  if (loop->loss != LossKind::kNone) FinishRobust(loop, &judged, estimate);
  ComputeStatistics(judged, estimate);
  if (EstimatesComponents(experiment)) {
    FinishComponents(judged, estimate->parameters, &loop->choice, &loop->report);
    loop->report.instrument_is_factor = loop->stated;
    if (!loop->stated) ToMetres(&loop->report.components[0]);
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

}  // namespace

namespace {

// As the problem weighs its rows.
ResolvedEstimate EstimateOnce(CalibrationProblem problem, const JointOptions& options) {
  ResolvedEstimate once{std::move(problem), {}, {}};
  JointOptions own = options;
  own.fitted = &once.rows;
  once.estimate = EstimateJointly(once.problem, own);
  return once;
}

constexpr int kScatterRounds = 3;  // residuals that hardly change: of unequal weights first, then of nearly equal ones

// Points and rotations weighed by the spread of each, where nothing states any noise.
ResolvedEstimate EstimateWithTwoNoises(ResolvedEstimate plain, const JointOptions& options) {
  for (int round = 0; round < kScatterRounds; ++round) {
    const std::optional<TwoNoises> noises = FindTwoNoises(plain.problem, plain.estimate);
    if (!noises) break;
    CalibrationProblem weighed = plain.problem;
    weighed.resolved_noise = noises->roots;
    ResolvedEstimate next = EstimateOnce(std::move(weighed), options);
    if (!IsUsable(next.estimate.status)) break;
    plain = std::move(next);
    plain.estimate.noise_report.components = noises->components;
    plain.estimate.noise_report.instrument_is_factor = false;
    plain.estimate.noise_report.instrument_rms = noises->components[0].value;
  }
  if (plain.problem.resolved_noise.empty()) return plain;
  // Student's distribution: the variances were found from these rows.
  const Eigen::VectorXd dof = Eigen::VectorXd::Constant(plain.estimate.covariance.rows(), plain.estimate.dof);
  ReplaceCovariance(plain.problem, Eigen::MatrixXd(plain.estimate.covariance), dof, &plain.estimate);
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

// Rotations weighed by what they scatter, where the stated noise is not what is left.
ResolvedEstimate EstimateWithRotationScatter(ResolvedEstimate plain, const JointOptions& options) {
  if (!options.judge) return plain;
  const CalibrationProblem stated = plain.problem;
  const std::vector<std::string> words = plain.estimate.noise_report.words;
  for (int round = 0; round < kScatterRounds; ++round) {
    const std::optional<RotationScatter> scatter = FindRotationScatter(stated, plain.estimate);
    if (!scatter) break;
    CalibrationProblem weighed = stated;
    weighed.resolved_noise = scatter->roots;
    ResolvedEstimate next = EstimateOnce(std::move(weighed), options);
    if (!IsUsable(next.estimate.status)) break;
    plain = std::move(next);
    plain.estimate.noise_report.words = words;
    plain.estimate.noise_report.words.push_back(RotationScatterInWords(scatter->spread));
  }
  return plain;
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

ResolvedEstimate EstimateWithNoise(CalibrationProblem problem, const JointOptions& options) {
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

}  // namespace sagitta
