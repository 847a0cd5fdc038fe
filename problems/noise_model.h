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

// Zero: nothing is stated. Of the roots S of one covariance S S' some have a negative determinant: all of them state
// it.
bool IsStated(const Matrix3<double>& root);
// Of a covariance that a reading can be weighed by: with an inverse. One that is exact in a direction has none.
bool IsRoot(const Matrix3<double>& root);
bool IsDiagonal(const NoiseRoots& roots);

// Least degrees of freedom f of a spread that one axis, or rotations, are weighed by: of 1 / s^2, the weight, standard
// deviation over mean are sqrt(2 / (f - 4)), a half here. With fewer the weights follow their own errors: a mean over
// three axes that scatter alike has a variance that is larger than it is said to be by the share 8 / (3 f) (Meier
// 1953), 0.9 at f = 3 and 0.2 here.
constexpr int kLeastSpreadDof = 12;

// Where the noise that an estimate goes by is from, next to what rows and experiment state.
enum class NoiseOrigin {
  kStated,   // by these, or nothing states any and all rows share one that is estimated
  kRepeats,  // {from: repeats}: measured
  kScaled,   // that times a factor which residuals ask for
  kFound     // from residuals alone: nothing states any
};

// Spread of repeated shots of equal (config, visit, marker, load, station), pooled over all of them, per axis: what the
// instrument alone does, the robot stands still meanwhile.
struct RepeatScatter {
  // m, of each axis, or of all three together where one has less than kLeastSpreadDof.
  Vector3<double> sigma = Vector3<double>::Zero();
  int dof = 0;               // of each axis: observations - groups
  bool axes_differ = false;  // each has a sigma of its own
  // rad, of each axis, or of all three together where one has less than kLeastSpreadDof; 0: left open, as three have
  // less, or no rotation was read twice.
  Vector3<double> rotation_sigma = Vector3<double>::Zero();
  double rotation_dof = 0.0;           // of all three axes; where it was left open what the repeats have
  bool rotation_axes_differ = false;   // each has a sigma of its own
  bool rotation_is_estimated = false;  // left open by the repeats, found from residuals with rotation_dof
  double rotation_share = 0.0;         // of the readings that are fitted
  bool is_of_fitted = true;            // false: all that was repeated is held out
};
// Of the fitted rows, or where none of them was repeated of the validation rows, whose repeats know the model as
// little; empty without repeats.
std::optional<RepeatScatter> PooledRepeats(const Measurements& data);

// Spreads that squared residuals are divided by: which share of the readings, and how many degrees of freedom each has.
struct KnownSpread {
  double share = 1.0, dof = 0.0;
};
// Of points and of rotations where repeats give theirs, per axis where each has its own.
std::vector<KnownSpread> SpreadsOf(const RepeatScatter& repeats);
// How well one factor on all of them is known: with w_k the shares,  var(sum w_k s_k^2 / sigma_k^2) = 2 / dof =
// sum w_k^2 2 / dof_k.  Infinite where sigmas are stated.
double SigmaDof(const std::optional<RepeatScatter>& repeats);

}  // namespace sagitta
