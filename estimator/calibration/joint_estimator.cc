#include "estimator/calibration/joint_estimator.h"

#include <chrono>
#include <cmath>
#include <optional>

#include "estimator/alignment/starting_values.h"
#include "estimator/calibration/effect_priors.h"
#include "estimator/calibration/held_rest.h"
#include "estimator/calibration/judge.h"
#include "estimator/calibration/load_remedy.h"
#include "estimator/calibration/marker_remedy.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/condensed_cost.h"
#include "estimator/least_squares/held_influence.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/normal_equations.h"
#include "estimator/least_squares/refit.h"
#include "estimator/least_squares/spring_tie_cost.h"
#include "estimator/least_squares/structure.h"
#include "estimator/report/calibration_words.h"
#include "problems/excitation.h"
#include "problems/range.h"

namespace sagitta {
namespace {

constexpr int kMaxHoldRounds = 8;  // a guard: each holds all that it finds, and what moves on shows in kConvergedSteps
constexpr int kFreshRounds = 3;    // afterwards what is held stays held, so that it ends
constexpr int kSomeBatches = 128;  // of each structure, a thousand shots: what moves their points most
constexpr int kMaxPolishSteps = 60;   // a bent valley (a compensator's shape) halves the step only: 1e3 to 1e-5 are 27
constexpr double kPolishReach = 1.0;  // standard deviations: farther off, Ceres has failed
constexpr int kMaxBoundedSteps = 60;  // as the steps without bounds
constexpr int kMaxWarmSteps = 12;     // at a time: less than one factorization of all deviations (SolveFromNear)
constexpr double kWarmReach = 1e3;    // standard deviations, from the round before
constexpr double kConvergedSteps = 1e-5;  // Gauss-Newton step left at the optimum, standard deviations
constexpr double kExactFit = 1e-9;        // of the stated noise: nothing is left to explain

void ReportStage(const JointOptions& options, const std::string& what) {
  if (options.progress) options.progress(what);
}

// What the residuals of a linearization scatter by at its optimum, whitened.
double ResidualScale(const LinearSolution& solution, int columns, int equations) {
  const double dof = equations - columns;
  // sqrt(r'r / (equations - columns)): 1 where the noise is as stated.
  return dof > 0 ? std::sqrt(solution.residual_norm_squared / dof) : 1.0;
}

// The scale of the whitened noise seen at a linearization: a-posteriori sigma,
// not below the stated one.
double ScaleOfRows(const CalibrationProblem& problem, const LinearSolution& solution, int columns, int equations) {
  const double scale = ResidualScale(solution, columns, equations);
  return problem.sigma_is_stated() ? std::max(1.0, scale) : scale;
}

// All coordinates that were asked for, held or not.
std::vector<int> RequestedCoordinates(const ParameterSet& parameters) {
  std::vector<int> requested;
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    if (parameters.coordinates()[i].free) requested.push_back(i);
  }
  return requested;
}

// Decides afresh, from all requested coordinates, which of them the data do not
// determine here; true if the set of held ones changed. With `only_add`, what is
// held already stays held (no cycles). at_start: limits by some of the rows; at the optimum it is decided again, by
// all.
bool DecideHeld(const CalibrationProblem& problem, const NormalEquations& equations, bool only_add, bool at_start,
                Estimate* estimate) {
  ParameterSet& parameters = estimate->parameters;
  const FittedRows fitted =
      RowsOf(equations, parameters, only_add ? parameters.EstimatedCoordinates() : RequestedCoordinates(parameters));
  const Linearization& all = fitted.rows;
  if (!all.valid) return false;
  const RowBatches& rows = equations.batches();
  const auto some = [&](const std::vector<ParameterSet>& at) { return rows.LargestMotions(at, kSomeBatches); };
  const auto of_all = [&](const std::vector<ParameterSet>& at) { return rows.LargestMotions(at); };
  const bool are_many = rows.num_units() > 2 * kSomeBatches * kBatchLanes;
  if (are_many && at_start) SetHoldLimits(problem, some, nullptr, &parameters);
  if (are_many && !at_start) SetHoldLimits(problem, of_all, some, &parameters);
  if (!are_many) SetHoldLimits(problem, of_all, nullptr, &parameters);
  const double scale = ScaleOfRows(problem, SolveLinearization(all), all.num_columns(), fitted.equations);
  const Unidentifiable found = FindUnidentifiable(all, parameters, scale);
  std::vector<Direction>& directions = estimate->identifiability.unidentifiable;
  std::vector<bool> hold(parameters.num_coordinates(), false);
  if (!only_add) directions.clear();
  for (size_t k = 0; k < found.columns.size(); ++k) {
    hold[all.columns[found.columns[k]]] = true;
    directions.push_back(found.directions[k]);
  }
  bool changed = false;
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    Coordinate& coordinate = parameters.coordinate(i);
    const bool held = hold[i] || (only_add && coordinate.held);
    changed |= held != coordinate.held;
    coordinate.held = held;
  }
  return changed;
}

// Weighs the priors of effects against the rows as these scatter here; true where that moves them.
bool WeighEffectPriors(const NormalEquations& equations, ParameterSet* parameters) {
  if (!AnyEffectPrior(*parameters)) return false;
  const FittedRows here = RowsOf(equations, *parameters, parameters->EstimatedCoordinates());
  if (!here.rows.valid) return false;
  const double scale = ResidualScale(SolveLinearization(here.rows), here.rows.num_columns(), here.equations);
  return ScaleEffectPriors(std::max(kExactFit, scale), parameters);
}

// Gauss-Newton step that is left, in standard deviations.
double RemainingStep(const LinearSolution& solution, double noise_scale) {
  if (!solution.full_rank) return std::numeric_limits<double>::infinity();
  const Eigen::ArrayXd sigmas = solution.covariance.diagonal().array().sqrt() * noise_scale;
  return solution.step.size() == 0 ? 0.0 : (solution.step.array().abs() / sigmas).maxCoeff();
}

// What the last Gauss-Newton step says of the optimum.
struct Certificate {
  bool valid = false;  // the equilibria converge
  bool full_rank = false;
  bool exact_fit = false;  // nothing left to explain
  int columns = 0;
  double step = std::numeric_limits<double>::infinity();  // that was left, standard deviations
};

// Columns that rest on their bound, or would end there: they have no say in the optimum. free: without bounds.
std::vector<int> PinnedColumns(const Linearization& here, const LinearSolution& free, const ParameterSet& parameters) {
  const auto lower = [&](int c) { return parameters.coordinates()[here.columns[c]].lower; };
  std::vector<int> resting;
  bool is_inside = free.full_rank;
  for (int c = 0; c < here.num_columns(); ++c) {
    const double value = parameters.Value(here.columns[c]);
    if (value <= lower(c)) resting.push_back(c);
    is_inside = is_inside && value + free.step[c] >= lower(c);
  }
  if (is_inside) return {};
  const BoundedStep bounded = SolveBounded(here, parameters);
  return bounded.valid ? bounded.pinned : resting;
}

// What the columns that are not pinned are left with once those that are have moved onto their bounds: r + J_p d_p.
Linearization InsideBounds(const Linearization& here, const std::vector<int>& kept, const Eigen::VectorXd& to_bounds) {
  Linearization inside = here;
  inside.residual += here.jacobian * to_bounds;
  inside.jacobian = here.jacobian(Eigen::all, kept);
  inside.columns.assign(kept.size(), 0);
  return inside;
}

// One bounded Gauss-Newton step: certificate before it, delta per column.
Eigen::VectorXd BoundedGaussNewton(const CalibrationProblem& problem, const FittedRows& fitted,
                                   const ParameterSet& parameters, Certificate* certificate) {
  const Linearization& here = fitted.rows;
  LinearSolution solution = SolveLinearization(here);
  const std::vector<int> pinned = PinnedColumns(here, solution, parameters);
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(here.num_columns());
  for (const int c : pinned) {
    delta[c] = std::min(0.0, parameters.coordinates()[here.columns[c]].lower - parameters.Value(here.columns[c]));
  }
  std::vector<int> kept;
  for (int c = 0; c < here.num_columns(); ++c) {
    if (std::find(pinned.begin(), pinned.end(), c) == pinned.end()) kept.push_back(c);
  }
  if (!pinned.empty()) solution = SolveLinearization(InsideBounds(here, kept, delta));
  certificate->columns = static_cast<int>(kept.size());
  certificate->full_rank = solution.full_rank;
  const double scale = std::max(1e-12, ScaleOfRows(problem, solution, certificate->columns, fitted.equations));
  certificate->exact_fit = here.residual.norm() < kExactFit * std::sqrt(fitted.equations);
  certificate->step = RemainingStep(solution, scale);
  for (const int c : pinned) {
    certificate->step = std::max(certificate->step, std::abs(delta[c]) * here.jacobian.col(c).norm() / scale);
  }
  if (solution.full_rank && !kept.empty()) delta(kept) = solution.step;
  return delta;
}

// How much of each Gauss-Newton step d is gone. Near the optimum, with H = J'J + S and S what the residuals' own
// curvature adds (a load's centre of gravity times the compliances that it bends, both open), a step of lambda d leaves
// the next one
//
//   d' = (1 - lambda mu) d,   mu: of (J'J)^-1 H along d
//
// Where mu exceeds 2 whole steps swing farther each time: from the ratio of two of them mu is known, and 1 / mu
// arrives.
class Relaxation {
 public:
  // weights: of each column, of which |weight d| is commensurate.
  double NextFactor(const Eigen::VectorXd& step, const Eigen::VectorXd& weights) {
    const Eigen::VectorXd here = step.cwiseProduct(weights);
    if (before_.size() == here.size() && before_.squaredNorm() > 0.0) {
      const double ratio = here.dot(before_) / before_.squaredNorm(), mu = (1.0 - ratio) / factor_;
      if (ratio < kSwings || factor_ < 1.0) factor_ = mu > 1.0 ? std::max(kLeast, 1.0 / mu) : 1.0;
    }
    before_ = here;
    return factor_;
  }

 private:
  static constexpr double kSwings = -0.5;  // mu > 1.5; with a smaller swing whole steps are there as soon
  static constexpr double kLeast = 0.05;   // mu = 20: beyond, J'J is no approximation of H any more
  Eigen::VectorXd before_;
  double factor_ = 1.0;
};

// Ceres stops where the cost cannot decide (1e-5 standard deviations away), and
// with joint deviations at the mode instead of the marginal optimum; the
// gradient still can: a few Gauss-Newton steps bring 1e-7.
Certificate Polish(const CalibrationProblem& problem, const NormalEquations& equations, double reach, int steps,
                   ParameterSet* parameters) {
  Certificate certificate;
  Relaxation relaxation;
  for (int i = 0; i < steps && certificate.step >= kConvergedSteps; ++i) {
    const FittedRows here = RowsOf(equations, *parameters, parameters->EstimatedCoordinates());
    certificate.valid = here.rows.valid;
    if (!certificate.valid) return certificate;
    Eigen::VectorXd delta = BoundedGaussNewton(problem, here, *parameters, &certificate);
    if (certificate.exact_fit || !(certificate.step < reach)) return certificate;
    // Farther off, steps that swing are those of a bent valley, and what is measured so poorly stays where it was.
    if (reach <= kPolishReach) delta *= relaxation.NextFactor(delta, here.rows.jacobian.colwise().norm().transpose());
    const ParameterSet before = *parameters;
    Move(here.rows.columns, delta, 1.0, parameters);
    // 1e-5 standard deviations change columns by less than 1e-10 of themselves.
    if (certificate.step < kConvergedSteps) equations.KeepMoved(before, here.rows.columns, delta, *parameters);
  }
  return certificate;
}

// Where bounds rule, Ceres' projected steps stop early; damped bounded Gauss-Newton steps go on from there.
Certificate PolishAtBounds(const CalibrationProblem& problem, const NormalEquations& equations,
                           const Certificate& before, ParameterSet* parameters) {
  bool any_bound = false;
  for (const int i : parameters->EstimatedCoordinates()) {
    any_bound |= std::isfinite(parameters->coordinates()[i].lower);
  }
  if (!any_bound || !before.valid || before.exact_fit || before.step < kConvergedSteps) return before;
  RefitOptions options;
  options.steps.max_steps = kMaxBoundedSteps;
  ParameterSet refitted = RefitFrom(problem, *parameters, options).parameters;
  const Certificate after = Polish(problem, equations, kPolishReach, kMaxPolishSteps, &refitted);
  if (!(after.step < before.step)) return before;
  *parameters = refitted;
  return after;
}

void FailEquilibrium(const CalibrationProblem& problem, Estimate* estimate) {
  estimate->status = Status::kEquilibriumDiverged;
  estimate->message = FoldedInWords(problem, estimate->parameters);
}

void Finish(const CalibrationProblem& problem, const NormalEquations& equations, const MinimizeSummary& minimized,
            Estimate* estimate) {
  Certificate certificate = Polish(problem, equations, kPolishReach, kMaxPolishSteps, &estimate->parameters);
  certificate = PolishAtBounds(problem, equations, certificate, &estimate->parameters);
  if (!certificate.valid) return FailEquilibrium(problem, estimate);
  if (certificate.columns == 0) {
    estimate->status = Status::kSingular;
    estimate->message = EverythingHeld();
  } else if (!certificate.full_rank) {
    estimate->status = Status::kSingular;
    estimate->message = SingularAtOptimum();
  } else if (!minimized.usable || !(certificate.step < kConvergedSteps || certificate.exact_fit)) {
    estimate->status = Status::kNoConvergence;
    estimate->message = StoppedBefore(certificate.step, minimized.message);
  } else if (!estimate->identifiability.unidentifiable.empty()) {
    estimate->status = Status::kConvergedWithHeldParameters;
    estimate->message = ConvergedWithHeld(estimate->identifiability.unidentifiable.size());
  } else {
    estimate->status = Status::kConverged;
    estimate->message = Converged();
  }
}

// Between the rounds of an outer loop the start is near, and Gauss-Newton on the marginal rows is there in a few
// steps. With tight readings and loose joints it also goes where Ceres creeps: the valley of a visit's deviations
// bends by more than the instrument's sigma. Where much is left unmodelled the steps shrink by a constant factor; a
// dozen passes cost less than one factorization of all deviations, so it goes on while a dozen at least halve the step.
bool SolveFromNear(const CalibrationProblem& problem, const NormalEquations& equations, ParameterSet* parameters) {
  ParameterSet trial = *parameters;
  double before = kWarmReach;
  while (true) {
    const Certificate certificate = Polish(problem, equations, kWarmReach, kMaxWarmSteps, &trial);
    if (!certificate.valid || !certificate.full_rank) return false;
    if (certificate.step < kConvergedSteps) break;
    if (!(certificate.step < 0.5 * before)) return false;
    before = certificate.step;
  }
  *parameters = trial;
  return true;
}

// One solve of what is not held, on sums, or on sparse rows where many stations or markers hardly meet. Where joints
// deviate, the solution for exact joints is near enough for Gauss-Newton on the marginal rows; where it is not, the
// deviations are estimated along (bundle adjustment). `exact_joints`: equations without deviations.
MinimizeSummary Solve(const CalibrationProblem& problem, const ResidualSelection& residuals,
                      const NormalEquations& equations, const NormalEquations& exact_joints,
                      const JointOptions& options, ParameterSet* parameters) {
  const bool is_sparse = problem.latent.empty() && StructureOf(problem, residuals, *parameters).IsSparserThanSums();
  MinimizeSummary near;
  near.usable = near.converged = true;
  if (options.aligned != nullptr && !is_sparse && SolveFromNear(problem, equations, parameters)) return near;
  MinimizeOptions minimize;
  minimize.max_iterations = options.max_iterations;
  minimize.num_threads = options.num_threads;
  if (residuals.granularity == CostGranularity::kMarker || is_sparse) {
    return MinimizeJointly(problem, residuals, minimize, parameters);
  }
  ParameterSet trial = *parameters;
  const MinimizeSummary summed = MinimizeSums(exact_joints, minimize, &trial);
  if (problem.latent.empty() || (summed.usable && SolveFromNear(problem, equations, &trial))) {
    *parameters = trial;
    return summed;
  }
  MinimizeSummary bundled = MinimizeJointly(problem, residuals, minimize, parameters);
  bundled.iterations += summed.iterations;
  return bundled;
}

// The same with what is held at rest. Where that does not converge, what is held stays where it is.
MinimizeSummary SolveAtRest(const CalibrationProblem& problem, const ResidualSelection& residuals,
                            const NormalEquations& equations, const NormalEquations& exact_joints,
                            const JointOptions& options, const ParameterSet& aligned, ParameterSet* parameters) {
  const auto solve = [&](ParameterSet* values) {
    return Solve(problem, residuals, equations, exact_joints, options, values);
  };
  if (HeldCoordinates(*parameters).empty()) return solve(parameters);
  const FittedRows here = RowsOf(equations, *parameters, RequestedCoordinates(*parameters));
  if (!here.rows.valid) return solve(parameters);
  // As the rows scatter, whatever sigma is stated: with another sigma what is held rests at the same place.
  const double scale = ResidualScale(SolveLinearization(here.rows), here.rows.num_columns(), here.equations);
  ParameterSet released = ReleaseHeld(problem, *parameters, aligned, here.rows, scale);
  const MinimizeSummary summary = solve(&released);
  if (!summary.usable) return solve(parameters);
  ParameterSet polished = released;  // along what is hardly measured Ceres stops early
  const Certificate certificate = Polish(problem, equations, kWarmReach, kMaxPolishSteps, &polished);
  const bool arrived = certificate.valid && certificate.full_rank && certificate.step < kConvergedSteps;
  *parameters = HoldAgain(*parameters, arrived ? polished : released);
  return summary;
}

}  // namespace

double AlignNominal(const CalibrationProblem& problem, ParameterSet* parameters) {
  const double misfit = FindStartingValues(problem, problem.CalibrationObservations(), parameters);
  DropImplausibleTie(parameters);
  return misfit;
}

void CheckOptions(const JointOptions& options) {
  CheckIn(allowed::kIterations, options.max_iterations, "JointOptions.max_iterations");
  CheckIn(allowed::kThreads, options.num_threads, "JointOptions.num_threads");
}

namespace {

// What is fitted, put side by side once.
struct Fitted {
  Fitted(const CalibrationProblem& problem, const JointOptions& options)
      : residuals(FittedResiduals(problem, kFallbackSigma)),
        equations(problem, residuals.observations, residuals.noise, LatentTreatment::kMarginalise,
                  options.num_threads) {
    residuals.granularity = options.granularity;
    if (problem.latent.empty()) return;
    without_deviations.emplace(problem, residuals.observations, residuals.noise, LatentTreatment::kIgnore,
                               options.num_threads);
  }
  const NormalEquations& exact_joints() const { return without_deviations ? *without_deviations : equations; }

  ResidualSelection residuals;
  NormalEquations equations;
  std::optional<NormalEquations> without_deviations;  // where joints have some
};

Estimate EstimateFitted(const CalibrationProblem& problem, const Fitted& fitted, const ParameterSet& start_values,
                        const JointOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Estimate estimate;
  estimate.parameters = start_values;
  DropImplausibleTie(&estimate.parameters);
  estimate.aligned = options.aligned != nullptr ? *options.aligned : estimate.parameters;

  const ResidualSelection& residuals = fitted.residuals;
  const NormalEquations& equations = fitted.equations;
  WeighEffectPriors(equations, &estimate.parameters);
  DecideHeld(problem, equations, /*only_add=*/false, /*at_start=*/true, &estimate);

  MinimizeSummary minimized;
  for (int round = 0; round < kMaxHoldRounds; ++round) {
    ReportStage(options, "solving for " + std::to_string(estimate.parameters.EstimatedCoordinates().size()) +
                             " unknowns on " + std::to_string(residuals.observations.size()) + " observations");
    minimized = SolveAtRest(problem, residuals, equations, fitted.exact_joints(), options, estimate.aligned,
                            &estimate.parameters);
    estimate.iterations += minimized.iterations;
    const bool effects_move = WeighEffectPriors(equations, &estimate.parameters);
    const bool moves = WeighSpringTie(&estimate.parameters) || effects_move;
    if (!DecideHeld(problem, equations, /*only_add=*/round >= kFreshRounds, /*at_start=*/false, &estimate) && !moves) {
      break;
    }
  }
  Finish(problem, equations, minimized, &estimate);
  estimate.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (IsUsable(estimate.status) && options.judge) {
    ReportStage(options, "intervals, identifiability and hold-out");
    ComputeStatistics(problem, equations, &estimate);
    AddLoadRemedies(problem, &estimate);
    AddMarkerRemedies(problem, &estimate);
  }
  return estimate;
}

}  // namespace

Estimate EstimateJointly(const CalibrationProblem& problem, const JointOptions& options) {
  CheckOptions(options);
  ReportStage(options, AligningNominal());
  const Fitted fitted(problem, options);
  ParameterSet start = problem.parameters;
  FindStartingValues(problem, fitted.exact_joints(), &start);
  DropImplausibleTie(&start);
  if (options.fitted != nullptr) *options.fitted = fitted.equations.shared_batches();
  return EstimateFitted(problem, fitted, start, options);
}

Estimate EstimateFrom(const CalibrationProblem& problem, const ParameterSet& start, const JointOptions& options) {
  CheckOptions(options);
  return EstimateFitted(problem, Fitted(problem, options), start, options);
}

}  // namespace sagitta
