#include "estimator/baselines/full_pose.h"

#include <Eigen/QR>
#include <chrono>
#include <cmath>

#include "estimator/alignment/pose_registration.h"
#include "estimator/alignment/starting_values.h"
#include "estimator/baselines/paper_stages.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/report/baselines_words.h"
#include "models/matrix_functions.h"
#include "problems/range.h"

namespace sagitta {
namespace {

constexpr int kShapeRounds = 30;
constexpr double kConvergedPoseStep = 1e-6;  // standard deviations

// One shot with a pose: rows [first, first + markers) of the observations used.
struct PoseShot {
  int first = 0;
  int markers = 0;
};

struct Context {
  const CalibrationProblem& problem;
  const FullPoseOptions& options;
  std::vector<int> observations;  // of the shots with a pose
  Eigen::VectorXd sigmas;         // 3 per observation, m; full covariances are refused (MethodObstacle)
  std::vector<PoseShot> shots;
  int free_marker_coordinates = 0;

  bool tool_is_free() const { return free_marker_coordinates > 0; }

  const Observation& observation(int k) const { return problem.data().observations[observations[k]]; }
};

Eigen::Matrix3Xd MarkerPoints(const Context& context, const PoseShot& shot, const ParameterSet& parameters) {
  Eigen::Matrix3Xd points(3, shot.markers);
  for (int i = 0; i < shot.markers; ++i)
    points.col(i) = parameters.MarkerPoint(context.observation(shot.first + i).marker);
  return points;
}

Eigen::Matrix3Xd PointsOfShot(const Context& context, const PoseShot& shot) {
  Eigen::Matrix3Xd points(3, shot.markers);
  for (int i = 0; i < shot.markers; ++i) points.col(i) = context.observation(shot.first + i).point_in_station;
  return points;
}

// Shots whose markers span a plane. Observations of a shot are consecutive.
void CollectShots(const ParameterSet& aligned, Context* context) {
  const CalibrationProblem& problem = context->problem;
  const std::vector<int> all = problem.CalibrationObservations();
  for (size_t first = 0, last = 0; first < all.size(); first = last) {
    const int shot = problem.data().observations[all[first]].shot;
    Eigen::Matrix3Xd points(3, 0);
    for (last = first; last < all.size() && problem.data().observations[all[last]].shot == shot; ++last) {
      points.conservativeResize(3, points.cols() + 1);
      points.rightCols<1>() = aligned.MarkerPoint(problem.data().observations[all[last]].marker);
    }
    if (!SpansAPlane(points)) continue;
    context->shots.push_back({static_cast<int>(context->observations.size()), static_cast<int>(last - first)});
    context->observations.insert(context->observations.end(), all.begin() + first, all.begin() + last);
  }
  const NoiseRoots noise = FitRoots(problem, context->observations, kFallbackSigma);
  context->sigmas.resize(3 * noise.size());
  for (size_t k = 0; k < noise.size(); ++k) context->sigmas.segment<3>(3 * k) = noise[k].diagonal();
}

// Generalised Procrustes: the markers' mean shape over all shots, placed where the
// aligned points are.
void AverageShape(const Context& context, ParameterSet* parameters) {
  const int n = parameters->num_markers();
  const ParameterSet aligned = *parameters;
  for (int round = 0; round < kShapeRounds; ++round) {
    Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, n);
    std::vector<int> count(n, 0);
    for (const PoseShot& shot : context.shots) {
      const Eigen::Matrix3Xd measured = PointsOfShot(context, shot);
      const Pose<double> flange_from_station = RegisterRigid(measured, MarkerPoints(context, shot, *parameters));
      for (int i = 0; i < shot.markers; ++i) {
        const int m = context.observation(shot.first + i).marker;
        sum.col(m) += flange_from_station * Vector3<double>(measured.col(i));
        ++count[m];
      }
    }
    for (int m = 0; m < n; ++m) {
      if (count[m] > 0) parameters->SetMarkerPoint(m, sum.col(m) / count[m]);
    }
  }
}

// Empty if there is an estimate from poses.
std::string PoseObstacle(const Context& context, int unknowns) {
  const CalibrationProblem& problem = context.problem;
  for (const int frame : problem.marker_frames()) {
    if (frame != problem.marker_frames()[0]) return NotRunBecause(MarkersOnSeveralLinks());
  }
  if (context.tool_is_free() && context.free_marker_coordinates != 3 * problem.parameters.num_markers()) {
    return NotRunBecause(SomeMarkersHeld());
  }
  if (context.shots.empty()) return NotRunBecause(NoFullPose());
  if (6 * static_cast<int>(context.shots.size()) < unknowns) {
    return NotRunBecause(FewFullPoses(context.shots.size(), unknowns));
  }
  return "";
}

// Estimated coordinates from the unknowns of this method: base and geometry as
// they are, all markers from one rigid motion of the tool.
Eigen::MatrixXd CoordinatesFromUnknowns(const ParameterSet& parameters, const std::vector<int>& coordinates,
                                        bool tool_is_free) {
  const int markers = tool_is_free ? 3 * parameters.num_markers() : 0;
  const int kept = static_cast<int>(coordinates.size()) - markers;
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(coordinates.size(), kept + (tool_is_free ? 6 : 0));
  for (int c = 0, k = 0; c < map.rows(); ++c) {
    const Coordinate& coordinate = parameters.coordinates()[coordinates[c]];
    const ParameterBlock& block = parameters.blocks()[coordinate.block];
    if (block.kind != BlockKind::kMarker) {
      map(c, k++) = 1.0;
    } else {
      const Eigen::MatrixXd motion = RigidColumns(parameters.MarkerPoint(block.owner), Vector3<double>::Zero());
      map.block<1, 6>(c, kept) = motion.row(coordinate.index_in_block);
    }
  }
  return map;
}

// The weighted pose equations at one point: residual z, Jacobian B, square root
// weights L, and the covariance of the z of each shot.
struct PoseEquations {
  bool valid = true;         // false: an equilibrium diverged
  Eigen::MatrixXd jacobian;  // L B
  Eigen::VectorXd residual;  // L z, z = measured - predicted
  Eigen::MatrixXd noise;     // 6 x 6 per shot, side by side: L C L'
};

// Fills the six rows of one shot; `residual` and `jacobian` are its marker rows, m.
void EvaluateShot(const Context& context, int s, const ParameterSet& parameters, const Eigen::VectorXd& residual,
                  const Eigen::MatrixXd& jacobian, PoseEquations* equations) {
  const PoseShot& shot = context.shots[s];
  const Eigen::VectorXd sigmas = context.sigmas.segment(3 * shot.first, 3 * shot.markers);
  const Eigen::Matrix3Xd measured = PointsOfShot(context, shot);
  const Eigen::Matrix3Xd predicted = measured + Eigen::Map<const Eigen::Matrix3Xd>(residual.data(), 3, shot.markers);
  const Pose<double> flange_in_station = RegisterRigid(MarkerPoints(context, shot, parameters), predicted);
  const Vector3<double> reference = flange_in_station * context.options.reference_in_flange;
  const Eigen::MatrixXd rigid = RigidColumns(predicted, reference);
  // d p_i = d t + d w x (p_i - reference): six columns per shot, hence the covariance of the measured pose C = (R'S^-2
  // R)^-1.
  const Eigen::MatrixXd whitened = sigmas.cwiseInverse().asDiagonal() * rigid;
  const Eigen::MatrixXd information = whitened.transpose() * whitened;  // C^-1, propagated
  Eigen::MatrixXd root = Eigen::LLT<Eigen::MatrixXd>(information).matrixU();
  if (!context.options.propagated_covariance) {
    const double w = context.options.weight;
    // As printed: one weight for positions and one for rotations, whatever the markers say.
    root = (Vector6() << 1, 1, 1, w, w, w).finished().asDiagonal().toDenseMatrix() / sigmas.mean();
  }
  // The markers move rigidly with every unknown: marker rows = rigid * pose rows.
  const Eigen::MatrixXd of_pose = rigid.householderQr().solve(jacobian);
  equations->jacobian.middleRows(6 * s, 6) = root * of_pose;
  equations->residual.segment<6>(6 * s) = root * RegisterPose(predicted, measured, sigmas, reference);
  const Eigen::MatrixXd spread = root * InverseOfPositive(information);
  equations->noise.middleCols(6 * s, 6) = spread * root.transpose();
}

PoseEquations Evaluate(const Context& context, const ParameterSet& parameters, const std::vector<int>& coordinates,
                       const Eigen::MatrixXd& map) {
  const NoiseRoots ones(context.observations.size(), Matrix3<double>::Identity());
  const Linearization markers = Linearize(context.problem, parameters, context.observations, coordinates, ones);
  const Eigen::MatrixXd jacobian = markers.jacobian * map;
  const int poses = static_cast<int>(context.shots.size());
  PoseEquations equations{markers.valid, Eigen::MatrixXd(6 * poses, map.cols()), Eigen::VectorXd(6 * poses),
                          Eigen::MatrixXd(6, 6 * poses)};
  for (int s = 0; s < poses; ++s) {
    const int first = 3 * context.shots[s].first, rows = 3 * context.shots[s].markers;
    EvaluateShot(context, s, parameters, markers.residual.segment(first, rows), jacobian.middleRows(first, rows),
                 &equations);
  }
  return equations;
}

// (H^-1) B'L' (L C L') L B (H^-1), H = B'L'L B; H^-1 itself where weights are optimal.
Eigen::MatrixXd Sandwich(const PoseEquations& equations, const Eigen::MatrixXd& inverse) {
  Eigen::MatrixXd middle = Eigen::MatrixXd::Zero(inverse.rows(), inverse.cols());
  for (int s = 0; s < equations.noise.cols() / 6; ++s) {
    const Eigen::MatrixXd rows = equations.jacobian.middleRows(6 * s, 6);
    const Eigen::MatrixXd weighed = equations.noise.middleCols(6 * s, 6) * rows;
    middle += rows.transpose() * weighed;
  }
  const Eigen::MatrixXd half = inverse * middle;
  return half * inverse;
}

// Base and geometry move by the step, the markers rigidly: their shape stays.
void TakeStep(const Eigen::VectorXd& step, const std::vector<int>& coordinates, const Eigen::MatrixXd& map,
              bool tool_is_free, ParameterSet* parameters) {
  const ParameterSet before = *parameters;
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters->num_coordinates());
  const Eigen::VectorXd moved = map * step;
  for (size_t c = 0; c < coordinates.size(); ++c) delta[coordinates[c]] = moved[c];
  parameters->Plus(delta);
  if (!tool_is_free) return;
  const Vector3<double> turn = step.tail<3>();
  const Pose<double> motion{RotationFromVector(turn), step.tail<6>().head<3>()};
  for (int m = 0; m < before.num_markers(); ++m) parameters->SetMarkerPoint(m, motion * before.MarkerPoint(m));
}

// This method's own standard deviations in place of the joint ones.
void TakeCovariance(const Eigen::MatrixXd& covariance, Estimate* estimate) {
  const double scale = AppliedNoise(estimate->sigma);
  estimate->covariance = scale * scale * covariance;
  estimate->intervals = IntervalReport();
  for (size_t c = 0; c < estimate->estimated.size(); ++c) {
    ParameterEstimate& row = estimate->table[estimate->estimated[c]];
    const double sigma = std::sqrt(estimate->covariance(c, c));
    const double half = row.sigma > 0.0 ? (row.ci95.high - row.value) / row.sigma * sigma : 0.0;
    row.sigma = sigma;
    row.ci95 = {row.value - half, row.value + half};
  }
}

// Gauss-Newton on the pose equations; returns the covariance over the coordinates.
Eigen::MatrixXd IterateOnPoses(const Context& context, const std::vector<int>& coordinates, Estimate* estimate) {
  Stop(Status::kNoConvergence, "stopped after " + std::to_string(context.options.max_iterations) + " iterations",
       estimate);
  Eigen::MatrixXd covariance;
  for (int i = 0; i < context.options.max_iterations; ++i) {
    const Eigen::MatrixXd map = CoordinatesFromUnknowns(estimate->parameters, coordinates, context.tool_is_free());
    const PoseEquations equations = Evaluate(context, estimate->parameters, coordinates, map);
    Linearization poses;
    poses.jacobian = equations.jacobian;
    poses.residual = -equations.residual;
    const LinearSolution solution = SolveLinearization(poses);
    if (!equations.valid || !solution.full_rank) {
      Stop(Status::kSingular, PoseEquationsSingular(), estimate);
      break;
    }
    const Eigen::MatrixXd of_unknowns = Sandwich(equations, solution.covariance);
    const Eigen::MatrixXd half = map * of_unknowns;
    covariance = half * map.transpose();
    const Eigen::ArrayXd sigmas = of_unknowns.diagonal().array().sqrt();
    const double size = (solution.step.array().abs() / sigmas).maxCoeff();
    if (!std::isfinite(size)) break;
    TakeStep(solution.step, coordinates, map, context.tool_is_free(), &estimate->parameters);
    estimate->iterations = i + 1;
    if (size < kConvergedPoseStep) {
      Stop(Status::kConverged, PosesStandStill(), estimate);
      break;
    }
  }
  return covariance;
}

}  // namespace

void CheckOptions(const FullPoseOptions& options) {
  CheckIn(allowed::kFactor, options.weight, "FullPoseOptions.weight");
  for (const double x : options.reference_in_flange) {
    CheckIn(allowed::kCoordinate, x, "FullPoseOptions.reference_in_flange");
  }
  CheckIn(allowed::kIterations, options.max_iterations, "FullPoseOptions.max_iterations");
}

Estimate EstimateFromFullPoses(const CalibrationProblem& problem, const FullPoseOptions& options) {
  CheckOptions(options);
  const auto start = std::chrono::steady_clock::now();
  Estimate estimate;
  estimate.aligned = problem.parameters;
  AlignNominal(problem, &estimate.aligned);
  estimate.parameters = estimate.aligned;
  const std::vector<int> coordinates = problem.parameters.EstimatedCoordinates();
  Context context{problem, options, {}, {}, {}, 0};
  for (const int c : coordinates) {
    const BlockKind kind = problem.parameters.blocks()[problem.parameters.coordinates()[c].block].kind;
    context.free_marker_coordinates += kind == BlockKind::kMarker;
  }
  CollectShots(estimate.aligned, &context);
  const int known_shape = context.tool_is_free() ? context.free_marker_coordinates - 6 : 0;
  const std::string obstacle = PoseObstacle(context, static_cast<int>(coordinates.size()) - known_shape);
  if (!obstacle.empty()) {
    estimate.status = Status::kNotRun;
    estimate.message = obstacle;
    return estimate;
  }
  if (context.tool_is_free()) AverageShape(context, &estimate.parameters);
  const Eigen::MatrixXd covariance = IterateOnPoses(context, coordinates, &estimate);
  estimate.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!IsUsable(estimate.status)) return estimate;
  for (const Coordinate& coordinate : problem.parameters.coordinates()) {
    if (coordinate.held) estimate.status = Status::kConvergedWithHeldParameters;
  }
  ComputeStatistics(problem, &estimate);
  TakeCovariance(covariance, &estimate);
  return estimate;
}

}  // namespace sagitta
