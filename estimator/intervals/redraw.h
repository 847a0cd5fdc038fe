// The problem's own experiment, measured once more: points at stated parameters,
// joint deviations drawn per visit, noise drawn per observation.
#pragma once

#include <cstdint>

#include "problems/calibration_problem.h"
#include "problems/simulation.h"

namespace sagitta {

// Seed of the i-th of many independent draws under one seed (SplitMix64).
std::uint64_t SeedOf(std::uint64_t seed, std::uint64_t i);

// A prior is knowledge from elsewhere, one measurement of it: drawn about the truth.
void DrawPriors(const ParameterSet& truth, std::uint64_t seed, ParameterSet* parameters);

// The truth of one draw. Markers on the compensator's spring sit on its ends as well as they are said to, anew in
// every draw: their points are moved so that what they give of (L, a_x, a_y) is off by a draw of the tie's covariance.
ParameterSet DrawTruth(const ParameterSet& truth, std::uint64_t seed);

// The problem's own experiment at stated parameters. noise_scale multiplies stated sigmas and repeatability; `fallback`
// (m) is the sigma where none is stated.
Simulator RedrawAt(const CalibrationProblem& problem, const ParameterSet& truth, double noise_scale, double fallback);

}  // namespace sagitta
