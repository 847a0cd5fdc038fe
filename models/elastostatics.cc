#include "models/elastostatics.h"

#include <Eigen/LU>
#include <algorithm>
#include <unsupported/Eigen/AutoDiff>
#include <utility>

namespace sagitta {
namespace {

constexpr int kMaxNewtonSteps = 50;
constexpr double kConverged = 1e-14;     // rad or m, of a Newton step
constexpr double kFoldedDeflection = 1.0;  // rad or m: no elastic model means this

// Torques of all elastic joints at the state; with derivatives if asked.
void EvaluateTorques(const ElasticQuery& query, const double* theta, const Matrix3<double>& base_rotation,
                     Equilibrium* equilibrium) {
  const Chain& chain = *query.chain;
  const std::vector<ElasticJoint>& joints = query.system->joints;
  const int n = static_cast<int>(joints.size());
  EvaluateChain(chain, equilibrium->values.data(), &equilibrium->state);
  equilibrium->torque.setZero(n);
  equilibrium->torque_by_value.setZero(n, chain.num_transforms());
  for (const AppliedWrench& wrench : *query.wrenches) {
    const WrenchInBase<double> in_base = ToBase(wrench, equilibrium->state, base_rotation);
    const bool turns = wrench.expressed_in == WrenchFrame::kFlange;
    for (int j = 0; j < n; ++j) {
      const int b = joints[j].transform;
      equilibrium->torque[j] += GeneralisedForce(chain, equilibrium->state, b, in_base);
      for (int a = 0; a < in_base.frame; ++a) {
        equilibrium->torque_by_value(j, a) +=
            GeneralisedForceDerivative(chain, equilibrium->state, b, a, in_base, turns);
      }
    }
  }
  if (!query.system->compensator) return;
  // Six derivatives in one pass: the joint's value and the five parameters.
  using Jet = Eigen::AutoDiffScalar<Eigen::Matrix<double, 6, 1>>;
  const CompensatorOnJoint& compensator = *query.system->compensator;
  const int j = compensator.elastic_joint;
  const int e = joints[j].transform;
  CompensatorOnJoint local = compensator;
  local.first_parameter = 0;
  Jet parameters[5];
  for (int i = 0; i < 5; ++i) parameters[i] = Jet(theta[compensator.first_parameter + i], 6, 1 + i);
  const Jet torque = local.Torque(parameters, Jet(equilibrium->values[e], 6, 0), (*query.q)[joints[j].joint]);
  equilibrium->torque[j] += torque.value();
  equilibrium->torque_by_value(j, e) += torque.derivatives()[0];
  equilibrium->torque_by_spring.setZero(n, 5);
  equilibrium->torque_by_spring.row(j) = torque.derivatives().tail<5>().transpose();
}

// d tau / d left perturbation of R: F_base = R' F, so dF = R' [F]x d(omega).
Eigen::MatrixXd TorqueByRotation(const ElasticQuery& query, const Equilibrium& equilibrium,
                                 const Matrix3<double>& base_rotation) {
  const std::vector<ElasticJoint>& joints = query.system->joints;
  Eigen::MatrixXd derivative = Eigen::MatrixXd::Zero(joints.size(), 3);
  for (const AppliedWrench& wrench : *query.wrenches) {
    if (wrench.expressed_in != WrenchFrame::kMeasurement) continue;
    WrenchInBase<double> change = ToBase(wrench, equilibrium.state, base_rotation);
    for (int axis = 0; axis < 3; ++axis) {
      change.force = base_rotation.transpose() * Skew(wrench.force).col(axis);
      change.moment = base_rotation.transpose() * Skew(wrench.moment).col(axis);
      for (size_t j = 0; j < joints.size(); ++j) {
        derivative(j, axis) += GeneralisedForce(*query.chain, equilibrium.state, joints[j].transform, change);
      }
    }
  }
  return derivative;
}

// A = (I - K T_u)^-1 at the current torques.
Eigen::MatrixXd Response(const ElasticQuery& query, const Equilibrium& equilibrium) {
  const int n = static_cast<int>(query.system->joints.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n, n);
  for (int l = 0; l < n; ++l) {
    matrix.col(l) -= equilibrium.compliance.cwiseProduct(
        equilibrium.torque_by_value.col(query.system->joints[l].transform));
  }
  return matrix.partialPivLu().inverse();
}

}  // namespace

std::vector<ElasticJoint::Weight> ElasticJoint::WeightsAt(double q) const {
  const auto above = std::upper_bound(node_q.begin(), node_q.end(), q) - node_q.begin();
  if (above == 0) return {{node_parameter.front(), 1.0}};
  if (above == static_cast<long>(node_q.size())) return {{node_parameter.back(), 1.0}};
  const double t = (q - node_q[above - 1]) / (node_q[above] - node_q[above - 1]);
  return {{node_parameter[above - 1], 1.0 - t}, {node_parameter[above], t}};
}

Equilibrium SolveEquilibrium(const ElasticQuery& query, const double* theta, std::vector<double> values,
                             const Matrix3<double>& base_rotation) {
  const std::vector<ElasticJoint>& joints = query.system->joints;
  const int n = static_cast<int>(joints.size());
  Equilibrium result;
  result.values = std::move(values);
  result.compliance.resize(n);
  for (int j = 0; j < n; ++j) result.compliance[j] = joints[j].Compliance((*query.q)[joints[j].joint], theta);
  Eigen::VectorXd deflection = Eigen::VectorXd::Zero(n);
  for (int iteration = 0; iteration < kMaxNewtonSteps && !result.converged; ++iteration) {
    EvaluateTorques(query, theta, base_rotation, &result);
    result.response = Response(query, result);
    const Eigen::VectorXd step = result.response * (result.compliance.cwiseProduct(result.torque) - deflection);
    if (!step.allFinite()) return result;
    deflection += step;
    if (deflection.cwiseAbs().maxCoeff() > kFoldedDeflection) return result;
    for (int j = 0; j < n; ++j) result.values[joints[j].transform] += step[j];
    result.converged = step.cwiseAbs().maxCoeff() < kConverged;
  }
  EvaluateTorques(query, theta, base_rotation, &result);
  result.response = Response(query, result);
  result.torque_by_rotation = TorqueByRotation(query, result, base_rotation);
  return result;
}

}  // namespace sagitta
