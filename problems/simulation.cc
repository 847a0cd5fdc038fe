#include "problems/simulation.h"

#include <cassert>
#include <cmath>
#include <stdexcept>

#include "models/constants.h"
#include "models/random_bits.h"

namespace sagitta {

double NormalNumbers::Uniform() {
  // 53 random bits; 1 - u keeps the logarithm finite.
  return 1.0 - UnitNumber(random_());
}

double NormalNumbers::operator()() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2.0 * std::log(Uniform()));
  const double angle = 2.0 * kPi * Uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

Simulator::Simulator(const CalibrationProblem& problem, const ParameterSet& truth, NoiseRoots roots,
                     double repeatability_scale)
    : problem_(problem),
      truth_(truth),
      theta_(truth.ModelValues()),
      roots_(std::move(roots)),
      repeatability_scale_(repeatability_scale),
      exact_(Eigen::Matrix3Xd::Constant(3, problem.data().observations.size(), std::nan(""))) {
  assert(roots_.size() == problem.data().observations.size());
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    if (!PredictShot(static_cast<int>(s), nullptr, &exact_)) break;
  }
}

bool Simulator::PredictShot(int s, const double* deviations, Eigen::Matrix3Xd* points) const {
  const Shot& shot = problem_.data().shots[s];
  std::vector<MarkerInFrame> markers;
  for (const int k : shot.observations) {
    const Observation& observation = problem_.data().observations[k];
    markers.push_back(
        truth_.MarkerOn(problem_.marker_frames()[observation.marker], observation.marker, observation.kind));
  }
  std::vector<PointPrediction> predictions;
  if (!problem_.model().Predict(problem_.shot_inputs()[s], theta_.data(), {}, truth_.BaseInStation(shot.station),
                                markers, &predictions, deviations)) {
    return false;
  }
  for (size_t m = 0; m < markers.size(); ++m) points->col(shot.observations[m]) = predictions[m].point;
  return true;
}

bool Simulator::Draw(std::uint64_t seed, Measurements* data) const {
  constexpr std::uint64_t kOtherStream = kGoldenBits;  // far from any seed in use
  const LatentModel& latent = problem_.latent;
  Eigen::Matrix3Xd points = exact_;
  if (!latent.empty()) {
    NormalNumbers arm(seed + kOtherStream);
    Eigen::MatrixXd deviations = Eigen::MatrixXd::Zero(problem_.robot().num_joints(), latent.num_visits);
    for (int v = 0; v < latent.num_visits; ++v) {
      for (int i = 0; i < latent.size(); ++i) {
        deviations(latent.joints[i], v) = repeatability_scale_ * latent.sigmas[i] * arm();
      }
    }
    for (size_t s = 0; s < data->shots.size(); ++s) {
      if (!PredictShot(static_cast<int>(s), deviations.col(latent.visit_of_shot[s]).data(), &points)) return false;
    }
  }
  if (!points.allFinite()) return false;
  NormalNumbers instrument(seed);
  for (size_t k = 0; k < data->observations.size(); ++k) {
    Vector3<double> unit;
    for (double& u : unit) u = instrument();
    data->observations[k].Read(points.col(k), roots_[k] * unit);
  }
  return true;
}

Measurements SimulateMeasurements(const Measurements& rows, const SimulationTruth& truth,
                                  const std::vector<Vector3<double>>& sigma, std::uint64_t seed) {
  if (truth.base_in_station.size() != rows.stations.size() || truth.markers.size() != rows.markers.size() ||
      sigma.size() != rows.observations.size()) {
    throw std::invalid_argument(
        "SimulateMeasurements: one base per station, one point per marker, one sigma per observation are expected");
  }
  Robot rigid;
  rigid.chain = truth.robot.chain;
  KnownPlaces places;
  for (size_t s = 0; s < rows.stations.size(); ++s) places.base_in_station[rows.stations[s]] = truth.base_in_station[s];
  for (size_t m = 0; m < rows.markers.size(); ++m) places.markers[rows.markers[m]].point = truth.markers[m].point;
  CalibrationProblem problem = MakeKnownProblem(rigid, rows, Experiment(), places);
  for (size_t m = 0; m < truth.markers.size(); ++m)
    problem.set_marker_frame(static_cast<int>(m), truth.markers[m].frame);
  NoiseRoots roots;
  for (const Vector3<double>& axes : sigma) roots.emplace_back(axes.asDiagonal());
  Measurements simulated = rows;
  Simulator(problem, problem.parameters, std::move(roots)).Draw(seed, &simulated);
  return simulated;
}

}  // namespace sagitta
