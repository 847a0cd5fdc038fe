#include "tools/reproduce/ablation.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>

#include "estimator/alignment/pose_registration.h"
#include "problems/simulation.h"

namespace sagitta {
namespace {

constexpr int kAblationConfigurations = 200;  // of validation: no figure hinges on the draw
constexpr double kOrientationWeight = 0.3;    // m/rad, as in the comparison of methods

// Rows repeated; k2 in one column where the compensator is not modelled.
Eigen::MatrixXd Columns(const ElasticRun& run, const ElasticScene& scene, int repeats, bool compensator) {
  const Eigen::MatrixXd all = ElasticColumns(*run.model, scene, run.columns);
  if (compensator) return all.replicate(repeats, 1);
  Eigen::MatrixXd serial(all.rows(), 5);
  serial << all.leftCols(5).rowwise().sum(), all.rightCols(4);
  return serial.replicate(repeats, 1);
}

// Least squares of k with columns of unit norm.
Eigen::VectorXd Solve(const Eigen::MatrixXd& rows, const Eigen::VectorXd& values) {
  const Eigen::VectorXd scale = rows.colwise().norm().cwiseInverse();
  return scale.cwiseProduct((rows * scale.asDiagonal()).colPivHouseholderQr().solve(values));
}

// Marker rows of every shot -> weighted (dp, dphi) about the flange: 6 rows per shot.
Eigen::MatrixXd ToPoses(const ElasticRun& run, const ElasticScene& scene, int repeats, const Eigen::MatrixXd& rows) {
  const int markers = static_cast<int>(scene.markers.size()), shots = static_cast<int>(scene.shots.size());
  Vector6 weight;
  weight << 1, 1, 1, kOrientationWeight, kOrientationWeight, kOrientationWeight;
  const std::vector<double> theta = run.model->NominalValues();
  std::vector<MarkerInFrame> points = scene.markers;
  points.push_back({run.model->chain().FlangeFrame(), Vector3<double>::Zero()});
  std::vector<PointPrediction> seen;
  Eigen::MatrixXd poses(6 * shots * repeats, rows.cols());
  for (int s = 0; s < shots; ++s) {
    run.model->Predict(ShotInput(scene.shots[s].conditions.q), theta.data(), {}, scene.base_in_station, points, &seen);
    Eigen::Matrix3Xd at(3, markers);
    for (int m = 0; m < markers; ++m) at.col(m) = seen[m].point;
    const Eigen::MatrixXd rigid = RigidColumns(at, seen[markers].point);
    const auto solver = rigid.householderQr();
    for (int r = 0; r < repeats; ++r) {
      const int block = r * shots + s;
      poses.middleRows(6 * block, 6) =
          weight.asDiagonal() * solver.solve(rows.middleRows(3 * markers * block, 3 * markers));
    }
  }
  return poses;
}

// The same load at random configurations, measured with the noise of the published ones.
struct AblationPlan {
  ElasticScene scene;
  Eigen::VectorXd measured;
};

AblationPlan HeuristicPlan(const ElasticRun& run, const ReproduceOptions& options, int repeats) {
  AblationPlan plan{run.scene, {}};
  const std::vector<Eigen::VectorXd> configurations =
      DrawConfigurations(run.model->chain(), static_cast<int>(run.scene.shots.size()), options.seed + 3000);
  for (size_t s = 0; s < configurations.size(); ++s) plan.scene.shots[s].conditions.q = configurations[s];
  plan.measured = TrueDeflections(*run.model, plan.scene).replicate(repeats, 1);
  NormalNumbers normal(options.seed + 3001);
  for (int i = 0; i < plan.measured.size(); ++i) plan.measured[i] += run.design.sigma[i] * normal();
  return plan;
}

}  // namespace

ElasticPrediction PredictValidation(const ElasticRun& run, bool model_is_complete, unsigned long long seed) {
  const int shots = static_cast<int>(run.validation.shots.size()),
            block = 3 * static_cast<int>(run.validation.markers.size());
  const int repeats = static_cast<int>(run.validation_measured.size()) / (shots * block);
  const Eigen::MatrixXd rows = Columns(run, run.validation, repeats, true);
  const double noise = run.design.sigma.squaredNorm() / run.design.sigma.size();
  Eigen::VectorXd calibration = run.measured, measured = run.validation_measured;
  if (model_is_complete) {
    NormalNumbers normal(seed);
    calibration = run.design.rows * run.truth;
    for (int i = 0; i < calibration.size(); ++i) calibration[i] += run.design.sigma[i] * normal();
    measured = rows * run.truth;
    for (int i = 0; i < measured.size(); ++i) measured[i] += std::sqrt(noise) * normal();
  }
  const Eigen::VectorXd residual =
      measured - rows * FitWeighted(run.design, calibration, KnownWeightMethods().front()).front().value;
  // Sandwich of eq. (8) as a full matrix: half' half.
  const Eigen::MatrixXd normal = run.design.rows.transpose() * run.design.rows;
  const Eigen::MatrixXd half =
      run.design.sigma.asDiagonal() * run.design.rows * normal.llt().solve(Eigen::MatrixXd::Identity(9, 9));
  ElasticPrediction prediction;
  prediction.coordinates = static_cast<int>(residual.size());
  for (int s = 0; s < shots; ++s) {
    Eigen::VectorXd of_shot(block * repeats);
    for (int r = 0; r < repeats; ++r)
      of_shot.segment(block * r, block) = residual.segment(block * (r * shots + s), block);
    prediction.residuals.push_back(AsPoints(of_shot));
    const double variance = (half * rows.middleRows(block * s, block).transpose()).squaredNorm() / block + noise;
    prediction.predicted.push_back(std::sqrt(variance));
    prediction.predicted_rms += variance / shots;
  }
  prediction.predicted_rms = std::sqrt(prediction.predicted_rms);
  prediction.rms = residual.norm() / std::sqrt(1.0 * residual.size());
  return prediction;
}

std::vector<AblationCase> RunAblation(Reproduction& reproduction) {
  const ElasticRun& run = reproduction.elastic();
  const int per_pass = static_cast<int>(3 * run.scene.markers.size() * run.scene.shots.size());
  const int repeats = static_cast<int>(run.measured.size()) / per_pass;
  ElasticScene validation = run.scene;
  const AppliedWrench load = run.scene.shots.front().wrenches.front();
  validation.shots.clear();
  for (const Eigen::VectorXd& q :
       DrawConfigurations(run.model->chain(), kAblationConfigurations, reproduction.options().seed + 6000)) {
    validation.shots.emplace_back(q);
    validation.shots.back().wrenches = {load};
  }
  const Eigen::VectorXd deflections = TrueDeflections(*run.model, validation);
  const AblationPlan plans[2] = {HeuristicPlan(run, reproduction.options(), repeats), {run.scene, run.measured}};
  std::vector<AblationCase> cases;
  for (int i = 0; i < 8; ++i) {
    AblationCase one;
    one.compensator = i & 1;
    one.markers = i & 2;
    one.optimal = i & 4;
    const AblationPlan& plan = plans[one.optimal ? 1 : 0];
    Eigen::MatrixXd rows = Columns(run, plan.scene, repeats, one.compensator);
    Eigen::MatrixXd values = plan.measured;
    if (!one.markers) {
      rows = ToPoses(run, plan.scene, repeats, rows);
      values = ToPoses(run, plan.scene, repeats, values);
    }
    const Eigen::VectorXd k = Solve(rows, values.col(0));
    const Eigen::Matrix3Xd before = AsPoints(deflections);
    const Eigen::Matrix3Xd after = AsPoints(deflections - Columns(run, validation, 1, one.compensator) * k);
    one.before = MeasureResiduals(before);
    one.after = MeasureResiduals(after);
    one.before_max_axis = before.rowwise().lpNorm<Eigen::Infinity>();
    one.after_max_axis = after.rowwise().lpNorm<Eigen::Infinity>();
    cases.push_back(one);
  }
  return cases;
}

void AddAblation(const std::vector<AblationCase>& cases, ReproducedTable* table) {
  for (const AblationCase& one : cases) {
    const std::string name = std::string(one.optimal ? "published poses" : "random poses") +
                             (one.markers ? ", markers" : ", full pose") + (one.compensator ? ", k2(q2)" : ", one k2") +
                             ": coordinate, distance RMS (factor)";
    table->State(name, "-",
                 Fixed(one.after.rms / kMillimetre, 2) + ", " + Fixed(one.after.distance_rms / kMillimetre, 2) +
                     " mm (" + Fixed(one.before.distance_rms / one.after.distance_rms, 1) + ")",
                 Reproducibility::kAddition,
                 "the paper changes poses, measurement and model at once; one at a time here");
  }
}

}  // namespace sagitta
