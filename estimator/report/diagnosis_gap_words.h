// What a diagnosis says of fit, noise floor and gap, before and after.
#pragma once

#include <string>

#include "estimator/diagnosis/diagnose.h"

namespace sagitta {

std::string GapIsNotKnown(const GapReport& gap);
// Whether its interval leaves open which share of the gap is closed.
bool MayBeAnyShare(const GapReport& gap);
std::string ClosedInWords(const GapReport& gap);
// "Gap on untouched configurations, beyond the noise floor: 0.24 -> 0.18 mm, …", a line.
std::string GapInWords(const Diagnosis& diagnosis);
// Why the floor goes without the noise that is found (GapReport::floor_is_as_stated).
std::string FloorGoesByStatedNoise();
// "reduced chi-square 1.02". Where nothing states the noise, the scatter about each model is its own unit, and
// chi-square compares nothing: "fit RMS 0.064 mm".
std::string FitInWords(const Diagnosis& diagnosis, const Estimate& estimate);
// By which noise the final model's reduced chi-square goes, where that is not as stated: "with the noise that is
// found".
std::string NoiseOfFinalInWords(const Diagnosis& diagnosis);

}  // namespace sagitta
