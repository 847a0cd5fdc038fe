// Sets of explanations that a search has met, by members and by weight.
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <vector>

namespace sagitta {

// A set of explanations and how probable it is.
struct WeightedSet {
  std::vector<int> members;     // ascending
  std::vector<double> scales;   // the best of each
  double log_likelihood = 0.0;  // averaged over the scales (of more than three members: each with the best)
  double log_weight = 0.0;      // prior included
};

// A set without the member at a place, the others at their scales; its weights are to be found.
WeightedSet Without(WeightedSet set, size_t place);

// A set with one more; its weights are to be found.
WeightedSet Grown(WeightedSet set, int candidate, double scale);

// What turns one set into another: places among the members. A member with another scale goes and comes.
struct Difference {
  std::vector<size_t> gone;  // of the one, last first
  std::vector<size_t> come;  // of the other, ascending
};
// From one set to the other.
Difference DifferenceOf(const WeightedSet& one, const WeightedSet& other);

// Sets that were met: by members, and by weight.
class FoundSets {
 public:
  // In place of what was known of its members.
  void Put(WeightedSet set);
  const WeightedSet* Find(const std::vector<int>& members) const;
  const WeightedSet& Best() const { return *by_weight_.begin()->set; }
  // Best first, down to so many log units below the best.
  std::vector<WeightedSet> Within(double within) const;
  // The same, one after the other; calls until `see` is false.
  template <typename See>
  void BestFirst(double within, const See& see) const {
    for (const Place& place : by_weight_) {
      if (place.set->log_weight < Best().log_weight - within || !see(*place.set)) return;
    }
  }

 private:
  struct Place {
    const WeightedSet* set;
    bool operator<(const Place& other) const {
      if (set->log_weight != other.set->log_weight) return set->log_weight > other.set->log_weight;
      return set->members < other.set->members;
    }
  };
  std::map<std::vector<int>, WeightedSet> by_members_;
  std::set<Place> by_weight_;
};

}  // namespace sagitta
