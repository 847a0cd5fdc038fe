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

}  // namespace sagitta
