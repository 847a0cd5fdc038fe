#include "estimator/least_squares/minimize.h"

#include <ceres/solver.h>
#include <glog/logging.h>

#include <memory>
#include <vector>

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

}  // namespace

bool MinimizeOptions::IsValid(std::string* error) const {
  if (max_iterations < 1) *error = "max_iterations must be at least 1";
  if (num_threads < 1) *error = "num_threads must be at least 1";
  return max_iterations >= 1 && num_threads >= 1;
}

MinimizeSummary MinimizeJointly(const CalibrationProblem& problem, const ResidualSelection& selection,
                                const MinimizeOptions& options, ParameterSet* parameters) {
  std::string error;
  CHECK(options.IsValid(&error)) << error;
  ceres::Problem::Options problem_options;
  problem_options.disable_all_safety_checks = true;
  ceres::Problem ceres_problem(problem_options);
  LatentBlocks latents;
  const bool has_latents = !problem.latent.empty() && !options.cautious;
  AddToProblem(problem, selection, parameters, &ceres_problem, has_latents ? &latents : nullptr);

  ceres::Solver::Options solver;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = options.num_threads;
  solver.logging_type = ceres::SILENT;
  solver.initial_trust_region_radius = options.cautious ? 1e4 : 1e12;
  solver.max_trust_region_radius = 1e16;
  solver.function_tolerance = 1e-12;  // the equilibria leave 1e-12 of round-off; EstimateFrom polishes
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-13;
  const double entries = 3.0 * selection.observations.size() * parameters->EstimatedCoordinates().size();
  solver.linear_solver_type = entries < kDenseQrEntries ? ceres::DENSE_QR : ceres::DENSE_NORMAL_CHOLESKY;
  if (has_latents) {
    // Bundle adjustment: the deviations of the visits are eliminated first.
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    solver.linear_solver_ordering = EliminateFirst(latents, ceres_problem);
  }

  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);

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

}  // namespace sagitta
