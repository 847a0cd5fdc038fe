// How certain an instrument's reading of one point is: a 3x3 covariance per
// observation, station frame, handed around as a root S,
//
//   Sigma = S S',   whitened residual = S^-1 (predicted - measured).
//
// Standard deviations per axis are the case S = diag(sigma). A rotation has a root of its own, in rad, of a left
// perturbation: the 6x6 root of a pose is the two, one after the other. This is the only
// place that says how an observation is whitened.
#pragma once

#include <optional>
#include <vector>

#include "problems/experiment.h"
#include "problems/measurements.h"

namespace sagitta {

using NoiseRoots = std::vector<Matrix3<double>>;  // m; zero: nothing states the noise

// An instrument that reads a range along the line of sight u and angles across it, in spherical coordinates around
// where it stands:
//   sigma_range = range + range_per_m r,   sigma_across = angle + angle_per_m r,
//   S = sigma_across I + (sigma_range - sigma_across) u u'     (symmetric)
Matrix3<double> InstrumentRoot(const NoiseSpec& noise, const Vector3<double>& point, const Vector3<double>& instrument);

// Where the instrument of a station stands: `instrument_mm`, default the station's origin.
Vector3<double> InstrumentPlace(const Experiment& experiment, const std::string& station);

// Of a rotation where points have a stated noise and the rotation none: 1 mm over 1 m. Where nothing states any noise,
// the common standard deviation of the points, over 1 m.
constexpr double kUnstatedRotationSigma = 1e-3;  // rad

// What row, experiment or flag state of an observation seen at `point` (the measured one, or a predicted one
// where nothing was measured).
Matrix3<double> StatedRoot(const Experiment& experiment, const Measurements& data, const Observation& observation,
                           const Vector3<double>& point);

// All of a root, or nothing: a reading that is exact in one direction has no weight.
bool IsStated(const Matrix3<double>& root);
bool IsDiagonal(const NoiseRoots& roots);

// Spread of repeated shots of equal (config, visit, marker, load, station), pooled over all of them, per axis: what the
// instrument alone does, the robot stands still meanwhile. Calibration rows only.
struct RepeatScatter {
  Vector3<double> sigma = Vector3<double>::Zero();           // m
  int dof = 0;                                               // of each axis: observations - groups
  Vector3<double> rotation_sigma = Vector3<double>::Zero();  // rad; 0: no rotation was read twice
};
// Empty without repeats.
std::optional<RepeatScatter> PooledRepeats(const Measurements& data);
// How well one factor on the three sigmas is known: the repeats' degrees of freedom; infinite where sigmas are stated.
double SigmaDof(const std::optional<RepeatScatter>& repeats);

}  // namespace sagitta
