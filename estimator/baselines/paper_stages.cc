#include "estimator/baselines/paper_stages.h"

#include <Eigen/QR>

namespace sagitta {
namespace {

// T_robot(q, theta, Pi) of every listed observation: p_robot, R_robot of eq. (13),
// deflections theta at the current base. False when an equilibrium diverges.
bool RobotPoses(const StageContext& context, const ParameterSet& parameters, std::vector<Pose<double>>* poses) {
  const std::vector<double> theta = parameters.ModelValues();
  int evaluated = -1;
  for (size_t k = 0; k < context.observations.size(); ++k) {
    const int shot = context.observation(k).shot;
    if (shot == evaluated) {
      poses->push_back(poses->back());
      continue;
    }
    const Equilibrium equilibrium = context.problem.model().Equilibrate(
        context.problem.shot_inputs()[shot], theta.data(), parameters.BaseInStation(context.shot(k).station).rotation);
    if (!equilibrium.converged) return false;
    poses->push_back(equilibrium.state.frames.back());
    evaluated = shot;
  }
  return true;
}

// The unknowns of eq. (15): p_base and r_base per station, u_tool per marker.
struct StageOneSolution {
  std::vector<Vector3<double>> p_base, r_base, u_tool;
};

// Eq. (12) and (16), whitened, solved as eq. (15), on the points as measured or
// pulled back through the current base.
bool SolveStageOne(const StageContext& context, const StageState& state, bool pull_back, StageOneSolution* solution) {
  const int stations = state.parameters.num_stations();
  const int markers = state.parameters.num_markers();
  std::vector<Pose<double>> robot;
  if (!RobotPoses(context, state.parameters, &robot)) return false;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 * robot.size(), 6 * stations + 3 * markers);
  Eigen::VectorXd b(a.rows());
  for (size_t k = 0; k < robot.size(); ++k) {
    const Observation& observation = context.observation(k);
    const int station = context.shot(k).station;
    Pose<double> pull;  // identity: literal
    if (pull_back) pull = state.bases[station];
    const Vector3<double> pulled = pull.rotation.transpose() * (observation.point_in_station - pull.translation);
    const Matrix3<double> whiten = context.noise[k].inverse() * pull.rotation;
    a.block<3, 3>(3 * k, 6 * station) = whiten;
    a.block<3, 3>(3 * k, 6 * station + 3) = whiten * Skew(robot[k].translation).transpose();
    a.block<3, 3>(3 * k, 6 * stations + 3 * observation.marker) = whiten * robot[k].rotation;
    b.segment<3>(3 * k) = whiten * (pulled - robot[k].translation);
  }
  Eigen::VectorXd x;
  if (!SolveScaled(a, b, &x)) return false;
  for (int s = 0; s < stations; ++s) {
    solution->p_base.push_back(x.segment<3>(6 * s));
    solution->r_base.push_back(x.segment<3>(6 * s + 3));
  }
  for (int m = 0; m < markers; ++m) solution->u_tool.push_back(x.segment<3>(6 * stations + 3 * m));
  return true;
}

// p_tool = R_base^T u_tool, after eq. (16); the mean over stations, by rows.
void SetMarkers(const StageContext& context, const StageOneSolution& solution,
                const std::vector<Matrix3<double>>& rotations, StageState* state) {
  const int markers = state->parameters.num_markers();
  std::vector<Vector3<double>> sum(markers, Vector3<double>::Zero());
  std::vector<int> rows(markers, 0);
  for (size_t k = 0; k < context.observations.size(); ++k) {
    const int m = context.observation(k).marker;
    sum[m] += rotations[context.shot(k).station].transpose() * solution.u_tool[m];
    ++rows[m];
  }
  for (int m = 0; m < markers; ++m) {
    if (rows[m] > 0) state->parameters.SetMarkerPoint(m, sum[m] / rows[m]);
  }
}

}  // namespace

bool SolveScaled(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd* x) {
  if (a.rows() < a.cols()) return false;
  const Eigen::VectorXd scale = a.colwise().norm().cwiseMax(1e-300);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a * scale.cwiseInverse().asDiagonal());
  qr.setThreshold(1e-12);  // of normalised columns: rounding, as in canonical_rate.cc
  if (qr.rank() < a.cols()) return false;
  *x = qr.solve(b).cwiseQuotient(scale);
  return x->allFinite();
}

bool LiteralStageOne(const StageContext& context, StageState* state) {
  StageOneSolution solution;
  if (!SolveStageOne(context, *state, false, &solution)) return false;
  std::vector<Matrix3<double>> rotations;
  for (size_t s = 0; s < solution.r_base.size(); ++s) {
    rotations.push_back(Skew(solution.r_base[s]) + Matrix3<double>::Identity());  // Eq. (9)
    state->bases[s] = {rotations[s], solution.p_base[s]};
    state->parameters.SetBaseInStation(s, {RotationFromVector(solution.r_base[s]), solution.p_base[s]});
  }
  SetMarkers(context, solution, rotations, state);
  return true;
}

bool RelinearisedStageOne(const StageContext& context, StageState* state) {
  StageOneSolution solution;
  if (!SolveStageOne(context, *state, true, &solution)) return false;
  std::vector<Matrix3<double>> rotations;
  for (size_t s = 0; s < solution.r_base.size(); ++s) {
    rotations.push_back(RotationFromVector(solution.r_base[s]));
    const Pose<double>& base = state->bases[s];
    state->bases[s] = {base.rotation * rotations[s], base * solution.p_base[s]};
    state->parameters.SetBaseInStation(s, state->bases[s]);
  }
  SetMarkers(context, solution, rotations, state);
  return true;
}

bool LiteralStageTwo(const StageContext& context, StageState* state) {
  if (context.geometry.empty()) return true;
  const CalibrationProblem& problem = context.problem;
  const std::vector<double> theta = state->parameters.ModelValues();
  std::vector<int> active;
  for (const int c : context.geometry) {
    active.push_back(state->parameters.blocks()[state->parameters.coordinates()[c].block].owner);
  }
  Eigen::MatrixXd a(3 * context.observations.size(), active.size());
  Eigen::VectorXd b(a.rows());
  std::vector<PointPrediction> prediction;
  for (size_t k = 0; k < context.observations.size(); ++k) {
    const Observation& observation = context.observation(k);
    const MarkerInFrame marker{problem.marker_frames()[observation.marker],
                               state->parameters.MarkerPoint(observation.marker)};
    if (!problem.model().Predict(problem.shot_inputs()[observation.shot], theta.data(), active,
                                 state->bases[context.shot(k).station], {marker}, &prediction)) {
      return false;
    }
    const Matrix3<double> whiten = context.noise[k].inverse();
    a.middleRows(3 * k, 3) = whiten * prediction[0].d_theta;
    b.segment<3>(3 * k) = whiten * (observation.point_in_station - prediction[0].point);
  }
  Eigen::VectorXd step;
  if (!SolveScaled(a, b, &step)) return false;
  for (size_t i = 0; i < active.size(); ++i) state->parameters.SetModelValue(active[i], theta[active[i]] + step[i]);
  return true;
}

void Stop(Status status, const std::string& message, Estimate* estimate) {
  estimate->status = status;
  estimate->message = message;
}

}  // namespace sagitta
