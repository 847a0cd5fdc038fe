// What the noise is, in words: fills source and words of the NoiseReport, and the warnings of the estimate.
#pragma once

#include <string>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// tau: what every coordinate scatters by in addition to the stated sigmas, m (noise/robot_scatter.h).
std::string RobotScatterInWords(double tau);
// spread: the same of every axis of a rotation, rad; instead of what is stated, where none of them states any.
std::string RotationScatterInWords(double spread, bool is_in_addition);
// What residuals are compared with: "the stated sigmas", "the scatter of the repeats", "the noise that was found".
std::string NameOfNoise(NoiseOrigin origin);
// What chi-square says of it, at the significance of the experiment.
std::string SigmaInWords(const Estimate& estimate, double significance);
// Warns that the readings do not determine what rotations scatter by. by_repeats: the noise of points is known.
void SayRotationsAreAssumed(bool by_repeats, Estimate* estimate);

// What outliers share: `hits` of `outliers` are of a category that has `share` of the rows; they lie between two
// values.
std::string OutliersAreOf(int hits, int outliers, const std::string& category, double share);
std::string OutliersLieAt(const std::string& what, double from, double to, const std::string& unit);
std::string AreNoMinority(double share);
// By how much: "3.67 mm and 14.5 mrad".
std::string OutlierIsOffBy(const Outlier& outlier);

// Where it is from alone: of an estimate whose noise nothing was looked for in, as a diagnosis's.
void DescribeOrigin(const CalibrationProblem& problem, Estimate* estimate);
void DescribeNoise(const CalibrationProblem& problem, Estimate* estimate);

}  // namespace sagitta
