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

// The problem with one common repeatability on every revolute joint, rad, instead of what it states of them.
CalibrationProblem WithRepeatability(const CalibrationProblem& problem, double sigma);

// One repeatability of all revolute joints (rad, where asked for with a 95 % interval by the profile) by REML
// (variance_components.h), given the sigmas at hand or, where sigma_is_open, together with the instrument's.
struct RepeatabilityFit {
  double instrument = 1.0;  // times the sigma that is assumed, where that is open
  double sigma = 0.0;
  double low = 0.0, high = 0.0;
};
RepeatabilityFit FitRepeatability(const CalibrationProblem& problem, const ParameterSet& parameters, bool sigma_is_open,
                                  bool with_interval);

// Whether rows share arrivals (markers of one shot, repeats, loads): what deviating joints do to all of them alike can
// be separated from what the instrument does to each.
bool RowsShareVisits(const CalibrationProblem& problem);

}  // namespace sagitta
