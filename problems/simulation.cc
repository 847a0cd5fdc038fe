#include "problems/simulation.h"

#include <cassert>
#include <cmath>

namespace sagitta {

double NormalNumbers::Uniform() {
  // 53 random bits; 1 - u keeps the logarithm finite.
  return 1.0 - static_cast<double>(random_() >> 11) * 0x1.0p-53;
}

double NormalNumbers::operator()() {
  constexpr double kTwoPi = 6.283185307179586;
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2.0 * std::log(Uniform()));
  const double angle = kTwoPi * Uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

std::vector<Vector3<double>> SigmaOfRows(const Measurements& rows, const Vector3<double>& otherwise) {
  std::vector<Vector3<double>> sigma;
  sigma.reserve(rows.observations.size());
  for (const Observation& observation : rows.observations) {
    sigma.push_back((observation.sigma.array() > 0.0).select(observation.sigma, otherwise));
  }
  return sigma;
}

Measurements SimulateMeasurements(const Measurements& rows, const SimulationTruth& truth,
                                  const std::vector<Vector3<double>>& sigma, std::uint64_t seed) {
  assert(truth.base_in_station.size() == rows.stations.size());
  assert(truth.markers.size() == rows.markers.size());
  assert(sigma.size() == rows.observations.size());
  const ForwardModel model(truth.robot.chain);
  const std::vector<double> no_errors(model.num_parameters(), 0.0);
  NormalNumbers normal(seed);
  Measurements simulated = rows;
  for (size_t i = 0; i < simulated.observations.size(); ++i) {
    Observation& observation = simulated.observations[i];
    const MarkerInFrame& marker = truth.markers[observation.marker];
    const Pose<double>& base_in_station = truth.base_in_station[simulated.shots[observation.shot].station];
    const Vector3<double> point_in_base =
        model.PointInBase(simulated.ConfigurationOf(observation).q, no_errors.data(), marker.frame, marker.point);
    observation.point_in_station = base_in_station * point_in_base;
    for (int axis = 0; axis < 3; ++axis) observation.point_in_station[axis] += sigma[i][axis] * normal();
  }
  return simulated;
}

}  // namespace sagitta
