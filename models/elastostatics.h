// Deflections under load, iterated to equilibrium, with exact derivatives.
//
//   u_e = sum of the elastic and sag terms on slot e at the deflected arm
//       = sum factor theta phi(tau_e) + sum theta tau_e(own wrenches)
//
// e.g. joint compliance u = k tau, paper 000 eq. (2); first order (tau at u = 0)
// would bias k by up to 0.35 %. tau_e collects every wrench of the shot, those of
// load effects and the compensator's torque; where it was measured (StatedTorque) it
// is the measured one, which nothing moves: d tau_e = 0. Newton on G(u) = u - f(u) with the
// second-order term d tau / d v; implicit differentiation of the converged state:
//
//   du = A df|_u,   A = (I - F_u)^-1,   F = d f / d v
//
// so that a slot e whose value moves by dv_e bends the arm by A F_e dv_e.
#pragma once

#include <optional>
#include <vector>

#include "models/effects/bump.h"
#include "models/effects/effect.h"
#include "models/gravity_compensator.h"
#include "models/wrench.h"

namespace sagitta {

struct CompensatorOnJoint {
  int transform = -1;
  int joint = -1;
  int first_parameter = 0;  // L, a_x, a_y, s0, Kc
  double offset = 0.0;      // value of the joint's transform at q = 0, rad
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

// Where the equilibrium is asked for.
struct ElasticQuery {
  const Chain* chain;
  const std::vector<int>* slots;          // transforms that may deflect
  const CompensatorOnJoint* compensator;  // null: none
  const Eigen::VectorXd* q;               // commanded and coupled, one per joint
  const std::vector<AppliedWrench>* wrenches;
  const ShotTerms* terms;
};

// Converged state and its derivatives, double. n = number of slots.
struct Equilibrium {
  bool converged = false;
  std::vector<double> values;  // v_e, deflections included
  ChainState<double> state;
  Eigen::VectorXd torque;            // tau, n
  Eigen::VectorXd flexibility;       // sum factor theta phi'(tau), n
  Eigen::MatrixXd response;          // A, n x n
  Eigen::MatrixXd by_value;          // A F: du / dv_e, n x transforms
  Eigen::MatrixXd by_torque;         // A diag(flexibility): du / d tau from outside, n x n
  Eigen::MatrixXd by_rotation;       // du / d left perturbation of the base rotation, n x 3
  Eigen::MatrixXd torque_by_spring;  // d tau / d (L, a_x, a_y, s0, Kc), n x 5; empty without a compensator
};

// values: v_e without deflections. base_rotation: R of base_in_station.
Equilibrium SolveEquilibrium(const ElasticQuery& query, const double* theta, std::vector<double> values,
                             const Matrix3<double>& base_rotation);

// The measured torque on a transform; nothing where it is the model's.
std::optional<double> StatedTorqueOn(const ShotTerms& terms, int transform);

// Torques of some wrenches on all slots at the equilibrium; 0 where the torque is stated.
Eigen::VectorXd TorquesOf(const ElasticQuery& query, const ChainState<double>& state,
                          const std::vector<AppliedWrench>& wrenches, const Matrix3<double>& base_rotation);

// phi of an elastic law; the derivative of a sign without width is 0.
template <typename T>
T ElasticPhi(const ElasticTerm& term, const T& torque) {
  using std::tanh;
  if (term.law == ElasticLaw::kCubic) return torque * torque * torque;
  if (term.law == ElasticLaw::kLinear) return torque;
  if (term.law == ElasticLaw::kBump) return Bump(torque, term.centre, term.width);
  if (term.width > 0.0) return tanh(torque / T(term.width));
  return T(torque > T(0) ? 1.0 : torque < T(0) ? -1.0 : 0.0);
}

// The templated reference: plain fixed-point iteration, no derivative of ours.
template <typename T>
std::vector<T> IterateEquilibrium(const ElasticQuery& query, const T* theta, const std::vector<T>& values,
                                  const Matrix3<T>& base_rotation, int iterations = 60) {
  std::vector<T> deflected = values;
  ChainState<T> state;
  const auto torque_of = [&](int e, const std::vector<AppliedWrench>& wrenches) {
    return GeneralisedForce(*query.chain, state, e, wrenches, base_rotation);
  };
  for (int i = 0; i < iterations; ++i) {
    EvaluateChain(*query.chain, deflected.data(), &state);
    std::vector<T> next = values;
    for (const ElasticTerm& term : query.terms->elastic) {
      const int e = term.transform;
      const std::optional<double> stated = StatedTorqueOn(*query.terms, e);
      T torque = stated ? T(*stated) : torque_of(e, *query.wrenches);
      for (const WrenchTerm& load : query.terms->wrenches) {
        if (!stated) torque += theta[load.parameter] * torque_of(e, load.wrenches);
      }
      if (!stated && query.compensator != nullptr && query.compensator->transform == e) {
        torque += query.compensator->Torque(theta, deflected[e], (*query.q)[query.compensator->joint]);
      }
      next[e] += term.factor * theta[term.parameter] * ElasticPhi(term, torque);
    }
    for (const SagTerm& sag : query.terms->sags) {
      next[sag.transform] += theta[sag.parameter] * torque_of(sag.transform, sag.wrenches);
    }
    deflected = next;
  }
  return deflected;
}

}  // namespace sagitta
