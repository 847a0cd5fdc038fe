// What configurations say that nothing was chosen or fitted on: how well a model predicts them, whether another does so
// better or worse beyond chance, and the gap,
//
//   gap^2 = holdout rms^2 - noise floor^2,   closed = 1 - after^2 / before^2
#pragma once

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

// Configurations: the gain of two is at most sqrt(2) of its own scatter, less than the 1.64 that 5 % ask for (gap.cc).
inline constexpr int kFewHeldOut = 3;
// The gains of n of them are sqrt(n) of their own scatter at most: fewer than so many confirm next to nothing.
inline constexpr int kFewGains = 6;

// Of each group of configurations with equal joint values, which share what a model lacks there (split.h): of its
// points that were held out (Measurements::PointsAmong) the sum of squared residuals, m^2, and how many coordinates.
struct HoldoutSums {
  Eigen::VectorXd squares, coordinates;
};
// As the estimate has predicted these points where it has.
HoldoutSums SumHoldout(const DiagnosedModel& model);
int CountHeldOut(const DiagnosedModel& model);  // such groups
// RMS over the coordinates of the hold-out, m; not a number without one.
double HoldoutRms(const DiagnosedModel& model);
// With a prediction of these points, where the model is asked for them several times.
DiagnosedModel PredictingHoldout(DiagnosedModel model);

// By how much the second model predicts untouched configurations better than the first, in standard deviations of a
// normal distribution: by the scatter of the differences between configurations, or by their signs where one
// configuration that shows the effect most is most of that scatter. Whether that is beyond chance (5 %, one-sided).
double HoldoutGain(const DiagnosedModel& before, const DiagnosedModel& after);
bool IsBeyondChance(double gain);
// Whether the second model predicts untouched configurations worse than the first, beyond chance (1 %, one-sided): by
// the scatter of the differences between configurations, or by how much their root mean square has grown.
bool MakesHoldoutWorse(const DiagnosedModel& before, const DiagnosedModel& after);
// Degrees of freedom of the squares of the points held out: nu of predicted_squares.h, whose few configurations share
// the errors of the parameters; at most three for each configuration, whose points may share what they deviate by.
double FreedomOfHoldout(const DiagnosedModel& model);
// P that untouched rows scatter as much although noise and parameters are all that moves them; not a number with fewer
// than kFewHeldOut configurations.
double ChanceOfHoldout(const DiagnosedModel& model, bool is_sigma_stated);
// Whether that is below its share of the significance.
bool IsFarFromFloor(const DiagnosedModel& model, bool is_sigma_stated, double significance);

// Not a number without a hold-out, and where nothing states the noise: a floor that is the model's own scatter would
// call every gap closed. No interval below three held-out configurations.
struct GapReport {
  double floor = 0.0;                // m; not a number where nothing states the noise
  double p = kNotKnown;              // ChanceOfHoldout of the extended model; known where the noise is stated
  double before = 0.0, after = 0.0;  // m
  double closed = 0.0;               // share of the squared gap; not a number where there was none
  Interval closed_ci95;              // bootstrap over hold-out configurations
  // Another noise is found, and the floor goes without it: it may be an error that follows the pose.
  bool floor_is_as_stated = false;
};

// How much of the gap of the baseline the extended model closes on the hold-out, above a floor (m).
GapReport JudgeGap(const DiagnosedModel& baseline, const DiagnosedModel& extended, double floor, bool is_noise_stated);

}  // namespace sagitta
