// Covariances of predicted points from a judged estimate, without noise of an instrument.
#pragma once

#include <vector>

#include "estimator/intervals/prediction.h"

namespace sagitta::test {

inline ParameterUncertainty UncertaintyOf(const Estimate& estimate) {
  ParameterUncertainty uncertainty;
  const std::vector<Coordinate>& coordinates = estimate.parameters.coordinates();
  for (const int i : estimate.estimated) uncertainty.estimated.push_back(coordinates[i].name);
  for (const int i : estimate.held.coordinates) uncertainty.held.push_back(coordinates[i].name);
  uncertainty.covariance = estimate.covariance;
  uncertainty.slopes = estimate.held.slopes;
  uncertainty.second_moment = estimate.held.second_moment;
  return uncertainty;
}

inline std::vector<PredictionCovariance> CovariancesWithoutNoise(const CalibrationProblem& problem,
                                                                 const Estimate& estimate, const std::vector<int>& rows,
                                                                 double noise_scale) {
  PredictedSquares together;
  return PredictionCovariances(problem, UncertaintyOf(estimate), rows, noise_scale,
                               NoiseRoots(rows.size(), Matrix3<double>::Zero()), &together);
}

}  // namespace sagitta::test
