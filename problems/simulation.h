// Simulated measurements: what the instrument would have read, given a truth.
//
//   measured = t + R * point_base(q, theta, loads, deviations) + root n,   base_in_station = (t, R)
//
// (a rotation: exp(root n) times the true one) with n three standard normal numbers per observation in row order, and
// one deviation of each joint per visit where a repeatability is stated (paper 003, section 2: it is the robot's, not
// the instrument's). SI; points in the station's measurement frame. Loads, compliances, the compensator and effects are
// those of the problem.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "models/forward_model.h"
#include "models/robot.h"
#include "problems/calibration_problem.h"

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

// Draws the readings of one problem's rows again and again.
class Simulator {
 public:
  // `problem` supplies robot, loads, effects, rows and joint deviations, and must outlive the simulator; the values are
  // those of `truth`. roots: of each observation's noise covariance, m; zero: exact. repeatability_scale multiplies the
  // problem's joint deviations.
  Simulator(const CalibrationProblem& problem, const ParameterSet& truth, NoiseRoots roots,
            double repeatability_scale = 1.0);

  // Points without noise and deviations, 3 x N, m; NaN where a load folds the arm.
  const Eigen::Matrix3Xd& exact() const { return exact_; }

  // Fills in the points of `data`, the problem's own measurements. False: an equilibrium diverged. The instrument's
  // noise of a seed is the same with and without joint deviations.
  bool Draw(std::uint64_t seed, Measurements* data) const;

 private:
  bool PredictShot(int shot, const double* deviations, Eigen::Matrix3Xd* points) const;

  const CalibrationProblem& problem_;
  ParameterSet truth_;
  std::vector<double> theta_;
  NoiseRoots roots_;
  double repeatability_scale_;
  Eigen::Matrix3Xd exact_;
};

// A rigid arm that nothing else is known of.
struct SimulationTruth {
  Robot robot;
  std::vector<Pose<double>> base_in_station;  // one per Measurements::stations
  std::vector<MarkerInFrame> markers;         // one per Measurements::markers
};

// `rows` of an unloaded rigid arm with the points filled in; everything else, stated sigmas included,
// stays as it is. `sigma` has one entry per observation; 0 means exact.
Measurements SimulateMeasurements(const Measurements& rows, const SimulationTruth& truth,
                                  const std::vector<Vector3<double>>& sigma, std::uint64_t seed);

}  // namespace sagitta
