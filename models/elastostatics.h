// Joint deflections under load, iterated to equilibrium, with exact derivatives.
//
//   u_j = k_j tau_j(u)          deflection of elastic joint j, rad or m
//   tau  = torques of all wrenches at the deflected arm (+ compensator)
//
// paper 000, eq. (2); first order (tau at u = 0) would bias k by up to 0.35 %.
// Newton on G(u) = u - K tau(u) with the second-order term T = d tau / d v.
// Implicit differentiation of the converged state:
//
//   du = A (dK tau + K d tau|_u),   A = (I - K T_u)^-1
//
// so that a slot e whose value moves by dv_e bends the arm by A K T_e dv_e.
#pragma once

#include <optional>
#include <vector>

#include "models/gravity_compensator.h"
#include "models/robot.h"
#include "models/wrench.h"

namespace sagitta {

// A joint with a compliance; its parameters are one k, or one per table node.
struct ElasticJoint {
  int joint = -1;
  int transform = -1;
  std::vector<double> node_q;      // rad or m, ascending
  std::vector<int> node_parameter;  // index into theta, one per node

  // Weights of the nodes at commanded q: piecewise linear, constant outside.
  struct Weight {
    int parameter;
    double weight;
  };
  std::vector<Weight> WeightsAt(double q) const;

  template <typename T>
  T Compliance(double q, const T* theta) const {
    T k(0);
    for (const Weight& w : WeightsAt(q)) k += w.weight * theta[w.parameter];
    return k;
  }
};

struct CompensatorOnJoint {
  int elastic_joint = -1;   // index into ElasticSystem::joints
  int first_parameter = 0;  // L, a_x, a_y, s0, Kc
  double offset = 0.0;      // of the joint's transform, rad
  double sign = 1.0;
  bool preload = true;  // false: only the change against the commanded q

  // Torque on the joint's transform at transform value v, commanded joint value q.
  template <typename T>
  T Torque(const T* theta, const T& v, double q) const {
    const T* p = theta + first_parameter;
    const CompensatorParameters<T> parameters{p[0], p[1], p[2], p[3], p[4]};
    T torque = CompensatorTorque(parameters, T(sign * (v - offset)));
    if (!preload) torque -= CompensatorTorque(parameters, T(q));
    return sign * torque;
  }
};

struct ElasticSystem {
  std::vector<ElasticJoint> joints;
  std::optional<CompensatorOnJoint> compensator;

  bool empty() const { return joints.empty(); }
};

// Where the equilibrium is asked for: data and parameters.
struct ElasticQuery {
  const Chain* chain;
  const ElasticSystem* system;
  const Eigen::VectorXd* q;  // commanded and coupled, one per joint
  const std::vector<AppliedWrench>* wrenches;
};

// Converged state and its derivatives, double.
struct Equilibrium {
  bool converged = false;
  std::vector<double> values;  // v_e, deflections included
  ChainState<double> state;
  Eigen::VectorXd torque;              // tau_j, one per elastic joint
  Eigen::VectorXd compliance;          // k_j
  Eigen::MatrixXd response;            // A
  Eigen::MatrixXd torque_by_value;     // T: d tau_j / d v_e
  Eigen::MatrixXd torque_by_rotation;  // d tau_j / d left perturbation of the base rotation, 3 columns
  Eigen::MatrixXd torque_by_spring;    // d tau_j / d (L, a_x, a_y, s0, Kc), 5 columns; empty without a compensator
};

// values: v_e without deflections. base_rotation: R of base_in_station.
Equilibrium SolveEquilibrium(const ElasticQuery& query, const double* theta, std::vector<double> values,
                             const Matrix3<double>& base_rotation);

// The templated reference: plain fixed-point iteration, no derivative of ours.
template <typename T>
std::vector<T> IterateEquilibrium(const ElasticQuery& query, const T* theta, const std::vector<T>& values,
                                  const Matrix3<T>& base_rotation, int iterations = 60) {
  std::vector<T> deflected = values;
  ChainState<T> state;
  for (int i = 0; i < iterations; ++i) {
    EvaluateChain(*query.chain, deflected.data(), &state);
    std::vector<T> torques;
    for (size_t j = 0; j < query.system->joints.size(); ++j) {
      const int e = query.system->joints[j].transform;
      T torque(0);
      for (const AppliedWrench& wrench : *query.wrenches) {
        torque += GeneralisedForce(*query.chain, state, e, ToBase(wrench, state, base_rotation));
      }
      const auto& compensator = query.system->compensator;
      if (compensator && compensator->elastic_joint == static_cast<int>(j)) {
        torque += compensator->Torque(theta, deflected[e], (*query.q)[query.system->joints[j].joint]);
      }
      torques.push_back(torque);
    }
    for (size_t j = 0; j < query.system->joints.size(); ++j) {
      const ElasticJoint& joint = query.system->joints[j];
      deflected[joint.transform] = values[joint.transform] + joint.Compliance((*query.q)[joint.joint], theta) * torques[j];
    }
  }
  return deflected;
}

}  // namespace sagitta
