// Is the stated noise right? As rigid bodies show it, whatever the robot does (noise/rigid_bodies.h).
#pragma once

#include <optional>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct NoiseScale {
  double scale = 1.0;            // true sigma over stated sigma
  double low = 0.0, high = 0.0;  // 95 %
  int dof = 0;
};

// Of whitened residuals with this sum of squares; what states sigma has degrees of freedom of its own.
NoiseScale ScaleOf(double sum, int dof, const CalibrationProblem& stated);

// Whether something states the instrument's sigma, which is not to be estimated.
bool IsSigmaStated(const CalibrationProblem& problem);
std::optional<NoiseScale> InstrumentNoiseScale(const CalibrationProblem& problem, const ParameterSet& parameters);

// Rotations that state no noise are weighed by the spread of their own residuals; points too, where nothing states
// theirs, as the estimate has them. baseline: of the problem, refitted.
void WeighPointsAndRotations(const CalibrationProblem& problem, const JointOptions& joint, DiagnosedModel* baseline);

inline constexpr int kMostScatterRounds = 6;  // each leaves a fraction of what the one before moved: two or three do

// The problem with every stated sigma multiplied.
CalibrationProblem WithScaledSigmas(const CalibrationProblem& problem, double factor);

// Standard deviations of the joints at an arrival: of those that turn, rad, and of those that slide, m.
struct JointSigmas {
  double turn = 0.0, travel = 0.0;
};
// The problem with one common repeatability of all joints of a kind instead of what it states of them.
CalibrationProblem WithRepeatability(const CalibrationProblem& problem, const JointSigmas& sigmas);

// A size with its 95 % interval, where asked for; 0: there is none.
struct SizeFit {
  double sigma = 0.0, low = 0.0, high = 0.0;
};
// One repeatability of all joints that turn (rad) and one of all that slide (m) by REML (variance_components.h),
// intervals by the profile, given the instrument's sigmas at hand or, where sigma_is_open, together with them.
struct RepeatabilityFit {
  double instrument = 1.0;  // times the sigma that is assumed, where that is open
  SizeFit turn, travel;

  bool IsFound() const { return turn.sigma > 0.0 || travel.sigma > 0.0; }
  JointSigmas Sigmas() const { return {turn.sigma, travel.sigma}; }
};
RepeatabilityFit FitRepeatability(const CalibrationProblem& problem, const ParameterSet& parameters, bool sigma_is_open,
                                  bool with_interval);

// Whether rows share arrivals (markers of one shot, repeats, loads): what deviating joints do to all of them alike can
// be separated from what the instrument does to each.
bool RowsShareVisits(const CalibrationProblem& problem);

}  // namespace sagitta
