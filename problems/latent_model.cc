#include "problems/latent_model.h"

#include <functional>
#include <string_view>
#include <utility>

#include "problems/input_error.h"
#include "problems/io/ids_by_text.h"
#include "problems/problem_checks.h"

namespace sagitta {

namespace {

JointType OtherKind(JointType type) {
  return type == JointType::kRevolute ? JointType::kPrismatic : JointType::kRevolute;
}

// What is stated or asked for joints of one kind must find some.
void CheckKind(const Chain& chain, const Experiment& experiment, JointType type) {
  const bool turns = type == JointType::kRevolute;
  const std::string key = turns ? "repeatability_urad" : "repeatability_um";
  const std::string kind = turns ? "revolute" : "prismatic";
  const RepeatabilitySpec::OfKind& spec = experiment.repeatability.Of(type);
  std::vector<std::string> names;
  for (const Joint& joint : chain.joints) {
    if (joint.type == type) names.push_back(joint.name);
  }
  const auto fail = [&](const std::string& where, const std::string& what, const std::string& hint) {
    throw InputError({experiment.file, LineOf(experiment, where), where}, what, hint);
  };
  const std::string other = turns ? "repeatability_um" : "repeatability_urad";
  const bool asked_of_this_kind = spec.estimate && !experiment.repeatability.Of(OtherKind(type)).estimate;
  if ((spec.common || asked_of_this_kind) && names.empty())
    fail(key, "the robot has no " + kind + " joint", "state " + other);
  for (const auto& [name, sigma] : spec.per_joint) {
    const int joint = chain.FindJoint(name);
    if (joint < 0) fail(key + "." + name, "the robot has no joint '" + name + "'", SpellingHint(name, names));
    if (chain.joints[joint].type != type)
      fail(key + "." + name, "joint '" + name + "' is not " + kind, "state " + other);
  }
}

}  // namespace

LatentModel MakeLatentModel(const Chain& chain, const Measurements& data, const Experiment& experiment) {
  LatentModel latent;
  for (const JointType type : {JointType::kRevolute, JointType::kPrismatic}) CheckKind(chain, experiment, type);
  std::vector<double> sigmas;
  for (int j = 0; j < chain.num_joints(); ++j) {
    const Joint& joint = chain.joints[j];
    const double sigma = experiment.repeatability.Of(joint.type).StatedFor(joint.name).value_or(0.0);
    if (sigma <= 0.0) continue;
    latent.joints.push_back(j);
    sigmas.push_back(sigma);
  }
  latent.sigmas = Eigen::Map<Eigen::VectorXd>(sigmas.data(), sigmas.size());
  RenewVisits(data, &latent);
  return latent;
}

void RenewVisits(const Measurements& data, LatentModel* latent) {
  const auto key_of = [&](int s) {
    return std::make_pair(data.shots[s].configuration, std::string_view(data.shots[s].visit));
  };
  PlacesByHash firsts;  // the first shot of each visit
  latent->visit_of_shot.clear();
  latent->num_visits = 0;
  for (int s = 0; s < static_cast<int>(data.shots.size()); ++s) {
    const auto key = key_of(s);
    const size_t hash = (std::hash<std::string_view>()(key.second) ^ static_cast<size_t>(key.first)) * kSpread;
    const int first = firsts.FindOrPut(hash, s, [&](int other) { return key_of(other) == key; });
    latent->visit_of_shot.push_back(first == s ? latent->num_visits++ : latent->visit_of_shot[first]);
  }
}

}  // namespace sagitta
