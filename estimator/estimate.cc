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
    case Status::kEquilibriumDiverged:
      return "equilibrium_diverged";
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
  const std::vector<double> theta = parameters.ModelValues();
  std::map<std::string, double> errors;
  for (int i = 0; i < model.num_parameters(); ++i) {
    const ModelParameter& parameter = model.parameters()[i];
    if (parameter.law != ParameterLaw::kGeometry || theta[i] == 0.0) continue;
    errors[model.chain().transforms[parameter.index].error] = theta[i];
  }
  Robot calibrated = WithGeometricErrors(robot, errors);
  const ElasticSystem& elastic = model.elastic_system();
  for (size_t j = 0; j < elastic.joints.size(); ++j) {
    std::vector<JointCompliance::Node>& nodes = calibrated.compliances[j].nodes;
    for (size_t n = 0; n < nodes.size(); ++n) nodes[n].k = theta[elastic.joints[j].node_parameter[n]];
  }
  if (elastic.compensator) {
    GravityCompensator& spring = *calibrated.gravity_compensator;
    const double* p = theta.data() + elastic.compensator->first_parameter;
    spring.L = p[0], spring.a_x = p[1], spring.a_y = p[2], spring.s0 = p[3], spring.Kc = p[4];
  }
  return calibrated;
}

}  // namespace sagitta
