#include "models/elastostatics.h"

#include <Eigen/LU>
#include <cmath>
#include <unsupported/Eigen/AutoDiff>
#include <utility>

namespace sagitta {
namespace {

constexpr int kMaxNewtonSteps = 50;
constexpr double kConverged = 1e-14;       // rad or m, of a Newton step
constexpr double kFoldedDeflection = 1.0;  // rad or m: no elastic model means this

// Torques on the slots and their derivatives by every value, of one set of wrenches.
struct Torques {
  Eigen::VectorXd torque;    // n
  Eigen::MatrixXd by_value;  // n x transforms

  // Derivatives only for slots of `moving`: the others do not answer to torque.
  void Add(const ElasticQuery& query, const ChainState<double>& state, const Matrix3<double>& base_rotation,
           const std::vector<AppliedWrench>& wrenches, double times, const std::vector<bool>& moving) {
    if (times == 0.0) return;
    for (const AppliedWrench& wrench : wrenches) {
      const WrenchInBase<double> in_base = ToBase(wrench, state, base_rotation);
      const bool turns = wrench.expressed_in == WrenchFrame::kFlange;
      for (int s = 0; s < torque.size(); ++s) {
        const int b = (*query.slots)[s];
        torque[s] += times * GeneralisedForce(*query.chain, state, b, in_base);
        for (int a = 0; moving[s] && a < in_base.frame; ++a) {
          by_value(s, a) += times * GeneralisedForceDerivative(*query.chain, state, b, a, in_base, turns);
        }
      }
    }
  }
};

// Six derivatives in one pass: the joint's value and the five parameters.
void AddCompensator(const ElasticQuery& query, const double* theta, int slot, Torques* torques,
                    Equilibrium* equilibrium) {
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 6, 1>>;
  CompensatorOnJoint local = *query.compensator;
  local.first_parameter = 0;
  Dual parameters[5];
  for (int i = 0; i < 5; ++i) parameters[i] = Dual(theta[query.compensator->first_parameter + i], 6, 1 + i);
  const Dual value(equilibrium->values[local.transform], 6, 0);
  const Dual torque = local.Torque(parameters, value, (*query.q)[local.joint]);
  torques->torque[slot] += torque.value();
  torques->by_value(slot, local.transform) += torque.derivatives()[0];
  equilibrium->torque_by_spring.setZero(torques->torque.size(), 5);
  equilibrium->torque_by_spring.row(slot) = torque.derivatives().tail<5>().transpose();
}

int SlotOf(const ElasticQuery& query, int transform) {
  for (size_t s = 0; s < query.slots->size(); ++s) {
    if ((*query.slots)[s] == transform) return static_cast<int>(s);
  }
  return -1;
}

double PhiDerivative(ElasticLaw law, double torque) {
  if (law == ElasticLaw::kCubic) return 3.0 * torque * torque;
  return law == ElasticLaw::kLinear ? 1.0 : 0.0;
}

struct Law {
  Eigen::VectorXd deflection;  // f, n
  Eigen::MatrixXd by_value;    // F = d f / d v, n x transforms
};

// f and F at the current values; fills torque and flexibility.
Law EvaluateLaw(const ElasticQuery& query, const double* theta, const Matrix3<double>& base_rotation,
                Equilibrium* equilibrium) {
  const int n = static_cast<int>(query.slots->size());
  const int transforms = query.chain->num_transforms();
  EvaluateChain(*query.chain, equilibrium->values.data(), &equilibrium->state);
  std::vector<bool> moving(n, false);
  for (const ElasticTerm& term : query.terms->elastic) {
    if (term.factor * theta[term.parameter] != 0.0) moving[SlotOf(query, term.transform)] = true;
  }
  Torques all{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, transforms)};
  all.Add(query, equilibrium->state, base_rotation, *query.wrenches, 1.0, moving);
  for (const WrenchTerm& load : query.terms->wrenches) {
    all.Add(query, equilibrium->state, base_rotation, load.wrenches, theta[load.parameter], moving);
  }
  if (query.compensator != nullptr) {
    AddCompensator(query, theta, SlotOf(query, query.compensator->transform), &all, equilibrium);
  }
  equilibrium->torque = all.torque;
  equilibrium->flexibility.setZero(n);
  Law law{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, transforms)};
  for (const ElasticTerm& term : query.terms->elastic) {
    const int s = SlotOf(query, term.transform);
    const double gain = term.factor * theta[term.parameter];
    law.deflection[s] += gain * ElasticPhi(term.law, all.torque[s]);
    equilibrium->flexibility[s] += gain * PhiDerivative(term.law, all.torque[s]);
  }
  law.by_value = equilibrium->flexibility.asDiagonal() * all.by_value;
  for (const SagTerm& sag : query.terms->sags) {
    if (theta[sag.parameter] == 0.0) continue;
    const int s = SlotOf(query, sag.transform);
    std::vector<bool> this_one(n, false);
    this_one[s] = true;
    Torques own{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, transforms)};
    own.Add(query, equilibrium->state, base_rotation, sag.wrenches, 1.0, this_one);
    law.deflection[s] += theta[sag.parameter] * own.torque[s];
    law.by_value.row(s) += theta[sag.parameter] * own.by_value.row(s);
  }
  return law;
}

Eigen::MatrixXd Response(const ElasticQuery& query, const Law& law) {
  const int n = static_cast<int>(query.slots->size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n, n);
  for (int s = 0; s < n; ++s) matrix.col(s) -= law.by_value.col((*query.slots)[s]);
  return matrix.partialPivLu().inverse();
}

// d tau / d left perturbation of R of some wrenches: F_base = R' F, so
// dF = R' [F]x d(omega). n x 3.
Eigen::MatrixXd TorqueByRotation(const ElasticQuery& query, const ChainState<double>& state,
                                 const std::vector<AppliedWrench>& wrenches, const Matrix3<double>& base_rotation) {
  Eigen::MatrixXd derivative = Eigen::MatrixXd::Zero(query.slots->size(), 3);
  for (const AppliedWrench& wrench : wrenches) {
    if (wrench.expressed_in != WrenchFrame::kMeasurement) continue;
    WrenchInBase<double> change = ToBase(wrench, state, base_rotation);
    for (int axis = 0; axis < 3; ++axis) {
      change.force = base_rotation.transpose() * Skew(wrench.force).col(axis);
      change.moment = base_rotation.transpose() * Skew(wrench.moment).col(axis);
      for (size_t s = 0; s < query.slots->size(); ++s) {
        derivative(s, axis) += GeneralisedForce(*query.chain, state, (*query.slots)[s], change);
      }
    }
  }
  return derivative;
}

void Differentiate(const ElasticQuery& query, const double* theta, const Matrix3<double>& base_rotation, const Law& law,
                   Equilibrium* result) {
  result->by_value = result->response * law.by_value;
  result->by_torque = result->response * result->flexibility.asDiagonal();
  Eigen::MatrixXd torque = TorqueByRotation(query, result->state, *query.wrenches, base_rotation);
  for (const WrenchTerm& load : query.terms->wrenches) {
    torque += theta[load.parameter] * TorqueByRotation(query, result->state, load.wrenches, base_rotation);
  }
  Eigen::MatrixXd by_rotation = result->flexibility.asDiagonal() * torque;
  for (const SagTerm& sag : query.terms->sags) {
    if (theta[sag.parameter] == 0.0) continue;
    const int s = SlotOf(query, sag.transform);
    by_rotation.row(s) +=
        theta[sag.parameter] * TorqueByRotation(query, result->state, sag.wrenches, base_rotation).row(s);
  }
  result->by_rotation = result->response * by_rotation;
}

}  // namespace

Eigen::VectorXd TorquesOf(const ElasticQuery& query, const ChainState<double>& state,
                          const std::vector<AppliedWrench>& wrenches, const Matrix3<double>& base_rotation) {
  Eigen::VectorXd torques = Eigen::VectorXd::Zero(query.slots->size());
  for (const AppliedWrench& wrench : wrenches) {
    const WrenchInBase<double> in_base = ToBase(wrench, state, base_rotation);
    for (int s = 0; s < torques.size(); ++s) {
      torques[s] += GeneralisedForce(*query.chain, state, (*query.slots)[s], in_base);
    }
  }
  return torques;
}

Equilibrium SolveEquilibrium(const ElasticQuery& query, const double* theta, std::vector<double> values,
                             const Matrix3<double>& base_rotation) {
  const int n = static_cast<int>(query.slots->size());
  Equilibrium result;
  result.values = std::move(values);
  Eigen::VectorXd deflection = Eigen::VectorXd::Zero(n);
  for (int iteration = 0; iteration < kMaxNewtonSteps && !result.converged; ++iteration) {
    const Law law = EvaluateLaw(query, theta, base_rotation, &result);
    const Eigen::VectorXd step = Response(query, law) * (law.deflection - deflection);
    if (!step.allFinite()) return result;
    deflection += step;
    if (deflection.cwiseAbs().maxCoeff() > kFoldedDeflection) return result;
    for (int s = 0; s < n; ++s) result.values[(*query.slots)[s]] += step[s];
    result.converged = step.cwiseAbs().maxCoeff() < kConverged;
  }
  const Law law = EvaluateLaw(query, theta, base_rotation, &result);
  result.response = Response(query, law);
  Differentiate(query, theta, base_rotation, law, &result);
  return result;
}

}  // namespace sagitta
