#include "models/elastostatics.h"

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <unsupported/Eigen/AutoDiff>
#include <utility>

namespace sagitta {
namespace {

constexpr int kMaxNewtonSteps = 50;
constexpr double kConverged = 1e-9;        // rad or m, of a Newton step: the next one would be its square
constexpr double kFoldedDeflection = 1.0;  // rad or m: no elastic model means this

// A wrench times a factor, in the base frame.
struct Load {
  WrenchInBase<double> wrench;
  bool turns_with_arm = false;
  double times = 1.0;
};

void AddLoads(const std::vector<AppliedWrench>& wrenches, double times, const ChainState<double>& state,
              const Matrix3<double>& base_rotation, std::vector<Load>* loads) {
  if (times == 0.0) return;
  for (const AppliedWrench& wrench : wrenches) {
    loads->push_back({ToBase(wrench, state, base_rotation), wrench.expressed_in == WrenchFrame::kFlange, times});
  }
}

ForceOnTransform ForceOf(const std::vector<Load>& loads, const ElasticQuery& query, const ChainState<double>& state,
                         int transform, bool differentiate) {
  ForceOnTransform force(*query.chain, state, transform);
  for (const Load& load : loads) {
    force.AddForce(load.wrench, load.times);
    if (differentiate) force.AddDerivative(load.wrench, load.turns_with_arm, load.times);
  }
  return force;
}

// Torques on the slots and their derivatives by every value.
struct Torques {
  Eigen::VectorXd torque;    // n
  Eigen::MatrixXd by_value;  // n x transforms; of slots of `moving` only: the others do not answer to torque
};

Torques TorquesOfLoads(const ElasticQuery& query, const double* theta, const ChainState<double>& state,
                       const Matrix3<double>& base_rotation, const std::vector<bool>& moving) {
  std::vector<Load> loads;
  AddLoads(*query.wrenches, 1.0, state, base_rotation, &loads);
  for (const WrenchTerm& term : query.terms->wrenches) {
    AddLoads(term.wrenches, theta[term.parameter], state, base_rotation, &loads);
  }
  const int n = static_cast<int>(query.slots->size());
  Torques all{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, query.chain->num_transforms())};
  for (int s = 0; s < n; ++s) {
    if (const std::optional<double> stated = StatedTorqueOn(*query.terms, (*query.slots)[s])) {
      all.torque[s] = *stated;
      continue;
    }
    const ForceOnTransform force = ForceOf(loads, query, state, (*query.slots)[s], moving[s]);
    all.torque[s] = force.force();
    if (moving[s]) all.by_value.row(s) = force.ByValues();
  }
  return all;
}

// Six derivatives in one pass: the joint's value and the five parameters.
void AddCompensator(const ElasticQuery& query, const double* theta, int slot, Torques* torques,
                    Equilibrium* equilibrium) {
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 6, 1>>;
  CompensatorOnJoint local = *query.compensator;
  local.first_parameter = 0;
  Dual parameters[5];
  for (int i = 0; i < 5; ++i) parameters[i] = Dual(theta[query.compensator->first_parameter + i], 6, 1 + i);
  equilibrium->torque_by_spring.setZero(torques->torque.size(), 5);
  if (StatedTorqueOn(*query.terms, local.transform)) return;
  const Dual value(equilibrium->values[local.transform], 6, 0);
  const Dual torque = local.Torque(parameters, value, (*query.q)[local.joint]);
  torques->torque[slot] += torque.value();
  torques->by_value(slot, local.transform) += torque.derivatives()[0];
  equilibrium->torque_by_spring.row(slot) = torque.derivatives().tail<5>().transpose();
}

int SlotOf(const ElasticQuery& query, int transform) {
  for (size_t s = 0; s < query.slots->size(); ++s) {
    if ((*query.slots)[s] == transform) return static_cast<int>(s);
  }
  return -1;
}

double PhiDerivative(const ElasticTerm& term, double torque) {
  if (term.law == ElasticLaw::kCubic) return 3.0 * torque * torque;
  if (term.law == ElasticLaw::kLinear) return 1.0;
  const double phi = ElasticPhi(term, torque);
  if (term.law == ElasticLaw::kBump) return -phi * (torque - term.centre) / (term.width * term.width);
  return term.width > 0.0 ? (1.0 - phi * phi) / term.width : 0.0;
}

struct Law {
  Eigen::VectorXd deflection;  // f, n
  Eigen::MatrixXd by_value;    // F = d f / d v, n x transforms
};

// Theta times the wrenches of a sag on its slot is a deflection.
void AddSags(const ElasticQuery& query, const double* theta, const Matrix3<double>& base_rotation,
             const ChainState<double>& state, Law* law) {
  std::map<int, std::vector<Load>> loads;  // by transform
  for (const SagTerm& sag : query.terms->sags) {
    AddLoads(sag.wrenches, theta[sag.parameter], state, base_rotation, &loads[sag.transform]);
  }
  for (const auto& [transform, own] : loads) {
    if (own.empty()) continue;
    const ForceOnTransform sag = ForceOf(own, query, state, transform, true);
    const int s = SlotOf(query, transform);
    law->deflection[s] += sag.force();
    law->by_value.row(s) += sag.ByValues();
  }
}

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
  Torques all = TorquesOfLoads(query, theta, equilibrium->state, base_rotation, moving);
  if (query.compensator != nullptr) {
    AddCompensator(query, theta, SlotOf(query, query.compensator->transform), &all, equilibrium);
  }
  equilibrium->torque = all.torque;
  equilibrium->flexibility.setZero(n);
  Law law{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, transforms)};
  for (const ElasticTerm& term : query.terms->elastic) {
    const int s = SlotOf(query, term.transform);
    const double gain = term.factor * theta[term.parameter];
    law.deflection[s] += gain * ElasticPhi(term, all.torque[s]);
    equilibrium->flexibility[s] += gain * PhiDerivative(term, all.torque[s]);
  }
  law.by_value = equilibrium->flexibility.asDiagonal() * all.by_value;
  AddSags(query, theta, base_rotation, equilibrium->state, &law);
  return law;
}

Eigen::MatrixXd Response(const ElasticQuery& query, const Law& law) {
  const int n = static_cast<int>(query.slots->size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n, n);
  for (int s = 0; s < n; ++s) matrix.col(s) -= law.by_value.col((*query.slots)[s]);
  return matrix.partialPivLu().inverse();
}

// d tau_e / d left perturbation of R of some wrenches: F_base = R' F, so
// dF = R' [F]x d(omega).
Eigen::RowVector3d TorqueByRotation(const ElasticQuery& query, const ChainState<double>& state, int e,
                                    const std::vector<AppliedWrench>& wrenches, const Matrix3<double>& base_rotation) {
  Eigen::RowVector3d derivative = Eigen::RowVector3d::Zero();
  for (const AppliedWrench& wrench : wrenches) {
    if (wrench.expressed_in != WrenchFrame::kMeasurement || e >= wrench.frame) continue;
    WrenchInBase<double> change = ToBase(wrench, state, base_rotation);
    for (int axis = 0; axis < 3; ++axis) {
      change.force = base_rotation.transpose() * Skew(wrench.force).col(axis);
      change.moment = base_rotation.transpose() * Skew(wrench.moment).col(axis);
      derivative[axis] += GeneralisedForce(*query.chain, state, e, change);
    }
  }
  return derivative;
}

void Differentiate(const ElasticQuery& query, const double* theta, const Matrix3<double>& base_rotation, const Law& law,
                   Equilibrium* result) {
  result->by_value = result->response * law.by_value;
  result->by_torque = result->response * result->flexibility.asDiagonal();
  const auto by_rotation_of = [&](int e, const std::vector<AppliedWrench>& wrenches) {
    return TorqueByRotation(query, result->state, e, wrenches, base_rotation);
  };
  Eigen::MatrixXd by_rotation(query.slots->size(), 3);
  for (size_t s = 0; s < query.slots->size(); ++s) {
    const int e = (*query.slots)[s];
    Eigen::RowVector3d torque = Eigen::RowVector3d::Zero();
    if (!StatedTorqueOn(*query.terms, e)) torque = by_rotation_of(e, *query.wrenches);
    for (const WrenchTerm& load : query.terms->wrenches) {
      if (!StatedTorqueOn(*query.terms, e)) torque += theta[load.parameter] * by_rotation_of(e, load.wrenches);
    }
    by_rotation.row(s) = result->flexibility[s] * torque;
  }
  for (const SagTerm& sag : query.terms->sags) {
    if (theta[sag.parameter] == 0.0) continue;
    by_rotation.row(SlotOf(query, sag.transform)) += theta[sag.parameter] * by_rotation_of(sag.transform, sag.wrenches);
  }
  result->by_rotation = result->response * by_rotation;
}

}  // namespace

std::optional<double> StatedTorqueOn(const ShotTerms& terms, int transform) {
  for (const StatedTorque& stated : terms.torques) {
    if (stated.transform == transform) return stated.torque;
  }
  return std::nullopt;
}

Eigen::VectorXd TorquesOf(const ElasticQuery& query, const ChainState<double>& state,
                          const std::vector<AppliedWrench>& wrenches, const Matrix3<double>& base_rotation) {
  Eigen::VectorXd torques = Eigen::VectorXd::Zero(query.slots->size());
  for (int s = 0; s < torques.size(); ++s) {
    if (StatedTorqueOn(*query.terms, (*query.slots)[s])) continue;
    torques[s] = GeneralisedForce(*query.chain, state, (*query.slots)[s], wrenches, base_rotation);
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
