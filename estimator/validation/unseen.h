// How large the errors are on points that the estimate has not seen, and what it predicted for them.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/intervals/predicted_squares.h"
#include "estimator/validation/pose_accuracy.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct FarPose {
  std::string configuration;
  double distance = 0.0;  // m, the largest of its points
};

// Errors are e^2 = s^2 + t^2, s predicted, t unknown. Intervals are widened by e / s; beyond the root of two more of an
// error is unknown than known, and one factor for all intervals stands for it no more.
constexpr double kMostlyUnknown = 1.4142135623730951;

// Errors on points that were not fitted.
struct UnseenPoints {
  int points = 0;
  double rms = 0.0;                                                                       // m, per coordinate
  double distance_rms = 0.0, distance_p50 = 0.0, distance_p95 = 0.0, distance_max = 0.0;  // m
  std::vector<FarPose> worst;     // farthest first, five at most
  std::vector<double> distances;  // m, in row order
  std::vector<double> squares;    // m^2, summed over the points of each configuration, in their order
  PoseAccuracy pose_accuracy;     // AP of ISO 9283

  // m, per coordinate: noise and parameters; 0: the noise is not known. p_value: that errors as large as these come
  // about although the prediction is right.
  double predicted_rms = 0.0;
  double p_value = 1.0;
  double p_mostly_unknown = 1.0;  // the same although the errors are kMostlyUnknown times those predicted
  double parameters_share = 0.0;  // of the squares predicted: what uncertain parameters add to the noise
  double freedom = 0.0;           // of the errors, nu of predicted_squares.h; 0: the noise is not known
  double Excess() const { return predicted_rms > 0.0 ? rms / predicted_rms : 1.0; }
};

// observations: of each column of `errors` (3 x N, measured - predicted, m).
UnseenPoints MeasureUnseen(const CalibrationProblem& problem, const std::vector<int>& observations,
                           const Eigen::Matrix3Xd& errors);

// How two robots compare on the same points. The points of a configuration share the robot's error: with the sums of
// squares a_c and b_c of configuration c, A and B of all n,
//
//   var log(B / A) = n / (n - 1) sum_c (b_c / B - a_c / A)^2    (delta method over configurations).
//
// What an estimate adds by the uncertainty that it states makes it no worse than a file that happens to be right: worse
// is one of which A without that share is still beyond B.
enum class Compared { kBetter, kAsGood, kWithinUncertainty, kWorse };
struct Gain {
  double ratio = 1.0;  // RMS before / RMS after
  Compared compared = Compared::kWithinUncertainty;
};
// significance: of a robot that is called worse than before; better is beyond a 95 % interval. least: share by which
// RMS differ before one is called better.
Gain CompareRms(const UnseenPoints& before, const UnseenPoints& after, double significance, double least);

// Sets predicted_rms and p_value; nothing where the noise is not known.
// of_stated: degrees of freedom of the noise where it is stated (DofOfSizes).
void ComparePrediction(const PredictedSquares& predicted, const Estimate& estimate, UnseenPoints* unseen,
                       double of_stated = std::numeric_limits<double>::infinity());

// Times of the stated noise, instrument's and joints', that the estimate goes by.
double TimesStated(const Estimate& estimate);
// Root of the covariance of one measurement by the instrument, m, at that noise.
NoiseRoots InstrumentOf(const Estimate& estimate, const std::vector<int>& observations);

}  // namespace sagitta
