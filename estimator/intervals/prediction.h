// How certain a predicted point is, as a 3x3 covariance in the station's frame,
// by where it comes from:
//
//   parameters   J C J'         of the estimated ones
//   held         K S K'         K = J_h + J G: what held parameters leave open (held_influence.h)
//   model        s^2 I          what a rest that no parameter shows adds (AddedByRest)
//   arm          L L'           the joints' repeatability: where the arm stops at one arrival
//
// A prediction of the mean has the first three; what one measurement will show has all, and the instrument's
// covariance, which is handed on by itself (Prediction::instrument). Of the readings of many points together:
// predicted_squares.h, with A = [J sqrt(C), K sqrt(S)].
#pragma once

#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/intervals/predicted_squares.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {

// What an estimate knows of its parameters; rows and columns follow `estimated`
// and `held`, names of coordinates.
struct ParameterUncertainty {
  std::vector<std::string> estimated;
  Eigen::MatrixXd covariance;  // C, SI
  std::vector<std::string> held;
  Eigen::MatrixXd slopes;         // G, SI
  Eigen::MatrixXd second_moment;  // S, SI

  std::vector<std::string> Names() const;  // those that are held after the estimated ones
};

// Covariance of a predicted point, m^2, by where it comes from.
struct PredictionCovariance {
  Matrix3<double> parameters = Matrix3<double>::Zero();  // m^2
  Matrix3<double> held = Matrix3<double>::Zero();
  Matrix3<double> arm = Matrix3<double>::Zero();
  Matrix3<double> model = Matrix3<double>::Zero();  // what a rest that no parameter shows adds (AddedByRest)
  Matrix3<double> mean() const { return parameters + held + model; }
};

// What is added to a point's covariance, alike in all directions, so that its root mean square distance is no less than
// `rest` (m): what the model lacks and no parameter's covariance shows, as where it is alike in all parts of the data.
Matrix3<double> AddedByRest(const Matrix3<double>& covariance, double rest);

// One per listed observation. Coordinates that the problem does not have (other
// stations, other markers) do not act. noise_scale: of the stated repeatability; instrument: root of one measurement's
// covariance of each, m. together: of those that are points.
std::vector<PredictionCovariance> PredictionCovariances(const CalibrationProblem& problem,
                                                        const ParameterUncertainty& uncertainty,
                                                        const std::vector<int>& observations, double noise_scale,
                                                        const NoiseRoots& instrument, PredictedSquares* together);

}  // namespace sagitta
