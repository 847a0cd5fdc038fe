#include "problems/latent_model.h"

#include <map>
#include <utility>

#include "problems/input_error.h"
#include "problems/problem_checks.h"

namespace sagitta {

LatentModel MakeLatentModel(const Chain& chain, const Measurements& data, const Experiment& experiment) {
  LatentModel latent;
  const RepeatabilitySpec& spec = experiment.repeatability;
  std::vector<std::string> names;
  for (const Joint& joint : chain.joints) names.push_back(joint.name);
  for (const auto& [name, sigma] : spec.per_joint) {
    if (chain.FindJoint(name) >= 0) continue;
    const std::string key = "repeatability_urad." + name;
    throw InputError({experiment.file, LineOf(experiment, key), key}, "the robot has no joint '" + name + "'",
                     SpellingHint(name, names));
  }
  std::vector<double> sigmas;
  for (int j = 0; j < chain.num_joints(); ++j) {
    const auto own = spec.per_joint.find(chain.joints[j].name);
    const double sigma = own != spec.per_joint.end() ? own->second : spec.common.value_or(0.0);
    if (sigma <= 0.0) continue;
    latent.joints.push_back(j);
    sigmas.push_back(sigma);
  }
  latent.sigmas = Eigen::Map<Eigen::VectorXd>(sigmas.data(), sigmas.size());
  std::map<std::pair<int, std::string>, int> visits;
  for (const Shot& shot : data.shots) {
    const auto key = std::make_pair(shot.configuration, shot.visit);
    latent.visit_of_shot.push_back(visits.emplace(key, static_cast<int>(visits.size())).first->second);
  }
  latent.num_visits = static_cast<int>(visits.size());
  return latent;
}

}  // namespace sagitta
