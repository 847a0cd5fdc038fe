#include "estimator/estimate.h"

#include <cmath>
#include <map>

namespace sagitta {

const char* StatusName(Status status) {
  switch (status) {
    case Status::kConverged:
      return "converged";
    case Status::kConvergedWithHeldParameters:
      return "converged_with_held_parameters";
    case Status::kNoConvergence:
      return "no_convergence";
    case Status::kSingular:
      return "singular";
  }
  return "no_convergence";
}

ResidualSize MeasureResiduals(const Eigen::Matrix3Xd& residuals) {
  ResidualSize size;
  size.observations = static_cast<int>(residuals.cols());
  if (residuals.cols() == 0) return size;
  const double n = static_cast<double>(residuals.cols());
  size.rms_axis = (residuals.rowwise().squaredNorm() / n).cwiseSqrt();
  size.rms = std::sqrt(residuals.squaredNorm() / (3.0 * n));
  size.max = residuals.cwiseAbs().maxCoeff();
  size.distance_rms = std::sqrt(residuals.squaredNorm() / n);
  size.distance_max = residuals.colwise().norm().maxCoeff();
  return size;
}

Robot CalibratedRobot(const Robot& robot, const ParameterSet& parameters, const ForwardModel& model) {
  std::map<std::string, double> errors;
  const std::vector<double> theta = parameters.ModelValues();
  for (int i = 0; i < model.num_parameters(); ++i) {
    const std::string& error = model.chain().transforms[model.parameters()[i].transform].error;
    if (theta[i] != 0.0) errors[error] = theta[i];
  }
  return WithGeometricErrors(robot, errors);
}

}  // namespace sagitta
