#include "estimator/evidence/bagged_models.h"

#include <cmath>
#include <random>

#include "estimator/evidence/nameless_cause.h"

namespace sagitta {
namespace {

constexpr unsigned kSeedOfResamples = 2;  // another than the groups have

// The search among few explanations.
class SmallSearch {
 public:
  SmallSearch(const Evidence& evidence, const PoseGroups& groups)
      : evidence_(evidence), groups_(groups), causes_(evidence.list(), evidence.masses().further) {}

  // The most probable set by these sums, in place of all that share the probability there, read as so many causes and
  // as one without a name; probabilities sum to 1.
  std::vector<WeightedModel> Find(const GivenBelieved& given_believed) {
    const ResidualLikelihood likelihood = evidence_.Likelihood(given_believed.normal.dof);
    SetSearch search(given_believed.normal, groups_.explanations(), evidence_.prior(), likelihood);
    search.ClimbFrom();
    const WeightedSet& here = search.Best();
    WeightedModel best{groups_.view(), here, 1.0, 0.0};
    for (int& m : best.set.members) m = groups_.asked()[static_cast<size_t>(m)];
    std::vector<WeightedModel> readings = {best};
    const auto one =
        causes_.ReadAsOne(best.set.members, here, groups_.explanations(), given_believed.normal, likelihood);
    if (one) {
      best.pieces = one->pieces;
      best.log_weight = one->gain;
      readings.push_back(best);
    }
    Normalise(&readings);
    return readings;
  }

 private:
  const Evidence& evidence_;
  const PoseGroups& groups_;
  NamelessCauses causes_;
};

}  // namespace

std::vector<WeightedModel> BaggedModels(const Evidence& evidence, const WeightedModel& leading,
                                        const PoseGroups& groups) {
  std::vector<WeightedModel> models = evidence.models();
  if (leading.set.members.empty() || groups.HasOnePoseEach()) return models;
  SmallSearch search(evidence, groups);
  std::mt19937 random(kSeedOfResamples);
  for (int resample = 0; resample < kResamples; ++resample) {
    for (const WeightedModel& model : search.Find(groups.Resample(&random))) models.push_back(model);
  }
  for (WeightedModel& model : models) model.log_weight = std::log(model.probability);
  Normalise(&models);
  return models;
}

}  // namespace sagitta
