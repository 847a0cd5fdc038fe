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

// Errors on points that were not fitted.
struct UnseenPoints {
  int points = 0;
  double rms = 0.0;                                                                       // m, per coordinate
  double distance_rms = 0.0, distance_p50 = 0.0, distance_p95 = 0.0, distance_max = 0.0;  // m
  std::vector<FarPose> worst;     // farthest first, five at most
  std::vector<double> distances;  // m, in row order
  PoseAccuracy pose_accuracy;     // AP of ISO 9283

  // m, per coordinate: noise and parameters; 0: the noise is not known. p_value: that errors as large as these come
  // about although the prediction is right.
  double predicted_rms = 0.0;
  double p_value = 1.0;
  double Excess() const { return predicted_rms > 0.0 ? rms / predicted_rms : 1.0; }
};

// observations: of each column of `errors` (3 x N, measured - predicted, m).
UnseenPoints MeasureUnseen(const CalibrationProblem& problem, const std::vector<int>& observations,
                           const Eigen::Matrix3Xd& errors);

// A sum of squares of Gaussian errors with covariance V has the mean tr V and the variance 2 tr V^2; by Satterthwaite
// it is tr V chi^2_nu / nu, nu = (tr V)^2 / tr V^2, and F with the degrees of freedom of the noise where that is
// estimated.
struct PredictedSquares {
  double trace = 0.0;            // tr V, m^2
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
