// What a diagnosis says of the noise, for people.
#pragma once

#include <string>

#include "estimator/diagnosis/noise_finding.h"

namespace sagitta {

// Scale, repeatability, outliers; or that it is as stated.
std::string NoiseInWords(const NoiseFinding& noise);

// Of the verdict `noise`: what is wrong with it.
std::string WrongNoiseInWords(const NoiseFinding& noise);

}  // namespace sagitta
