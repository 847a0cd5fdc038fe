// Where nothing states any noise, points and rotations of poses have no common unit: a tracker that reads a target to
// 0.05 mm may turn it by 0.1 or by 1 mrad. Each kind then gets the spread of its own residuals,
//
//   s_k^2 = sum r^2 / sum (1 - h),   k = points (m), rotations (rad),   h the leverage of a row at these weights,
//
// Helmert's variance components of two groups, whose fixed point is found by fitting again. With a loss outliers must
// not decide, and s_k is Huber's scale of the whitened distances d (Huber 1981, section 6.4, proposal 2):
//
//   mean of min((d / s_k)^2 / (1 - h), c^2) = its mean on clean data, E min(chi2_3, c^2)
//
// With variance components rotations have one of their own (variance_components.h).
#pragma once

#include <optional>

#include "estimator/estimate/estimate.h"
#include "estimator/noise/robust.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Rotations were read, and neither rows nor repeats state what any of them scatters by.
bool NoRotationIsStated(const CalibrationProblem& problem);
// And nothing states the noise of points, or repeats that of points alone.
bool RotationsAreOpen(const CalibrationProblem& problem);
// Readings are enough for a spread of residuals to stand for the noise.
bool ShowsSpread(const Estimate& estimate);
// And the readings determine it: enough are left by the unknowns, at least one rotation more than targets.
bool RotationsAreDetermined(const CalibrationProblem& problem, const ParameterSet& parameters);

struct TwoNoises {
  std::vector<VarianceComponent> components;  // of points, m per coordinate, then of rotations, rad per axis
  NoiseRoots roots;                           // of all observations of the data
};

// At a usable estimate; empty where noise is looked for otherwise, where no rotation was read, and where the residuals
// show none of either kind.
std::optional<TwoNoises> FindTwoNoises(const CalibrationProblem& problem, const Estimate& estimate);
// The same whatever the experiment asks for: its loss is in what `problem` excludes. Joints do not deviate.
std::optional<TwoNoises> TwoSpreads(const CalibrationProblem& problem, const Estimate& estimate);

// Degrees of freedom f, f s^2 / sigma^2 being chi-square, of both where rows are weighed by them; and Satterthwaite's
// of each estimated coordinate.
struct FreedomOfTwo {
  double points = 0.0, rotations = 0.0;
  Eigen::VectorXd of_intervals;
};
FreedomOfTwo FindFreedom(const CalibrationProblem& problem, const ParameterSet& parameters);
// Their intervals of 95 %.
void SetIntervals(const FreedomOfTwo& freedom, std::vector<VarianceComponent>* components);

// Scale of rotations over that of points, robustly; `check` at these parameters and the noise of `problem`. 1: not
// known.
double RobustRatio(const CalibrationProblem& problem, const ParameterSet& parameters, const PointCheck& check);

// Where noise is stated and the residuals are several times as large (kInstrumentIsNotTheNoise), one factor on both
// kinds is that of neither: the robot, not the instrument, scatters, and what it does to points and to rotations nobody
// stated. With S_i stated, s the spread of the rotations' residuals and w the whitened one of the points, a rotation
// gets
//
//   root of (S_i S_i' + s^2 I) / u^2,   u = w:
//
// points stay the unit of chi-square, rotations scatter as much in theirs.
//
// Where nothing states what rotations scatter by, S_i = 0, and u = 1 as long as chi-square does not refute the noise of
// points: the intervals have no factor then, and w is known by the few repeats alone that the noise of points may be
// from. Where it does, u = w: the factor, w, makes s of s / w again.
//
// Joints that deviate by what is stated, repeats or not, move points and rotations of an arrival alike: s and w are
// then variance components with the joints' as stated (variance_components.h), else
//
//   s^2 = sum r^2 / sum (1 - h),   w^2 = sum |S_i^-1 r_i|^2 / sum (1 - h)   of rotations, and of points.
struct RotationScatter {
  double spread = 0.0;   // s, rad
  double freedom = 0.0;  // its degrees
  double unit = 1.0;     // u
  NoiseRoots roots;      // of all observations of the data; of points those of `stated`
};
// Whether that is so, at the estimate by what is stated.
bool RotationsScatterOtherwise(const CalibrationProblem& problem, const Estimate& estimate);
// estimate: of `weighed`, which has the rows as they are weighed by now. by_points: u = w.
std::optional<RotationScatter> FindRotationScatter(const CalibrationProblem& stated, const CalibrationProblem& weighed,
                                                   const Estimate& estimate, bool by_points);
// As a problem keeps what was found where nothing states it: in what repeats say of the noise, or by itself.
void KeepRotationNoise(const RotationScatter& scatter, CalibrationProblem* problem);

// That of rotations in a report; null where it has none.
const VarianceComponent* RotationComponent(const NoiseReport& report);
// Points and rotations are all that it has: each kind is weighed by the spread of its residuals.
bool HasTwoNoises(const NoiseReport& report);

}  // namespace sagitta
