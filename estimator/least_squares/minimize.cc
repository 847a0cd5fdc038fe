#include "estimator/least_squares/minimize.h"

#include <ceres/solver.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "estimator/least_squares/interruption.h"

namespace sagitta {
namespace {

// Above this size QR of the Jacobian costs more than it gains over the normal
// equations of the Jacobi-scaled problem.
constexpr double kDenseQrEntries = 2e6;

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

void RemoveBounds(const ParameterSet& parameters, ceres::Problem* problem) {
  for (const Coordinate& coordinate : parameters.coordinates()) {
    double* values = const_cast<double*>(parameters.blocks()[coordinate.block].values.data());
    if (!coordinate.estimated() || !std::isfinite(coordinate.lower) || !problem->HasParameterBlock(values)) continue;
    problem->SetParameterLowerBound(values, coordinate.index_in_block, -std::numeric_limits<double>::max());
  }
}

class StopWhenInterrupted : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return IsInterrupted() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }
};

bool IsInside(const ParameterSet& parameters) {
  const std::vector<int> estimated = parameters.EstimatedCoordinates();
  return std::all_of(estimated.begin(), estimated.end(),
                     [&](int i) { return parameters.Value(i) >= parameters.coordinates()[i].lower; });
}

}  // namespace

bool MinimizeOptions::IsValid(std::string* error) const {
  if (max_iterations < 1) *error = "max_iterations must be at least 1";
  if (num_threads < 1) *error = "num_threads must be at least 1";
  return max_iterations >= 1 && num_threads >= 1;
}

namespace {

MinimizeSummary Minimize(const CalibrationProblem& problem, const ResidualSelection& selection,
                         const MinimizeOptions& options, bool bounded, ParameterSet* parameters) {
  ceres::Problem::Options problem_options;
  problem_options.disable_all_safety_checks = true;
  ceres::Problem ceres_problem(problem_options);
  LatentBlocks latents;
  const bool has_latents = !problem.latent.empty() && !options.cautious;
  AddToProblem(problem, selection, parameters, &ceres_problem, has_latents ? &latents : nullptr);
  if (!bounded) RemoveBounds(*parameters, &ceres_problem);

  ceres::Solver::Options solver;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = options.num_threads;
  solver.logging_type = ceres::SILENT;
  solver.initial_trust_region_radius = options.cautious ? 1e4 : 1e12;
  solver.max_trust_region_radius = 1e16;
  // What is left at 1e-9 of the cost is below a hundredth of a standard deviation up to 10^5 rows, and EstimateFrom
  // polishes; at 1e-12 the round-off of the equilibria keeps small problems searching. Starting values are not polished.
  solver.function_tolerance = options.cautious ? 1e-12 : 1e-9;
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-13;
  const double entries = 3.0 * selection.observations.size() * parameters->EstimatedCoordinates().size();
  solver.linear_solver_type = entries < kDenseQrEntries ? ceres::DENSE_QR : ceres::DENSE_NORMAL_CHOLESKY;
  if (has_latents) {
    // Bundle adjustment: the deviations of the visits are eliminated first.
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    solver.linear_solver_ordering = EliminateFirst(latents, ceres_problem);
  }

  StopWhenInterrupted stop;
  solver.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);
  CheckInterruption();

  MinimizeSummary result;
  result.usable = summary.IsSolutionUsable();
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.initial_cost = summary.initial_cost;
  result.final_cost = summary.final_cost;
  result.seconds = summary.total_time_in_seconds;
  result.message = summary.message;
  for (int s = 0; s < parameters->num_stations(); ++s) {
    parameters->SetBaseInStation(s, parameters->BaseInStation(s));  // unit norm against drift
  }
  return result;
}

}  // namespace

// Ceres searches along every step of a problem with bounds, which costs as many evaluations again: the bounds come in
// only where the solution without them lies beyond one.
MinimizeSummary MinimizeJointly(const CalibrationProblem& problem, const ResidualSelection& selection,
                                const MinimizeOptions& options, ParameterSet* parameters) {
  std::string error;
  CHECK(options.IsValid(&error)) << error;
  const ParameterSet start = *parameters;
  const MinimizeSummary free = Minimize(problem, selection, options, /*bounded=*/false, parameters);
  if (free.usable && free.converged && IsInside(*parameters)) return free;
  const std::vector<int> estimated = start.EstimatedCoordinates();
  const bool any_bound = std::any_of(estimated.begin(), estimated.end(),
                                     [&](int i) { return std::isfinite(start.coordinates()[i].lower); });
  if (!any_bound) return free;
  *parameters = start;
  MinimizeSummary bounded = Minimize(problem, selection, options, /*bounded=*/true, parameters);
  bounded.iterations += free.iterations;
  bounded.seconds += free.seconds;
  return bounded;
}

}  // namespace sagitta
