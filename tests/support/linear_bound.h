// The yardstick of efficiency: generalised least squares linearised at the truth,
// on the same draws as the estimate that is judged.
#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/refit.h"
#include "estimator/least_squares/spring_tie_cost.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::test {

// `like` with every value at the truth; `value` by coordinate name, SI.
inline ParameterSet TrueParameters(ParameterSet like, const Kr270Truth& truth,
                                   const std::function<double(const std::string&)>& value) {
  for (int s = 0; s < like.num_stations(); ++s) {
    like.SetBaseInStation(s, Pose<double>{BaseRotation(truth, s), truth.base_xyz[s]});
  }
  for (int m = 0; m < like.num_markers(); ++m) {
    Vector3<double> point;
    for (int i = 0; i < 3; ++i) point[i] = value(like.coordinates()[like.marker(m).first_coordinate + i].name);
    like.SetMarkerPoint(m, point);
  }
  for (int i = 0; i < like.num_model_parameters(); ++i) {
    const Coordinate& coordinate = like.coordinates()[like.model_parameter(i).first_coordinate];
    if (coordinate.free) like.SetModelValue(i, value(coordinate.name));
  }
  SettleSpringTie(&like);  // as the estimate does: markers on the links that are no ends of the spring
  return like;
}

// Errors of the linear estimate: -C J' r, r the whitened residual of the draw at the truth.
class LinearBound {
 public:
  LinearBound(const CalibrationProblem& problem, const ParameterSet& truth)
      : truth_(truth), columns_(truth.EstimatedCoordinates()) {
    const Linearization fit = LinearizeFit(problem, truth, columns_);
    const LinearSolution solution = SolveLinearization(fit);
    sigma_ = solution.covariance.diagonal().cwiseSqrt();
    gain_ = solution.covariance * fit.jacobian.transpose();
  }
  Eigen::VectorXd Errors(const CalibrationProblem& drawn) const {
    return -gain_ * LinearizeFit(drawn, truth_, columns_).residual;
  }
  // Of the nonlinear estimate, in the same order.
  Eigen::VectorXd ErrorsOf(const Estimate& estimate) const {
    return TangentDifference(estimate.parameters, truth_)(columns_);
  }
  const Eigen::VectorXd& sigma() const { return sigma_; }  // the Cramer-Rao bound
  const std::vector<int>& columns() const { return columns_; }

 private:
  ParameterSet truth_;
  std::vector<int> columns_;
  Eigen::VectorXd sigma_;
  Eigen::MatrixXd gain_;
};

// Sums over draws of one experiment.
struct EfficiencyTally {
  Eigen::ArrayXd joint2, linear2;
  int draws = 0;

  void Add(const Eigen::VectorXd& joint, const Eigen::VectorXd& linear) {
    if (draws++ == 0) joint2 = linear2 = Eigen::ArrayXd::Zero(joint.size());
    joint2 += joint.array().square();
    linear2 += linear.array().square();
  }
  Eigen::ArrayXd Ratio() const { return (joint2 / linear2).sqrt(); }  // RMSE joint / linear
  Eigen::ArrayXd OverBound(const Eigen::VectorXd& sigma) const { return (joint2 / draws).sqrt() / sigma.array(); }
};

}  // namespace sagitta::test
