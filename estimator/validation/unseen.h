// How large the errors are on points that the estimate has not seen, and what it predicted for them.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/row_sums.h"
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
  double freedom = 0.0;           // of the errors, nu below; 0: the noise is not known
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

// A sum of squares of Gaussian errors with covariance V has the mean tr V and the variance 2 tr V^2; by Satterthwaite
// it is tr V chi^2_nu / nu, nu = (tr V)^2 / tr V^2, and F with the degrees of freedom of the noise where that is
// estimated.
struct PredictedSquares {
  double trace = 0.0;            // tr V, m^2
  double of_noise = 0.0;         // of this the readings' scatter, m^2
  double trace_of_square = 0.0;  // tr V^2, m^4
};

// V = diag(noise) + J C J' of points, of which none is kept: both traces follow from J'J and from J' diag(noise) J.
class PredictedSums {
 public:
  explicit PredictedSums(int columns);

  // jacobian: three rows, m/SI, of one point; noise: its root, m.
  void Add(const Matrix3<double>& noise, const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>& jacobian);
  // Points that err by the same sigma (m) on every axis; products: their J'J, m^2/SI^2.
  void Add(double sigma, int points, const Eigen::MatrixXd& products);
  // Of the points so far; root: R of C = R R'. To be asked once.
  PredictedSquares Squares(const Eigen::MatrixXd& root);

 private:
  int columns_;
  SumOfRows points_, by_noise_;
  Eigen::MatrixXd alike_, alike_by_noise_;  // of points that came by their products
  double trace_ = 0.0, square_ = 0.0;       // of the noise
};

// Sets predicted_rms and p_value; nothing where the noise is not known.
void ComparePrediction(const PredictedSquares& predicted, const Estimate& estimate, UnseenPoints* unseen);

// Root of what a reading scatters by, m: instrument and joints' deviations, at the noise that the estimate goes by.
NoiseRoots ScatterOf(const Estimate& estimate, const std::vector<int>& observations);

}  // namespace sagitta
