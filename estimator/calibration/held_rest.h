// Where held parameters rest. Data that cannot determine a direction within its hold limit still fit better at some
// places along it than at others, and what is estimated absorbs the difference: a held value far from where the data
// fit best costs accuracy on other poses. The rest is the optimum with a weak prior on what is held,
//
//   min |r(e, h)|^2 + sum_h ((h - h0) s / P)^2,
//
// r whitened, s the scale of its noise, P = PhysicalRange (held_influence.h: the hold limit, of base and markers 1 m),
// h0 the nominal value, of a marker its stated point or the origin of its frame, of a base where the alignment left it.
// A direction that no row sees rests at h0, and so does a spring's L. The value is as little known as before: it stays
// held.
#pragma once

#include "estimator/least_squares/linearization.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// The same values, with what is held free but for its prior. Single axes of a rotation have no value of their own and
// stay held. here: rows at `parameters`, of all requested coordinates; noise_scale: of its whitened noise.
ParameterSet ReleaseHeld(const CalibrationProblem& problem, const ParameterSet& parameters, const ParameterSet& aligned,
                         const Linearization& here, double noise_scale);

// h0 of a coordinate, SI.
double ReferenceOf(const CalibrationProblem& problem, const ParameterSet& aligned, int coordinate);

// The values of `released`, held again as in `parameters`; what has not left its h0 stands on it exactly.
ParameterSet HoldAgain(const ParameterSet& parameters, const ParameterSet& released);

}  // namespace sagitta
