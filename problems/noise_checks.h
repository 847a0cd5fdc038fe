// Noise keys of an experiment that the data, or each other, contradict; and noise that the data show by themselves.
#pragma once

#include "problems/calibration_problem.h"

namespace sagitta {

// Throws InputError. Completes what a key implies: {from: variance-components} estimates the repeatability where none
// is stated.
void CheckNoise(CalibrationProblem* problem);

// {from: repeats}: sets resolved_noise and repeat_scatter. Throws InputError where there are no repeats.
void ResolveRepeats(CalibrationProblem* problem);

// Rows without a standard deviation among rows that have one.
void CheckSigmas(const CalibrationProblem& problem);

// Warns of rotations whose noise is assumed. Throws InputError where rotations state it and points do not.
void SayRotationSigmas(CalibrationProblem* problem);

// Warns of rows whose standard deviations an instrument's data sheet, repeats or residuals replace.
void SayReplacedSigmas(CalibrationProblem* problem);

// Warns of readings with so few digits that rounding alone scatters by more than is stated: a coordinate that is
// rounded to steps of d is off by anything up to d/2 alike, with a standard deviation of d / sqrt(12).
void SayRounding(CalibrationProblem* problem);

}  // namespace sagitta
