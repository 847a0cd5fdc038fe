// The parameters of a forward model: which there are, their nominal values, and the way back into a robot.
#include <charconv>

#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "models/effects/term_checks.h"
#include "models/forward_model.h"
#include "models/gravity_compensator.h"

namespace sagitta {
namespace {

std::string ShortNumber(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6).ptr;
  return {text, end};
}

}  // namespace

void ForwardModel::AddGeometry() {
  for (int e = 0; e < chain().num_transforms(); ++e) {
    const ElementaryTransform& transform = chain().transforms[e];
    if (transform.error.empty()) continue;
    const Quantity quantity = transform.is_rotation() ? Quantity::kAngle : Quantity::kLength;
    parameters_.push_back({GeometryName(transform.error), quantity, ParameterLaw::kGeometry, e});
  }
}

void ForwardModel::AddCompliances() {
  for (size_t c = 0; c < robot_.compliances.size(); ++c) {
    const JointCompliance& compliance = robot_.compliances[c];
    const Joint& joint = chain().joints[compliance.joint];
    const bool turns = joint.type == JointType::kRevolute;
    elastic_slots_.push_back(chain().JointTransform(compliance.joint));
    first_of_compliance_.push_back(num_parameters());
    for (const JointCompliance::Node& node : compliance.nodes) {
      std::string name = "compliance/" + joint.name;
      if (compliance.is_table) name += "@" + ShortNumber(turns ? node.q / kDegree : node.q / 1e-3);
      const Quantity quantity = turns ? Quantity::kCompliance : Quantity::kLinearCompliance;
      parameters_.push_back({name, quantity, ParameterLaw::kCompliance, static_cast<int>(c), node.k, 0.0});
    }
  }
}

void ForwardModel::AddCompensator() {
  if (!robot_.gravity_compensator) return;
  const GravityCompensator& spring = *robot_.gravity_compensator;
  const int slot = chain().JointTransform(spring.joint);
  const ElementaryTransform& transform = chain().transforms[slot];
  elastic_slots_.push_back(slot);
  const double zero = spring.zero.value_or(transform.nominal);
  compensator_ = CompensatorOnJoint{slot, spring.joint, num_parameters(), zero, transform.sign, spring.preload};
  const double nominal[5] = {spring.L, spring.a_x, spring.a_y, spring.s0, spring.Kc};
  for (const CompensatorPart part : kCompensatorParts) {
    const Quantity quantity = part == CompensatorPart::kKc ? Quantity::kSpringRate : Quantity::kLength;
    const int i = static_cast<int>(part);
    parameters_.push_back({NameOf(part), quantity, ParameterLaw::kCompensator, i, nominal[i]});
    if (!spring.prior_sigmas.empty()) parameters_.back().prior_sigma = spring.prior_sigmas[i];
  }
  // No spring is shorter than nothing, or pushes harder the less it is pressed.
  for (const int i : {0, 3, 4}) parameters_[compensator_->first_parameter + i].lower = 0.0;
}

void ForwardModel::AddEffects() {
  for (size_t i = 0; i < robot_.effects.size(); ++i) {
    const EffectSpec& spec = robot_.effects[i];
    const EffectDefinition& definition = *FindEffect(robot_, spec.effect);
    definitions_.push_back(&definition);
    first_of_effect_.push_back(num_parameters());
    const std::vector<EffectParameter> parameters = definition.parameters(robot_, spec);
    for (size_t p = 0; p < parameters.size(); ++p) {
      const double value = p < spec.values.size() ? spec.values[p] : 0.0;
      parameters_.push_back({spec.Path() + "/" + parameters[p].name, parameters[p].quantity, ParameterLaw::kEffect,
                             static_cast<int>(i), value});
      if (p < spec.prior_sigmas.size()) parameters_.back().prior_sigma = spec.prior_sigmas[p];
    }
    // Which slots deflect does not depend on the shot: ask with an empty one.
    ShotConditions nothing;
    nothing.q = Eigen::VectorXd::Zero(chain().num_joints());
    nothing.approach.assign(chain().num_joints(), 0);
    ShotTerms terms;
    ApplyEffect(i, nothing, 0.0, &terms);
    for (const ElasticTerm& term : terms.elastic) elastic_slots_.push_back(term.transform);
    for (const SagTerm& term : terms.sags) elastic_slots_.push_back(term.transform);
  }
}

void ForwardModel::ApplyEffect(size_t i, const ShotConditions& shot, double memory, ShotTerms* terms) const {
  definitions_[i]->apply({&robot_, &robot_.effects[i], &shot, &markers_, first_of_effect_[i], memory}, terms);
  const std::string& name = robot_.effects[i].effect;
  if (robot_.own_effects.empty() || FindEffect(name) != nullptr) return;  // the catalogue's are tested
  CheckTerms(*terms, num_parameters(), chain().num_transforms(), static_cast<int>(markers_.size()), name);
}

std::vector<double> ForwardModel::NominalValues() const {
  std::vector<double> theta;
  for (const ModelParameter& parameter : parameters_) theta.push_back(parameter.nominal);
  return theta;
}

Robot ForwardModel::WithValues(const std::vector<double>& theta) const {
  std::map<std::string, double> errors;
  for (int i = 0; i < num_parameters(); ++i) {
    if (parameters_[i].law != ParameterLaw::kGeometry || theta[i] == 0.0) continue;
    errors[chain().transforms[parameters_[i].index].error] = theta[i];
  }
  Robot robot = WithGeometricErrors(robot_, errors);
  for (size_t c = 0; c < robot.compliances.size(); ++c) {
    std::vector<JointCompliance::Node>& nodes = robot.compliances[c].nodes;
    for (size_t n = 0; n < nodes.size(); ++n) nodes[n].k = theta[first_of_compliance_[c] + n];
  }
  if (compensator_) {
    GravityCompensator& spring = *robot.gravity_compensator;
    const double* p = theta.data() + compensator_->first_parameter;
    spring.L = p[0], spring.a_x = p[1], spring.a_y = p[2], spring.s0 = p[3], spring.Kc = p[4];
    if (errors.count(chain().transforms[compensator_->transform].error) > 0) spring.zero = compensator_->offset;
  }
  for (size_t i = 0; i < robot.effects.size(); ++i) {
    const size_t count = FindEffect(robot, robot.effects[i].effect)->parameters(robot, robot.effects[i]).size();
    const auto first = theta.begin() + first_of_effect_[i];
    robot.effects[i].values.assign(first, first + static_cast<long>(count));
  }
  return robot;
}

}  // namespace sagitta
