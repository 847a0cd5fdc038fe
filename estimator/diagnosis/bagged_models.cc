#include "estimator/diagnosis/bagged_models.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "estimator/diagnosis/nameless_cause.h"

namespace sagitta {
namespace {

// Poses fall at random into groups, which are drawn with replacement: each is summed once for all resamples.
constexpr int kGroups = 20;
constexpr unsigned kSeed = 1;
// What may replace a member, or be one more, is asked on the resamples where it is among the first of all:
// so many names in each place, so many explanations in addition to the set. With forty in each place the same kinds of
// effect have 0.9 and more on the UR10's series D.
constexpr size_t kInPlace = 6;
constexpr size_t kBeside = 20;
// Of all that is asked: the sums of the groups are 360 MB then. The UR5 and the UR10 stay below it.
constexpr size_t kMostColumns = 1500;

// Explanations that may have a place on some poses, ascending.
std::vector<int> WorthAsking(const Evidence& evidence, const WeightedModel& leading,
                             const std::vector<std::vector<NamedProbability>>& in_places) {
  std::set<int> asked;
  size_t columns = 0;
  const auto ask = [&](int k) {
    const size_t own = evidence.list().math[static_cast<size_t>(k)].group.columns.size();
    if (columns + own <= kMostColumns && asked.insert(k).second) columns += own;
  };
  for (const int m : leading.set.members) ask(m);
  for (size_t r = 0; r < kInPlace; ++r) {
    for (const std::vector<NamedProbability>& rivals : in_places) {
      if (r < rivals.size()) ask(rivals[r].explanation);
    }
  }
  const std::vector<double> weights = evidence.SearchIn(leading.view).Additions(leading.set);
  std::vector<int> further;
  for (size_t k = 0; k < weights.size(); ++k) {
    if (std::isfinite(weights[k])) further.push_back(static_cast<int>(k));
  }
  const auto end = further.begin() + static_cast<long>(std::min(kBeside, further.size()));
  std::partial_sort(further.begin(), end, further.end(),
                    [&](int a, int b) { return weights[static_cast<size_t>(a)] > weights[static_cast<size_t>(b)]; });
  std::for_each(further.begin(), end, ask);
  return {asked.begin(), asked.end()};
}

std::vector<int> RandomGroups(int poses, std::mt19937* random) {
  std::vector<int> group(static_cast<size_t>(poses));
  for (size_t k = 0; k < group.size(); ++k) group[k] = static_cast<int>(k % kGroups);
  for (size_t k = group.size(); k > 1; --k) std::swap(group[k - 1], group[(*random)() % k]);
  return group;
}

RowSums Resample(const std::vector<RowSums>& groups, std::mt19937* random) {
  RowSums sums = RowSums::Zero(groups[0].products.rows());
  for (size_t draw = 0; draw < groups.size(); ++draw) sums += groups[(*random)() % groups.size()];
  return sums;
}

// The search among few explanations.
class SmallSearch {
 public:
  SmallSearch(const Evidence& evidence, int view, std::vector<int> asked)
      : evidence_(evidence),
        view_(view),
        asked_(std::move(asked)),
        few_(WithTheirColumns(evidence.list().math, asked_)),
        causes_(evidence.list(), evidence.masses().further) {}

  const std::vector<int>& columns() const { return few_.columns; }

  // The most probable set by these sums, in place of all that share the probability there, read as so many causes and
  // as one without a name; probabilities sum to 1.
  std::vector<WeightedModel> Find(const BesideBelieved& beside) {
    const ResidualLikelihood likelihood = evidence_.Likelihood(beside.normal.dof);
    SetSearch search(beside.normal, few_.explanations, evidence_.prior(), likelihood);
    search.ClimbFrom();
    const WeightedSet& here = search.Best();
    WeightedModel best{view_, here, 1.0, 0.0};
    for (int& m : best.set.members) m = asked_[static_cast<size_t>(m)];
    std::vector<WeightedModel> readings = {best};
    const auto one = causes_.ReadAsOne(best.set.members, here, few_.explanations, beside.normal, likelihood);
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
  const int view_;
  const std::vector<int> asked_;  // explanations, ascending
  const FewExplanations few_;
  NamelessCauses causes_;
};

}  // namespace

std::vector<WeightedModel> BaggedModels(const Evidence& evidence, const WeightedModel& leading,
                                        const std::vector<std::vector<NamedProbability>>& in_places) {
  std::vector<WeightedModel> models = evidence.models();
  const EvidenceColumns& columns = evidence.columns();
  if (leading.set.members.empty() || columns.num_poses() < kGroups) return models;
  SmallSearch search(evidence, leading.view, WorthAsking(evidence, leading, in_places));
  std::mt19937 random(kSeed);
  const std::vector<RowSums> groups = columns.SumEach(evidence.views()[leading.view].scatter, search.columns(),
                                                      RandomGroups(columns.num_poses(), &random));
  for (int resample = 0; resample < kResamples; ++resample) {
    for (const WeightedModel& model : search.Find(columns.Project(Resample(groups, &random)))) models.push_back(model);
  }
  for (WeightedModel& model : models) model.log_weight = std::log(model.probability);
  Normalise(&models);
  return models;
}

}  // namespace sagitta
