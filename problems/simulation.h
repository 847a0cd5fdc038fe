// Simulated measurements: what the instrument would have read, given a truth.
//
//   measured = t + R * point_base(q, robot) + sigma .* n,   base_in_station = (t, R)
//
// with n independent standard normal numbers, one per axis of every observation,
// in row order. SI units; points and sigmas in the station's measurement frame.
// The truth is a robot as its file states it: geometric errors belong into its
// nominal values (WithGeometricErrors).
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "models/forward_model.h"
#include "models/robot.h"
#include "problems/measurements.h"

namespace sagitta {

// Standard normal numbers that are the same on every platform: the standard
// fixes std::mt19937_64 but not std::normal_distribution, hence Box and Muller.
class NormalNumbers {
 public:
  explicit NormalNumbers(std::uint64_t seed) : random_(seed) {}

  double operator()();

 private:
  double Uniform();  // in (0, 1]

  std::mt19937_64 random_;
  bool has_spare_ = false;
  double spare_ = 0.0;
};

struct SimulationTruth {
  Robot robot;
  std::vector<Pose<double>> base_in_station;  // one per Measurements::stations
  std::vector<MarkerInFrame> markers;         // one per Measurements::markers
};

// The sigma of every observation, m: what its row states, else `otherwise`.
std::vector<Vector3<double>> SigmaOfRows(const Measurements& rows, const Vector3<double>& otherwise);

// `rows` with the points filled in; everything else, stated sigmas included,
// stays as it is. `sigma` has one entry per observation; 0 means exact.
Measurements SimulateMeasurements(const Measurements& rows, const SimulationTruth& truth,
                                  const std::vector<Vector3<double>>& sigma, std::uint64_t seed);

}  // namespace sagitta
