#include "estimator/inspection/linear_state.h"

#include <algorithm>
#include <cmath>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/inspection/row_lint.h"
#include "estimator/least_squares/ceres_problem.h"
#include "problems/excitation.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr double kTypicalCompliance = 1e-6;  // rad/(N m): a spring on a rigid joint would show nothing
constexpr int kOutlierRounds = 3;            // what is far off is left out and the alignment repeated

// Nominal values; where a compensator is asked for, compliances that start at 0 get a typical size.
ParameterSet NominalValues(const CalibrationProblem& problem) {
  ParameterSet parameters = problem.parameters;
  bool spring = false;
  for (const Coordinate& coordinate : parameters.coordinates())
    spring |= coordinate.free && coordinate.kind == CoordinateKind::kCompensator;
  for (int i = 0; spring && i < parameters.num_model_parameters(); ++i) {
    const Coordinate& coordinate = parameters.coordinates()[parameters.model_parameter(i).first_coordinate];
    const bool rigid = problem.model().parameters()[i].law == ParameterLaw::kCompliance &&
                       parameters.Value(parameters.model_parameter(i).first_coordinate) == 0.0;
    if (rigid && coordinate.free) parameters.SetModelValue(i, kTypicalCompliance);
  }
  return parameters;
}

double ScaleOfResiduals(const CalibrationProblem& problem, const Linearization& linearization) {
  const LinearSolution solution = SolveLinearization(linearization);
  const double dof = linearization.num_rows() - linearization.num_columns();
  const double scale = dof > 0 ? std::sqrt(solution.residual_norm_squared / dof) : 1.0;
  return problem.sigma_is_stated() ? std::max(1.0, scale) : scale;
}

Linearization WithColumns(const Linearization& all, const std::vector<int>& lost) {
  std::vector<int> kept;
  for (int c = 0; c < all.num_columns(); ++c) {
    if (std::find(lost.begin(), lost.end(), c) == lost.end()) kept.push_back(c);
  }
  Linearization result = all;
  result.jacobian = all.jacobian(Eigen::all, kept);
  result.columns.clear();
  for (const int c : kept) result.columns.push_back(all.columns[c]);
  return result;
}

void LinearizeAt(LinearState* state) {
  const ResidualSelection residuals = FittedResiduals(state->problem, kUnstatedSigma);
  std::vector<int> requested;
  for (int i = 0; i < state->parameters.num_coordinates(); ++i) {
    if (state->parameters.coordinates()[i].free) requested.push_back(i);
  }
  state->all = Linearize(state->problem, state->parameters, residuals.observations, requested, residuals.noise);
  AppendPriors(state->parameters, &state->all);
  SetHoldLimits(state->problem, &state->parameters);
}

// `misfit` makes residuals meaningless: then the noise is as stated.
void DecideRank(bool misfit, LinearState* state) {
  state->scale = 1.0;
  for (int round = 0; round < 3; ++round) {  // the noise depends on what is kept
    state->lost = FindUnidentifiable(state->all, state->parameters, state->scale);
    state->estimated = WithColumns(state->all, state->lost.columns);
    if (!misfit) state->scale = ScaleOfResiduals(state->problem, state->estimated);
  }
}

// The nominal robot is rigid: aligned to the unloaded rows where these see every station and marker.
void AlignRigid(const CalibrationProblem& problem, ParameterSet* parameters) {
  CalibrationProblem unloaded = problem;
  std::vector<bool> station(problem.data().stations.size()), marker(problem.data().markers.size());
  for (Observation& observation : unloaded.mutable_data()->observations) {
    const Shot& shot = unloaded.data().shots[observation.shot];
    observation.excluded |= IsLoaded(shot);
    if (observation.excluded || unloaded.data().IsValidation(observation)) continue;
    station[shot.station] = marker[observation.marker] = true;
  }
  const auto all = [](const std::vector<bool>& seen) {
    return std::find(seen.begin(), seen.end(), false) == seen.end();
  };
  AlignNominal(all(station) && all(marker) ? unloaded : problem, parameters);
}

// Base, markers and geometry where one linear step puts them: a tilt of the base that only the arm's own errors make
// would excite axes that the loads do not.
void TakeLinearStep(LinearState* state) {
  const LinearSolution solution = SolveLinearization(state->estimated);
  if (!solution.full_rank || solution.step.size() == 0) return;
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(state->parameters.num_coordinates());
  for (int c = 0; c < state->estimated.num_columns(); ++c) {
    const int i = state->estimated.columns[c];
    const ParameterBlock& block = state->parameters.blocks()[state->parameters.coordinates()[i].block];
    const bool rigid = block.kind != BlockKind::kModelParameter ||
                       state->problem.model().parameters()[block.owner].law == ParameterLaw::kGeometry;
    if (rigid) delta[i] = solution.step[c];
  }
  state->parameters.Plus(delta);
  LinearizeAt(state);
  if (state->all.valid) DecideRank(false, state);
}

}  // namespace

LinearState Align(const CalibrationProblem& problem, bool misfit, std::vector<Finding>* findings) {
  LinearState state{problem, NominalValues(problem), {}, {}, 1.0, {}};
  const ResidualSelection rows = FittedResiduals(problem, kUnstatedSigma);
  std::vector<int> outliers;
  std::vector<Finding> found;
  for (int round = 0;; ++round) {
    AlignRigid(state.problem, &state.parameters);
    LinearizeAt(&state);
    if (!state.all.valid) break;
    DecideRank(misfit, &state);
    if (misfit || round == kOutlierRounds) break;
    // With the noise as stated: rows far off must not hold the columns that explain the others.
    const Unidentifiable lost = FindUnidentifiable(state.all, state.parameters, 1.0);
    const Linearization all =
        Linearize(problem, state.parameters, rows.observations, WithColumns(state.all, lost.columns).columns,
                  rows.noise, LatentTreatment::kIgnore);
    const Eigen::Matrix3Xd left = RobustLinearResiduals(all, rows.noise);
    const std::vector<int> now = GrossOutliers(left, all.num_columns());
    found = LintRows(problem, all, left);
    if (now == outliers) break;
    outliers = now;
    *state.problem.mutable_data() = problem.data();
    for (const int k : outliers) state.problem.mutable_data()->ExcludeRow(rows.observations[k]);
  }
  findings->insert(findings->end(), found.begin(), found.end());
  if (!misfit && state.all.valid) TakeLinearStep(&state);
  return state;
}

}  // namespace sagitta
