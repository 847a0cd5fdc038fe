#include "estimator/least_squares/minimize.h"

#include <ceres/solver.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "estimator/least_squares/condensed_cost.h"
#include "estimator/least_squares/constrained_blocks.h"
#include "estimator/least_squares/gauss_newton.h"
#include "estimator/least_squares/normal_equations.h"
#include "estimator/least_squares/structure.h"
#include "problems/interruption.h"
#include "problems/range.h"

namespace sagitta {
namespace {

// Above this size QR of the Jacobian costs more than it gains over the normal
// equations of the Jacobi-scaled problem.
constexpr double kDenseQrEntries = 2e6;
// Without the deviations the rest of a bundle is small: sparse and dense cost the same at 450 unknowns (BENCHMARKS.md,
// "Sparse factors").
constexpr int kFewGivenDeviations = 450;

std::shared_ptr<ceres::ParameterBlockOrdering> EliminateFirst(LatentBlocks& latents, const ceres::Problem& problem) {
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::vector<double>& block : latents) {
    if (problem.HasParameterBlock(block.data())) ordering->AddElementToGroup(block.data(), 0);
  }
  std::vector<double*> blocks;
  problem.GetParameterBlocks(&blocks);
  for (double* block : blocks) {
    if (!ordering->IsMember(block)) ordering->AddElementToGroup(block, 1);
  }
  return ordering;
}

// Each keeps digits or time where the others do not: rows by QR, many rows by their normal equations, unknowns that
// hardly meet by sparse factors.
ceres::LinearSolverType LinearSolverFor(const Structure& structure, bool has_latents) {
  if (has_latents) {
    const bool is_large = structure.unknowns >= kFewGivenDeviations;
    return is_large && structure.IsSparse() ? ceres::SPARSE_SCHUR : ceres::DENSE_SCHUR;
  }
  if (structure.IsSparse()) return ceres::SPARSE_NORMAL_CHOLESKY;
  return 1.0 * structure.rows * structure.unknowns >= kDenseQrEntries ? ceres::DENSE_NORMAL_CHOLESKY : ceres::DENSE_QR;
}

}  // namespace

void CheckOptions(const MinimizeOptions& options) {
  CheckIn(allowed::kIterations, options.max_iterations, "MinimizeOptions.max_iterations");
  CheckIn(allowed::kThreads, options.num_threads, "MinimizeOptions.num_threads");
}

namespace {

ceres::Solver::Options SolverOptions(const MinimizeOptions& options) {
  ceres::Solver::Options solver;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = options.num_threads;
  solver.logging_type = ceres::SILENT;
  // Ceres' own 1e4 and 1e16, or next to no damping: Levenberg-Marquardt adds 1 / radius of the diagonal of J'J.
  solver.initial_trust_region_radius = options.cautious ? 1e4 : 1e12;
  solver.max_trust_region_radius = 1e16;
  // What is left at 1e-9 of the cost is below a hundredth of a standard deviation up to 10^5 rows, and EstimateFrom
  // polishes; at 1e-12 the round-off of the equilibria keeps small problems searching. Starting values are not
  // polished.
  solver.function_tolerance = options.cautious ? 1e-12 : 1e-9;
  // These two are at the rounding of doubles, so that they end nothing earlier.
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-13;
  solver.linear_solver_type = ceres::DENSE_QR;
  return solver;
}

class StopWhenInterrupted : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return IsInterrupted() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }
};

// Ceres sees that the cost decides no more from a step that it evaluates and does not go. The sums where it stands say
// so before, r'r - r'J (J'J)^-1 J'r: what one more Gauss-Newton step would gain, and a pass over all rows is saved.
class StopAtOptimum : public ceres::IterationCallback {
 public:
  // parameters: where the solver puts each iteration's values.
  StopAtOptimum(const NormalEquations& equations, const ParameterSet& parameters, double tolerance)
      : equations_(equations),
        parameters_(parameters),
        columns_(parameters.EstimatedCoordinates()),
        tolerance_(tolerance) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    if (iteration.iteration > 0 && !iteration.step_is_successful) return ceres::SOLVER_CONTINUE;
    const NormalSums here = equations_.Sum(parameters_, columns_);  // they are kept
    if (!here.valid) return ceres::SOLVER_CONTINUE;
    const double left = Condense(here).residual.tail(1).squaredNorm();
    const bool gains_nothing = here.squared_residual() - left <= tolerance_ * here.squared_residual();
    return gains_nothing ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const NormalEquations& equations_;
  const ParameterSet& parameters_;
  const std::vector<int> columns_;
  const double tolerance_;  // of the sum of squares
};

// Ceres' steps keep a rotation's norm to round-off: many of them drift. Values that are as good as they are stay, and
// with them what was summed there.
void Normalise(ParameterSet* parameters) {
  constexpr double kDrift = 1e-14;  // of the square of the norm: a hundred roundings
  for (int s = 0; s < parameters->num_stations(); ++s) {
    const std::vector<double>& values = parameters->station_rotation(s).values;
    const double squares = Eigen::Map<const Eigen::Vector4d>(values.data()).squaredNorm();
    if (std::abs(squares - 1.0) > kDrift) parameters->SetBaseInStation(s, parameters->BaseInStation(s));
  }
}

// A start whose loads fold the arm has none. Ceres would log that as an error, whatever its logging_type, and a library
// prints nothing. Later steps to such a place are refused by their cost, without a word.
bool HasCost(const ceres::Solver::Options& solver, ceres::Problem& problem) {
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.num_threads = solver.num_threads;
  double cost = 0.0;
  return problem.Evaluate(evaluate, &cost, nullptr, nullptr, nullptr);
}

MinimizeSummary RunSolver(ceres::Solver::Options solver, ceres::Problem* problem, ParameterSet* parameters) {
  if (!HasCost(solver, *problem)) {
    MinimizeSummary folded;
    folded.message = "Residual and Jacobian evaluation failed.";
    return folded;
  }
  StopWhenInterrupted stop;
  solver.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, problem, &summary);
  CheckInterruption();
  MinimizeSummary result;
  result.usable = summary.IsSolutionUsable();
  result.converged = summary.termination_type == ceres::CONVERGENCE || summary.termination_type == ceres::USER_SUCCESS;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.initial_cost = summary.initial_cost;
  result.final_cost = summary.final_cost;
  result.seconds = summary.total_time_in_seconds;
  result.message = summary.message;
  Normalise(parameters);
  return result;
}

// From the solution without bounds: what lies beyond one is put on it, and Gauss-Newton goes on from there. False: it
// does not settle within a few steps.
bool StepOntoBounds(const NormalEquations& equations, ParameterSet* parameters, MinimizeSummary* summary) {
  GaussNewtonOptions options;
  options.max_steps = 8;
  options.tolerance = 1e-3;  // what is left is polished
  const std::vector<int> columns = parameters->EstimatedCoordinates();
  ParameterSet here = *parameters;
  Eigen::VectorXd onto = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(columns.size()));
  for (size_t c = 0; c < columns.size(); ++c) {
    const double below = here.coordinates()[columns[c]].lower - here.Value(columns[c]);
    if (below > 0.0) onto[static_cast<Eigen::Index>(c)] = below;
  }
  Move(columns, onto, 1.0, &here);
  const auto rows_at = [&](const ParameterSet& at, const std::vector<int>& of) -> FittedRows {
    const NormalSums sums = equations.Sum(at, of);
    return {Condense(sums), sums.rows};
  };
  GaussNewtonResult result = GaussNewton(rows_at, columns, here, options);
  summary->iterations += result.steps;
  if (!result.converged) return false;
  Move(columns, result.left.delta, 1.0, &result.parameters);
  summary->final_cost = 0.5 * result.cost();
  *parameters = std::move(result.parameters);
  return true;
}

// Ceres searches along every step of a problem with bounds, which costs as many evaluations again: the bounds come in
// only where the solution without them lies beyond one, and there by `step_onto` first, where it is given. What is
// inside is left where it is, if it creeps too: in a narrow valley the bounded search stops far above it.
MinimizeSummary WithBoundsWhereMet(const MinimizeOptions& options,
                                   const std::function<MinimizeSummary(bool bounded)>& minimize,
                                   const std::function<bool(ParameterSet*, MinimizeSummary*)>& step_onto,
                                   ParameterSet* parameters) {
  CheckOptions(options);
  const ParameterSet start = *parameters;
  MinimizeSummary free = minimize(false);
  if (free.usable && IsInside(*parameters)) return free;
  const std::vector<int> estimated = start.EstimatedCoordinates();
  const bool any_bound = std::any_of(estimated.begin(), estimated.end(),
                                     [&](int i) { return std::isfinite(start.coordinates()[i].lower); });
  if (!any_bound) return free;
  if (step_onto && free.usable && free.converged && step_onto(parameters, &free)) return free;
  *parameters = start;
  MinimizeSummary bounded = minimize(true);
  bounded.iterations += free.iterations;
  bounded.seconds += free.seconds;
  return bounded;
}

ceres::Problem::Options ProblemOptions() {
  ceres::Problem::Options options;
  options.disable_all_safety_checks = true;
  return options;
}

}  // namespace

MinimizeSummary MinimizeJointly(const CalibrationProblem& problem, const ResidualSelection& selection,
                                const MinimizeOptions& options, ParameterSet* parameters) {
  const bool has_latents = !problem.latent.empty() && !options.cautious;
  const Structure structure = StructureOf(problem, selection, *parameters);
  const auto minimize = [&](bool bounded) {
    ceres::Problem ceres_problem(ProblemOptions());
    LatentBlocks latents;
    AddToProblem(problem, selection, parameters, &ceres_problem, has_latents ? &latents : nullptr);
    if (!bounded) RemoveBounds(*parameters, &ceres_problem);
    ceres::Solver::Options solver = SolverOptions(options);
    solver.linear_solver_type = LinearSolverFor(structure, has_latents);
    // Bundle adjustment: the deviations of the visits are eliminated first.
    if (has_latents) solver.linear_solver_ordering = EliminateFirst(latents, ceres_problem);
    VLOG(1) << "joint solve: " << structure.unknowns << " unknowns, a reading touches "
            << std::lround(100.0 * structure.touched) << " % of them"
            << (has_latents ? "; the joints' deviations are eliminated first" : "") << ": "
            << ceres::LinearSolverTypeToString(solver.linear_solver_type);
    return RunSolver(solver, &ceres_problem, parameters);
  };
  return WithBoundsWhereMet(options, minimize, {}, parameters);
}

MinimizeSummary MinimizeSums(const NormalEquations& equations, const MinimizeOptions& options,
                             ParameterSet* parameters) {
  VLOG(1) << "joint solve: " << parameters->EstimatedCoordinates().size() << " unknowns on the sums of "
          << 3 * equations.batches().num_observations() << " rows: DENSE_QR";
  const auto minimize = [&](bool bounded) {
    ceres::Problem ceres_problem(ProblemOptions());
    AddCondensed(equations, parameters, &ceres_problem);
    if (!bounded) RemoveBounds(*parameters, &ceres_problem);
    MinimizeOptions own = options;
    own.num_threads = 1;  // the one cost has threads of its own
    ceres::Solver::Options solver = SolverOptions(own);
    StopAtOptimum at_optimum(equations, *parameters, solver.function_tolerance);
    if (!bounded) {
      solver.callbacks.push_back(&at_optimum);
      solver.update_state_every_iteration = true;
    }
    return RunSolver(std::move(solver), &ceres_problem, parameters);
  };
  const auto step_onto = [&equations](ParameterSet* from, MinimizeSummary* summary) {
    return StepOntoBounds(equations, from, summary);
  };
  return WithBoundsWhereMet(options, minimize, step_onto, parameters);
}

}  // namespace sagitta
