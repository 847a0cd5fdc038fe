#include "estimator/intervals/redraw.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <numeric>

#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/spring_tie_cost.h"
#include "problems/simulation.h"

namespace sagitta {

std::uint64_t SeedOf(std::uint64_t seed, std::uint64_t i) {
  std::uint64_t z = seed * 0xD1342543DE82EF95ULL + (i + 1) * 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

void DrawPriors(const ParameterSet& truth, std::uint64_t seed, ParameterSet* parameters) {
  NormalNumbers normal(seed);
  for (int i = 0; i < parameters->num_coordinates(); ++i) {
    Coordinate& coordinate = parameters->coordinate(i);
    if (coordinate.prior_sigma > 0.0) coordinate.prior_value = truth.Value(i) + coordinate.prior_sigma * normal();
  }
}

ParameterSet DrawTruth(const ParameterSet& truth, std::uint64_t seed) {
  constexpr double kStep = 1e-6;  // m
  constexpr int kRounds = 3;      // the anchors' geometry bends by 1e-4 of a marker's 0.2 mm
  ParameterSet drawn = truth;
  if (!truth.spring_tie()) return drawn;
  const SpringTie& tie = *truth.spring_tie();
  NormalNumbers normal(seed);
  Eigen::Vector3d off;
  for (double& number : off) number = normal();
  off = tie.covariance.llt().matrixL() * off;
  const int markers[2] = {tie.lever_marker, tie.anchor_marker};
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector3d misfit = SpringTieMisfit(drawn);
    Eigen::Matrix<double, 3, 6> slopes;
    for (int i = 0; i < 6; ++i) {
      ParameterSet moved = drawn;
      moved.SetMarkerPoint(markers[i / 3], drawn.MarkerPoint(markers[i / 3]) + kStep * Vector3<double>::Unit(i % 3));
      slopes.col(i) = (SpringTieMisfit(moved) - misfit) / kStep;
    }
    const Eigen::Matrix<double, 6, 1> step = slopes.completeOrthogonalDecomposition().solve(off - misfit);
    for (int m = 0; m < 2; ++m) {
      drawn.SetMarkerPoint(markers[m], drawn.MarkerPoint(markers[m]) + step.segment<3>(3 * m));
    }
  }
  return drawn;
}

Redraw::Redraw(const CalibrationProblem& problem, const ParameterSet& truth, double noise_scale, double fallback)
    : problem_(problem), truth_(truth), theta_(truth.ModelValues()), noise_scale_(noise_scale) {
  std::vector<int> all(problem.data.observations.size());
  std::iota(all.begin(), all.end(), 0);
  roots_ = ObservationNoise(problem, all, fallback);
  for (Matrix3<double>& root : roots_) root *= noise_scale;
  exact_ = PredictPoints(problem, truth, all);
}

bool Redraw::Draw(std::uint64_t seed, Measurements* data) const {
  NormalNumbers normal(seed);
  const LatentModel& latent = problem_.latent;
  std::vector<std::vector<double>> deviations;  // per visit, per joint
  for (int v = 0; v < latent.num_visits && !latent.empty(); ++v) {
    deviations.emplace_back(problem_.robot.num_joints(), 0.0);
    for (int i = 0; i < latent.size(); ++i) {
      deviations.back()[latent.joints[i]] = noise_scale_ * latent.sigmas[i] * normal();
    }
  }
  Eigen::Matrix3Xd points = exact_;
  for (size_t s = 0; s < data->shots.size() && !latent.empty(); ++s) {
    const Shot& shot = data->shots[s];
    std::vector<MarkerInFrame> markers;
    for (const int k : shot.observations) {
      const int marker = data->observations[k].marker;
      markers.push_back({problem_.marker_frames[marker], truth_.MarkerPoint(marker), marker});
    }
    std::vector<PointPrediction> predictions;
    if (!problem_.model.Predict(problem_.shot_inputs[s], theta_.data(), {}, truth_.BaseInStation(shot.station), markers,
                                &predictions, deviations[latent.visit_of_shot[s]].data())) {
      return false;
    }
    for (size_t m = 0; m < markers.size(); ++m) points.col(shot.observations[m]) = predictions[m].point;
  }
  if (!points.allFinite()) return false;
  for (size_t k = 0; k < data->observations.size(); ++k) {
    Vector3<double> unit;
    for (double& u : unit) u = normal();
    data->observations[k].point_in_station = points.col(k) + roots_[k] * unit;
  }
  return true;
}

}  // namespace sagitta
