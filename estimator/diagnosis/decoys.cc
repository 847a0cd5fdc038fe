#include "estimator/diagnosis/decoys.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>

namespace sagitta {
namespace {

constexpr int kBumps[] = {6, 12, 24};  // over the range: what is smooth at one width is not at another
constexpr int kPeriods = 24;
constexpr double kTwoPi = 6.283185307179586;

double MarginalGain(const ProjectedResidual& residual, const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd rest = residual.ProjectOff(columns);
  const double scale = rest.norm();
  if (scale <= 1e-9 * columns.norm() || scale == 0.0) return -1e300;
  rest /= scale;
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(rest, Eigen::ComputeThinU);
  const Eigen::VectorXd z = svd.matrixU().transpose() * residual.residual();
  double best = 0.0;
  for (double tau = 1.0; tau < 3e4; tau *= 2.0) {
    double gain = 0.0;
    for (int i = 0; i < z.size(); ++i) {
      const double t = std::pow(tau * svd.singularValues()[i], 2);
      gain += z[i] * z[i] * t / (1.0 + t) - std::log1p(t);
    }
    best = std::max(best, gain);
  }
  return best - std::log(static_cast<double>(residual.residual().size()));
}

// One scalar per 3 rows, from the shot of each observation.
Eigen::VectorXd PerRow(const CalibrationProblem& problem, const std::function<double(const ShotConditions&)>& value) {
  const std::vector<int> observations = problem.CalibrationObservations();
  Eigen::VectorXd rows(3 * observations.size());
  for (size_t k = 0; k < observations.size(); ++k) {
    const ShotInput& shot = problem.shot_inputs[problem.data.observations[observations[k]].shot];
    rows.segment<3>(3 * k).setConstant(value(shot.conditions));
  }
  return rows;
}

Eigen::MatrixXd Bumps(const Eigen::VectorXd& x, int count) {
  const double low = x.minCoeff(), high = x.maxCoeff(), spacing = (high - low) / (count - 1);
  Eigen::MatrixXd bumps(x.size(), count);
  for (int b = 0; b < count; ++b) {
    bumps.col(b) = (-0.5 * ((x.array() - (low + b * spacing)) / spacing).square()).exp();
  }
  return bumps;
}

// Where along x the fitted deviation is largest, for words.
std::string Range(const Eigen::VectorXd& x) {
  const double degree = 57.29577951308232;
  return std::to_string(std::lround(x.minCoeff() * degree)) + " to " +
         std::to_string(std::lround(x.maxCoeff() * degree)) + " deg";
}

void Keep(const Decoy& decoy, Decoy* best) {
  if (decoy.penalised > best->penalised) *best = decoy;
}

}  // namespace

Decoy BestDecoy(const DiagnosedModel& model) {
  const CalibrationProblem& problem = *model.problem;
  const ProjectedResidual residual(LinearizeEstimate(problem, model.estimate.parameters));
  const std::vector<Joint>& joints = problem.robot.chain.joints;
  const int n = static_cast<int>(joints.size());
  std::vector<Eigen::VectorXd> q, deviation;
  for (int j = 0; j < n; ++j) {
    q.push_back(PerRow(problem, [j](const ShotConditions& shot) { return shot.q[j]; }));
    // order 0: the cosine column is that of a constant joint deviation
    EffectSpec constant{"joint_harmonic", joints[j].name, {{"order", "0"}}, {}};
    deviation.push_back(CandidateColumns(problem, model.estimate.parameters, constant).col(0));
  }
  const double decoys = 2.0 * std::log(static_cast<double>(3 * n * n + n * n * (n - 1) / 2));
  Decoy best;
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < n; ++k) {
      if (q[k].maxCoeff() - q[k].minCoeff() < 1e-6) continue;
      for (const int count : kBumps) {
        Decoy decoy{"smooth", joints[k].name, joints[j].name, "", 0.0, deviation[j].asDiagonal() * Bumps(q[k], count)};
        decoy.penalised = MarginalGain(residual, decoy.columns) - decoys;
        decoy.words =
            "a smooth deviation of " + joints[j].name + " that depends on " + joints[k].name + " (" + Range(q[k]) + ")";
        Keep(decoy, &best);
      }
    }
    for (int a = 0; a < n; ++a) {
      for (int b = a + 1; b < n; ++b) {
        Eigen::MatrixXd basis(q[a].size(), 7);
        basis << q[a].cwiseProduct(q[b]), (q[a] + q[b]).array().cos().matrix(), (q[a] + q[b]).array().sin().matrix(),
            (q[a] - q[b]).array().cos().matrix(), (q[a] - q[b]).array().sin().matrix(),
            q[a].array().cos().cwiseProduct(q[b].array()).matrix(),
            q[b].array().cos().cwiseProduct(q[a].array()).matrix();
        Decoy decoy{"periodic", joints[a].name + "*" + joints[b].name, joints[j].name, "",
                    0.0,        deviation[j].asDiagonal() * basis};
        decoy.penalised = MarginalGain(residual, decoy.columns) - decoys;
        decoy.words = "a deviation of " + joints[j].name + " that depends on " + joints[a].name + " and " +
                      joints[b].name + " together";
        Keep(decoy, &best);
      }
    }
  }
  const bool timed = std::all_of(problem.shot_inputs.begin(), problem.shot_inputs.end(),
                                 [](const ShotInput& shot) { return shot.conditions.has_time; });
  if (!timed) return best;
  const Eigen::VectorXd t = PerRow(problem, [](const ShotConditions& shot) { return shot.time; });
  const double span = t.maxCoeff() - t.minCoeff();
  if (span <= 0.0) return best;
  for (const std::string& station : problem.data.stations) {
    // the drift's x, y, z columns over time are those of a moving station
    EffectSpec drift{"station_drift", station, {}, {}};
    const Eigen::MatrixXd by_drift = CandidateColumns(problem, model.estimate.parameters, drift).leftCols(3);
    Eigen::MatrixXd shift = by_drift;
    for (int r = 0; r < shift.rows(); ++r)
      shift.row(r) = t[r] > 0.0 ? Eigen::RowVector3d(by_drift.row(r) / t[r]) : Eigen::RowVector3d::Zero();
    for (int p = 1; p <= kPeriods; ++p) {
      const double omega = kTwoPi * (0.5 * p) / span;
      Eigen::MatrixXd columns(t.size(), 6);
      columns << (omega * t).array().cos().matrix().asDiagonal() * shift,
          (omega * t).array().sin().matrix().asDiagonal() * shift;
      Decoy decoy{
          "time", station, station, "", MarginalGain(residual, columns) - 2.0 * std::log(static_cast<double>(kPeriods)),
          columns};
      decoy.words =
          "station " + station + " moves with a period of about " + std::to_string(std::lround(kTwoPi / omega)) + " s";
      Keep(decoy, &best);
    }
  }
  return best;
}

}  // namespace sagitta
