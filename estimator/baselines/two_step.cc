#include "estimator/baselines/two_step.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "estimator/baselines/damped_step.h"
#include "estimator/baselines/paper_stages.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/report/baselines_words.h"
#include "problems/interruption.h"
#include "problems/range.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kSmallestScale = 1e-4;    // times it: 0.1 um, the scale of steps on data without noise
constexpr double kDiverged = 1e12;         // standard deviations per step: of 1 um 1000 km, beyond any coordinate
constexpr double kRoundOffOfSteps = 1e-5;  // standard deviations: a step below it may be a rounding error
constexpr int kRateWindow = 6;             // iterations over which the rate is measured ...
constexpr int kStandstill = 20;            // iterations without progress that show rounding
constexpr double kRateFloor = 1e-6;        // ... the last ones with steps above this many standard deviations

Linearization LinearizeWithPriors(const StageContext& context, const ParameterSet& parameters,
                                  const std::vector<int>& columns) {
  Linearization here = Linearize(context.problem, parameters, context.observations, columns, context.noise);
  AppendPriors(parameters, &here);
  return here;
}

// One Gauss-Newton step in the given coordinates, the others held.
StepOutcome GaussNewtonStep(const StageContext& context, const std::vector<int>& coordinates, StageState* state) {
  const auto rows_at = [&](const ParameterSet& parameters, const std::vector<int>& columns) -> FittedRows {
    const Linearization here = LinearizeWithPriors(context, parameters, columns);
    return {here, here.num_rows()};
  };
  const StepOutcome outcome = DampedStep(rows_at, coordinates, &state->parameters);
  for (size_t s = 0; s < state->bases.size(); ++s) state->bases[s] = state->parameters.BaseInStation(s);
  return outcome;
}

StepOutcome Printed(bool solved) { return solved ? StepOutcome::kTaken : StepOutcome::kSingular; }

StepOutcome IterateSteps(TwoStepVariant variant, const StageContext& context, StageState* state) {
  switch (variant) {
    case TwoStepVariant::kLiteral:
      return Printed(LiteralStageOne(context, state) && LiteralStageTwo(context, state));
    case TwoStepVariant::kRelinearised:
      if (!RelinearisedStageOne(context, state)) return StepOutcome::kSingular;
      return GaussNewtonStep(context, context.geometry, state);
    case TwoStepVariant::kExact: {
      const StepOutcome first = GaussNewtonStep(context, context.base_and_markers, state);
      return first == StepOutcome::kTaken ? GaussNewtonStep(context, context.geometry, state) : first;
    }
  }
  return StepOutcome::kSingular;
}

StageContext MakeStageContext(const CalibrationProblem& problem) {
  StageContext context{problem, problem.CalibrationObservations(), {}, {}, {}};
  context.noise = FitRoots(problem, context.observations, kFallbackSigma);
  for (const int c : problem.parameters.EstimatedCoordinates()) {
    const ParameterBlock& block = problem.parameters.blocks()[problem.parameters.coordinates()[c].block];
    (block.kind == BlockKind::kModelParameter ? context.geometry : context.base_and_markers).push_back(c);
  }
  return context;
}

// Why the printed stage 1 cannot run on this problem; empty if it can.
std::string StepObstacle(const CalibrationProblem& problem) {
  for (size_t m = 0; m < problem.marker_frames().size(); ++m) {
    if (problem.marker_frames()[m] == problem.robot().chain.FlangeFrame()) continue;
    return NotRunBecause(MarkerOffFlange(problem.data().markers[m]));
  }
  for (const Coordinate& coordinate : problem.parameters.coordinates()) {
    const BlockKind kind = problem.parameters.blocks()[coordinate.block].kind;
    if (kind == BlockKind::kModelParameter || coordinate.estimated()) continue;
    return NotRunBecause(HeldInFirstStage(coordinate.name));
  }
  return "";
}

// How steps are measured, from the joint linearization at the start.
struct Yardstick {
  bool singular = true;
  Linearization start;
  Eigen::VectorXd sigmas;  // standard deviations of all coordinates

  // Largest change in standard deviations.
  double Size(const Eigen::VectorXd& step) const { return step.cwiseQuotient(sigmas).cwiseAbs().maxCoeff(); }
  // |J step|: the change of the whitened residual. In this norm the exact
  // alternation is a symmetric map, and ratios settle soonest.
  double Norm(const Eigen::VectorXd& step) const {
    Eigen::VectorXd columns(start.num_columns());
    for (int c = 0; c < columns.size(); ++c) columns[c] = step[start.columns[c]];
    return (start.jacobian * columns).norm();
  }
};

Yardstick MakeYardstick(const StageContext& context, const ParameterSet& parameters) {
  const std::vector<int> columns = parameters.EstimatedCoordinates();
  Yardstick yardstick;
  yardstick.start = LinearizeWithPriors(context, parameters, columns);
  const LinearSolution solution = SolveLinearization(yardstick.start);
  yardstick.singular = !yardstick.start.valid || !solution.full_rank;
  if (yardstick.singular) return yardstick;
  const double dof = 3.0 * context.observations.size() - static_cast<double>(columns.size());
  double scale = 1.0;
  if (!context.problem.sigma_is_stated() && dof > 0) {
    scale = std::max(kSmallestScale, std::sqrt(solution.residual_norm_squared / dof));
  }
  yardstick.sigmas = Eigen::VectorXd::Constant(parameters.num_coordinates(), 1.0);
  for (size_t c = 0; c < columns.size(); ++c)
    yardstick.sigmas[columns[c]] = scale * std::sqrt(solution.covariance(c, c));
  return yardstick;
}

// Geometric mean of the last ratios that rounding errors leave alone.
double MeasureRate(const std::vector<double>& steps, const std::vector<double>& norms) {
  int last = static_cast<int>(steps.size()) - 1;
  while (last >= 0 && steps[last] < kRateFloor) --last;
  if (last < kRateWindow) return std::numeric_limits<double>::quiet_NaN();
  // (n_k / n_k-6)^(1/6).
  return std::pow(norms[last] / norms[last - kRateWindow], 1.0 / kRateWindow);
}

Status StatusOf(StepOutcome outcome) {
  if (outcome == StepOutcome::kEquilibriumDiverged) return Status::kEquilibriumDiverged;
  return outcome == StepOutcome::kNoDescent ? Status::kNoConvergence : Status::kSingular;
}

void Alternate(const StageContext& context, const TwoStepOptions& options, TwoStepResult* result) {
  Estimate& estimate = result->estimate;
  StageState state{estimate.aligned, {}};
  for (int s = 0; s < state.parameters.num_stations(); ++s) state.bases.push_back(state.parameters.BaseInStation(s));
  Yardstick yardstick = MakeYardstick(context, state.parameters);
  if (yardstick.singular && IterateSteps(options.variant, context, &state) == StepOutcome::kTaken) {
    yardstick = MakeYardstick(context, state.parameters);
  }
  if (yardstick.singular) return Stop(Status::kSingular, IdentificationSingular(), &estimate);
  std::vector<double> norms;
  Stop(Status::kNoConvergence, "stopped after " + std::to_string(options.max_iterations) + " iterations", &estimate);
  for (int i = 0; i < options.max_iterations; ++i) {
    CheckInterruption();
    const ParameterSet before = state.parameters;
    const StepOutcome outcome = IterateSteps(options.variant, context, &state);
    if (outcome != StepOutcome::kTaken) return Stop(StatusOf(outcome), StepOutcomeInWords(outcome), &estimate);
    const Eigen::VectorXd change = TangentDifference(state.parameters, before);
    const double step = yardstick.Size(change);
    if (!(step < kDiverged)) return Stop(Status::kNoConvergence, "the alternation diverges", &estimate);
    result->steps.push_back(step);
    norms.push_back(yardstick.Norm(change));
    result->rate = MeasureRate(result->steps, norms);
    estimate.iterations = i + 1;
    estimate.parameters = state.parameters;
    if (options.progress && i % 100 == 99) {
      options.progress("iteration " + std::to_string(i + 1) + ": step " + Significant(step, 2) +
                       " standard deviations");
    }
    const bool rounding = i >= kStandstill && step < kRoundOffOfSteps && step >= result->steps[i - kStandstill];
    // A step s that shrinks by the rate q leaves s q / (1 - q) still to go: stop where that is below the tolerance.
    const double rate = i == 0 ? 0.5 : std::min(step / std::max(1e-300, result->steps[i - 1]), 0.999);
    if (rounding || step < options.tolerance * (1.0 - rate)) {
      return Stop(Status::kConverged, "the alternation stands still", &estimate);
    }
  }
}

}  // namespace

void CheckOptions(const TwoStepOptions& options) {
  CheckIn(allowed::kIterations, options.max_iterations, "TwoStepOptions.max_iterations");
  CheckIn(allowed::kTolerance, options.tolerance, "TwoStepOptions.tolerance");
}

TwoStepResult EstimateInTwoSteps(const CalibrationProblem& problem, const TwoStepOptions& options) {
  CheckOptions(options);
  const auto start = std::chrono::steady_clock::now();
  TwoStepResult result;
  result.rate = std::numeric_limits<double>::quiet_NaN();
  Estimate& estimate = result.estimate;
  estimate.parameters = estimate.aligned = problem.parameters;
  const bool is_exact = options.variant == TwoStepVariant::kExact;
  const std::string obstacle = is_exact ? "" : StepObstacle(problem);
  if (!obstacle.empty()) {
    estimate.status = Status::kNotRun;
    estimate.message = obstacle;
    return result;
  }
  AlignNominal(problem, &estimate.aligned);
  estimate.parameters = estimate.aligned;
  Alternate(MakeStageContext(problem), options, &result);
  estimate.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!IsUsable(estimate.status)) return result;
  for (const Coordinate& coordinate : problem.parameters.coordinates()) {
    if (coordinate.held) estimate.status = Status::kConvergedWithHeldParameters;
  }
  ComputeStatistics(problem, &estimate);
  if (!is_exact) estimate.warnings.push_back(BiasIsIgnored());
  return result;
}

}  // namespace sagitta
