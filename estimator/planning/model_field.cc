#include "estimator/planning/model_field.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "estimator/least_squares/linearization.h"
#include "estimator/planning/pose_space.h"

namespace sagitta {
namespace {

constexpr int kFieldOrders = 4;
constexpr int kMostPoses = 300;  // candidates that the amplitude is found at

}  // namespace

std::vector<EffectSpec> FieldEffects(const Robot& robot, const std::vector<EffectSpec>& beside) {
  std::vector<EffectSpec> field;
  for (const Joint& joint : robot.chain.joints) {
    if (joint.type != JointType::kRevolute) continue;
    for (int order = 1; order <= kFieldOrders; ++order) {
      const EffectSpec term{"joint_harmonic", joint.name, {{"order", std::to_string(order)}}, {0.0, 0.0}};
      const auto same = [&](const EffectSpec& other) { return other.Path() == term.Path(); };
      if (std::none_of(robot.effects.begin(), robot.effects.end(), same) &&
          std::none_of(beside.begin(), beside.end(), same)) {
        field.push_back(term);
      }
    }
  }
  return field;
}

double FieldAmplitude(const PlanScene& scene, const std::vector<int>& columns, const std::vector<bool>& of_field,
                      double rms) {
  const CalibrationProblem& problem = *scene.problem;
  const std::vector<std::vector<int>> observations = ObservationsByConfiguration(problem.data());
  const size_t stride = std::max<size_t>(1, scene.candidates.size() / kMostPoses);
  std::vector<int> points;
  for (size_t i = 0; i < scene.candidates.size(); i += stride) {
    const std::vector<int>& own = observations[scene.candidates[i]];
    points.insert(points.end(), own.begin(), own.end());
  }
  points = problem.data().PointsAmong(points);
  const NoiseRoots metres(points.size(), Matrix3<double>::Identity());
  Eigen::MatrixXd rows =
      Linearize(problem, problem.parameters, points, columns, metres, LatentTreatment::kIgnore).jacobian;
  std::vector<bool> rest(of_field);
  rest.flip();
  Absorb(rest, &rows);
  // Mean square of a coordinate, m^2, that a field of 1 rad moves after everything else has been fitted to it: the
  // amplitude makes it the stated RMS.
  const double left = rows.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, rows.rows()));  // m^2
  constexpr double kNothing = 1e-6;  // m per rad: shorter arms there are not
  return left > kNothing * kNothing ? rms / std::sqrt(left) : 0.0;
}

}  // namespace sagitta
