#include "estimator/random_effects/found_sets.h"

#include "estimator/statistics/ascending.h"

namespace sagitta {

WeightedSet Without(WeightedSet set, size_t place) {
  set.members.erase(set.members.begin() + static_cast<long>(place));
  set.scales.erase(set.scales.begin() + static_cast<long>(place));
  return set;
}

Difference DifferenceOf(const WeightedSet& one, const WeightedSet& other) {
  const auto holds = [](const WeightedSet& set, int member, double scale) {
    const size_t place = PlaceIn(set.members, member);
    return place < set.members.size() && set.members[place] == member && set.scales[place] == scale;
  };
  Difference difference;
  for (size_t k = one.members.size(); k-- > 0;) {
    if (!holds(other, one.members[k], one.scales[k])) difference.gone.push_back(k);
  }
  for (size_t k = 0; k < other.members.size(); ++k) {
    if (!holds(one, other.members[k], other.scales[k])) difference.come.push_back(k);
  }
  return difference;
}

WeightedSet Grown(WeightedSet set, int candidate, double scale) {
  const size_t at = PlaceIn(set.members, candidate);
  set.members.insert(set.members.begin() + at, candidate);
  set.scales.insert(set.scales.begin() + at, scale);
  return set;
}

void FoundSets::Put(WeightedSet set) {
  const std::vector<int> members = set.members;
  const auto known = by_members_.find(members);
  if (known != by_members_.end()) {
    by_weight_.erase({&known->second});
    known->second = std::move(set);
    by_weight_.insert({&known->second});
    return;
  }
  by_weight_.insert({&by_members_.emplace(members, std::move(set)).first->second});
}

const WeightedSet* FoundSets::Find(const std::vector<int>& members) const {
  const auto known = by_members_.find(members);
  return known == by_members_.end() ? nullptr : &known->second;
}

std::vector<WeightedSet> FoundSets::Within(double within) const {
  std::vector<WeightedSet> sets;
  BestFirst(within, [&sets](const WeightedSet& set) {
    sets.push_back(set);
    return true;
  });
  return sets;
}

}  // namespace sagitta
