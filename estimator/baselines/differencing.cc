#include "estimator/baselines/differencing.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <tuple>

#include "estimator/baselines/damped_step.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/noise/residual_noise.h"
#include "estimator/report/baselines_words.h"
#include "estimator/statistics/ascending.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr int kMaxIterations = 200;                // a guard: a bent valley halves the step, 2^-200
constexpr double kConvergedDifferenceStep = 1e-7;  // standard deviations

// The points of one visit that are used, and the matrix that forms their differences.
struct VisitDifferences {
  std::vector<int> rows;       // of the linearization, three per point
  Eigen::MatrixXd difference;  // D, one row per difference and axis
  Eigen::MatrixXd roots;       // S of the points, block by block
};

struct DifferenceContext {
  const CalibrationProblem& problem;
  std::vector<int> observations;
  NoiseRoots noise;
  std::vector<VisitDifferences> visits;
  int num_differences = 0;
};

// Positions in `observations` of one visit by station and marker: unloaded first, loaded second.
using OfMarker = std::map<std::pair<int, int>, std::pair<std::vector<int>, std::vector<int>>>;

// A difference on one axis: position in the visit's rows, factor.
using Terms = std::vector<std::pair<int, double>>;

// Loaded points minus the mean of the unloaded ones, weighted by their variances on the axis.
void AddDifferences(const std::vector<int>& unloaded, const std::vector<int>& loaded, const NoiseRoots& noise,
                    std::vector<int>* points, std::vector<Terms>* differences) {
  const int first = static_cast<int>(points->size());
  points->insert(points->end(), unloaded.begin(), unloaded.end());
  points->insert(points->end(), loaded.begin(), loaded.end());
  const int count = static_cast<int>(unloaded.size());
  for (int axis = 0; axis < 3; ++axis) {
    Terms mean;
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
      // Mean of the unloaded ones with weights 1 / sigma^2, which has the least variance.
      const double weight = 1.0 / noise[unloaded[i]].row(axis).squaredNorm();
      mean.emplace_back(3 * (first + i) + axis, -weight);
      sum += weight;
    }
    for (auto& [position, factor] : mean) factor /= sum;
    for (size_t i = 0; i < loaded.size(); ++i) {
      differences->push_back(mean);
      differences->back().emplace_back(3 * (first + count + static_cast<int>(i)) + axis, 1.0);
    }
  }
}

VisitDifferences DifferencesOf(const OfMarker& by_marker, const NoiseRoots& noise) {
  std::vector<int> points;
  std::vector<Terms> differences;
  for (const auto& [key, lists] : by_marker) {
    if (lists.first.empty() || lists.second.empty()) continue;
    AddDifferences(lists.first, lists.second, noise, &points, &differences);
  }
  VisitDifferences visit;
  visit.roots.setZero(3 * points.size(), 3 * points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    visit.roots.block<3, 3>(3 * i, 3 * i) = noise[points[i]];
    for (int axis = 0; axis < 3; ++axis) visit.rows.push_back(3 * points[i] + axis);
  }
  visit.difference.setZero(differences.size(), visit.rows.size());
  for (size_t i = 0; i < differences.size(); ++i) {
    for (const auto& [position, factor] : differences[i]) visit.difference(i, position) = factor;
  }
  return visit;
}

DifferenceContext MakeDifferenceContext(const CalibrationProblem& problem) {
  DifferenceContext context{problem, problem.CalibrationObservations(), {}, {}};
  context.noise = ObservationNoise(problem, context.observations, kFallbackSigma);
  std::map<std::pair<int, std::string>, OfMarker> visits;
  for (size_t k = 0; k < context.observations.size(); ++k) {
    const Observation& observation = problem.data().observations[context.observations[k]];
    const Shot& shot = problem.data().shots[observation.shot];
    auto& lists = visits[{shot.configuration, shot.visit}][{shot.station, observation.marker}];
    (IsLoaded(shot) ? lists.second : lists.first).push_back(static_cast<int>(k));
  }
  for (const auto& [key, by_marker] : visits) {
    VisitDifferences visit = DifferencesOf(by_marker, context.noise);
    context.num_differences += static_cast<int>(visit.difference.rows());
    if (visit.difference.rows() > 0) context.visits.push_back(std::move(visit));
  }
  return context;
}

// Whitened differences, their Jacobian, then the priors.
Linearization LinearizeDifferences(const DifferenceContext& context, const ParameterSet& parameters,
                                   const std::vector<int>& columns) {
  const Linearization points =
      Linearize(context.problem, parameters, context.observations, columns, context.noise, LatentTreatment::kIgnore);
  Linearization result;
  result.columns = columns;
  result.valid = points.valid;
  result.residual.resize(context.num_differences);
  result.jacobian.resize(context.num_differences, columns.size());
  int first = 0;
  for (const VisitDifferences& visit : context.visits) {
    const int n = static_cast<int>(visit.difference.rows());
    const Eigen::MatrixXd d = visit.difference * visit.roots;  // of whitened rows
    // cov(D S r) = D S S' D' + D S L L' S' D': differences that share an unloaded mean are correlated. Deviations of
    // the visit cancel to first order, in D S L.
    const Eigen::MatrixXd spread = d * points.latent(visit.rows, Eigen::all);
    const Eigen::LLT<Eigen::MatrixXd> root(Eigen::MatrixXd(d * d.transpose() + spread * spread.transpose()));
    const Eigen::VectorXd residual = d * Eigen::VectorXd(points.residual(visit.rows));
    const Eigen::MatrixXd jacobian = d * Eigen::MatrixXd(points.jacobian(visit.rows, Eigen::all));
    result.residual.segment(first, n) = root.matrixL().solve(residual);
    result.jacobian.middleRows(first, n) = root.matrixL().solve(jacobian);
    first += n;
  }
  AppendPriors(parameters, &result);
  return result;
}

bool IsElastic(const CalibrationProblem& problem, const ParameterSet& parameters, int coordinate) {
  const ParameterBlock& block = parameters.blocks()[parameters.coordinates()[coordinate].block];
  if (block.kind != BlockKind::kModelParameter) return false;
  const ParameterLaw law = problem.model().parameters()[block.owner].law;
  return law == ParameterLaw::kCompliance || law == ParameterLaw::kCompensator;
}

// Stage 1: what does not bend, from the unloaded rows.
Estimate EstimateUnloaded(const CalibrationProblem& problem) {
  CalibrationProblem unloaded = problem;
  for (Observation& observation : unloaded.mutable_data()->observations) {
    if (IsLoaded(unloaded.data().shots[observation.shot])) observation.excluded = true;
  }
  for (int i = 0; i < unloaded.parameters.num_coordinates(); ++i) {
    if (IsElastic(problem, unloaded.parameters, i)) unloaded.parameters.coordinate(i).free = false;
  }
  return EstimateJointly(unloaded);
}

// Stage 2; the size of the last step, in standard deviations.
StepOutcome FitDifferences(const DifferenceContext& context, const std::vector<int>& elastic, Estimate* estimate,
                           LinearSolution* solution) {
  const auto rows_at = [&](const ParameterSet& parameters, const std::vector<int>& columns) -> FittedRows {
    const Linearization here = LinearizeDifferences(context, parameters, columns);
    return {here, here.num_rows()};
  };
  for (int i = 0; i < kMaxIterations; ++i) {
    const ParameterSet before = estimate->parameters;
    const StepOutcome outcome = DampedStep(rows_at, elastic, &estimate->parameters);
    if (outcome != StepOutcome::kTaken) return outcome;
    ++estimate->iterations;
    *solution = SolveLinearization(LinearizeDifferences(context, estimate->parameters, elastic));
    if (!solution->full_rank) continue;  // a spring on a joint still rigid
    double step = 0.0;
    for (size_t c = 0; c < elastic.size(); ++c) {
      const double moved = estimate->parameters.Value(elastic[c]) - before.Value(elastic[c]);
      step = std::max(step, std::abs(moved) / std::sqrt(solution->covariance(c, c)));
    }
    if (step < kConvergedDifferenceStep) return StepOutcome::kTaken;
  }
  return solution->full_rank ? StepOutcome::kNoDescent : StepOutcome::kSingular;
}

// Each stage determines its own: what does not bend the unloaded rows, the rest the differences given that.
void StateIntervals(const DifferenceContext& context, const std::vector<int>& elastic, const LinearSolution& solution,
                    const Estimate& unloaded, Estimate* estimate) {
  const CalibrationProblem& problem = context.problem;
  const int dof = std::max(1, context.num_differences - static_cast<int>(elastic.size()));
  const bool is_stated = problem.sigma_is_stated();
  const double variance = is_stated ? 1.0 : solution.residual_norm_squared / dof;
  const auto p = static_cast<long>(estimate->estimated.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(p, p);
  Eigen::VectorXd interval_dof = Eigen::VectorXd::Constant(p, is_stated ? kInfinity : dof);
  std::vector<size_t> places;  // in the estimate, of the unloaded rows' own
  for (const int coordinate : unloaded.estimated) places.push_back(PlaceIn(estimate->estimated, coordinate));
  covariance(places, places) = unloaded.covariance;
  interval_dof(places) = unloaded.interval_dof;
  places.clear();
  for (const int coordinate : elastic) places.push_back(PlaceIn(estimate->estimated, coordinate));
  covariance(places, places) = variance * solution.covariance;
  ReplaceCovariance(problem, covariance, interval_dof, estimate);
  estimate->warnings.push_back(DifferencesAssumeTheRestExact());
  const auto& spring = problem.robot().gravity_compensator;
  if ((spring && spring->preload) || problem.experiment().tool_mass > 0.0) {
    estimate->warnings.push_back(PreloadWentIntoGeometry());
  }
}

Estimate NotRun(const CalibrationProblem& problem, const std::string& why) {
  Estimate estimate;
  estimate.parameters = estimate.aligned = problem.parameters;
  estimate.status = Status::kNotRun;
  estimate.message = NotRunBecause(why);
  return estimate;
}

}  // namespace

Estimate EstimateByDifferencing(const CalibrationProblem& problem,
                                const std::function<void(const std::string&)>& progress) {
  const auto start = std::chrono::steady_clock::now();
  const DifferenceContext context = MakeDifferenceContext(problem);
  if (context.num_differences == 0) {
    return NotRun(problem, NoDifferences());
  }
  std::vector<int> elastic;
  for (const int i : problem.parameters.EstimatedCoordinates()) {
    if (IsElastic(problem, problem.parameters, i)) elastic.push_back(i);
  }
  if (elastic.empty()) return NotRun(problem, NothingElastic());
  if (progress) progress("differencing: geometry from the unloaded rows");
  Estimate estimate = EstimateUnloaded(problem);
  if (!IsUsable(estimate.status)) {
    estimate.message = "the unloaded rows alone: " + estimate.message;
    return estimate;
  }
  const Estimate unloaded = estimate;
  for (int i = 0; i < problem.parameters.num_coordinates(); ++i) {
    if (IsElastic(problem, problem.parameters, i)) {
      estimate.parameters.coordinate(i).free = problem.parameters.coordinates()[i].free;
    }
  }
  LinearSolution solution;
  const StepOutcome outcome = FitDifferences(context, elastic, &estimate, &solution);
  estimate.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (outcome != StepOutcome::kTaken) {
    estimate.status = outcome == StepOutcome::kSingular ? Status::kSingular : Status::kNoConvergence;
    if (outcome == StepOutcome::kEquilibriumDiverged) estimate.status = Status::kEquilibriumDiverged;
    estimate.message = StepOutcomeInWords(outcome);
    return estimate;
  }
  estimate.status = unloaded.status;
  estimate.message = std::to_string(context.num_differences) + " differences fitted";
  ComputeStatistics(problem, &estimate);
  if (!IsUsable(estimate.status)) return estimate;
  StateIntervals(context, elastic, solution, unloaded, &estimate);
  return estimate;
}

}  // namespace sagitta
