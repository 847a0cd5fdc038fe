// One search over sets of explanations. A set's weight is its prior times its marginal likelihood; the moves are add,
// drop and swap, each the conditioning of the same normal equations (sweep.h). What a member needs comes and goes with
// it.
#pragma once

#include <limits>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "estimator/random_effects/explanation.h"
#include "estimator/random_effects/found_sets.h"

namespace sagitta {

// Climbs and grows sets of explanations by their marginal likelihood.
class SetSearch {
 public:
  SetSearch(const ProjectedNormal& normal, const std::vector<Explanation>& explanations, const SetPrior& prior,
            const ResidualLikelihood& likelihood);

  // To a set that no addition, drop or swap improves. start: a set to climb from.
  void ClimbFrom(const WeightedSet& start = {});
  // After a climb: the neighbours of the sets that share the probability. Sets within kWorthKeeping of the best, best
  // first; the empty one is always among them.
  std::vector<WeightedSet> Explore();
  const WeightedSet& Best() const { return found_.Best(); }
  // Sets within so many log units of the best that were met so far, best first; neighbours by what a move says.
  std::vector<WeightedSet> Met(double within) const { return found_.Within(within); }
  const WeightedSet& Empty() const { return *found_.Find({}); }
  // One set; scales start where they are given.
  WeightedSet Evaluate(const std::vector<int>& members, const std::vector<double>& scales = {}) const;
  // What the log weight of a set loses without each of its members.
  std::vector<double> LossesOf(const WeightedSet& set) const;
  // Log weights of this set with each further explanation, averaged over its scale given the best of the others;
  // -infinity where it is excluded. Of a set without one of its members: what else could stand in its place, but for a
  // constant.
  std::vector<double> Additions(const WeightedSet& given) const;

 private:
  using Key = std::vector<int>;

  bool IsExcluded(const Key& members, int candidate) const;
  // What it needs and the members lack; kNoExplanation.
  int LackedBy(const Key& members, int candidate) const;
  std::vector<double> SharesOf(const Key& members) const;
  double LogPriorOf(const Key& members) const;
  // 0, or what a set is worth less that lacks the weight all are assumed to hold; with one more member.
  double LogOfLack(const Key& members, int more = kNoExplanation) const;
  double LogPriorWithMore(const Key& members, int count) const;  // the shares of so many more 1
  // A candidate as it comes to a set: by itself, or with what it needs as one group of one scale.
  struct Coming {
    const ColumnGroup* group = nullptr;
    const Eigen::MatrixXd* own = nullptr;  // information, in units of its typical sizes
    double log_share = 0.0;
    int count = 1;
  };
  Coming ComingTo(const Key& members, int candidate) const;
  WeightedSet With(WeightedSet set, int candidate, double scale) const;  // its weights are to be found
  // Without the member at a place and those that need it.
  WeightedSet Less(const WeightedSet& set, size_t place) const;
  Members Less(Members members, const WeightedSet& set, size_t place) const;
  // conditioned: the members, at scales to begin with.
  WeightedSet EvaluateFrom(const std::vector<int>& given_members, Members conditioned) const;
  double AverageOverScales(const Members& members) const;
  const Eigen::MatrixXd& OwnOf(size_t candidate) const;
  // Which additions are asked for: groups of fewer columns than so many, general ones too or not, and all that come
  // within so much of `most`, or of the best of them where that is better; others may be left out.
  struct Asked {
    int columns = std::numeric_limits<int>::max();
    bool general = true;
    double most = -std::numeric_limits<double>::infinity(), within = std::numeric_limits<double>::infinity();
  };
  // -infinity: left out. scales: the best of each.
  std::vector<double> AdditionsTo(const WeightedSet& set, const Asked& asked, std::vector<double>* scales) const;
  // Given a set: by what comes to the set before, and goes from it.
  const Sweep& SweepOf(const WeightedSet& set) const;
  // Conditioned; by what comes to those of the sweep, and goes from them.
  Members MembersOf(const WeightedSet& set) const;
  void Expand(const WeightedSet& given);
  void RecordGrown(WeightedSet set, int candidate, double scale, double log_weight);
  // replaces: an evaluation, which is better than what an addition says.
  void Record(WeightedSet set, bool replaces = false);
  // conditioned: its members, at its scales, where they are at hand.
  WeightedSet Settled(const WeightedSet& set, const Members* conditioned = nullptr);
  // A set without each of its members, the others' scales and averages kept unless the set is small. all: its members,
  // at its scales.
  std::vector<WeightedSet> WithoutEach(const WeightedSet& set, const Members& all) const;
  struct Swap {
    size_t member;       // place in the set
    int candidate = -1;  // none: the member is dropped
    double scale = 1.0, log_weight = 0.0;
  };
  // Sweeps that swap or drop a member. True: a better set was found.
  bool Exchange(const WeightedSet& set);
  std::vector<Swap> SwapsOf(const WeightedSet& set, const Sweep& sweep, const std::vector<WeightedSet>& without);
  // Several smaller causes in the place of a member, which no single move exchanges. True: a better set was found.
  bool BreakUp(const WeightedSet& set);
  // The set with the best in addition that has fewer columns than so many and is not general.
  WeightedSet WithBestCause(const WeightedSet& set, int columns);
  // The causes that are not among the others each exchanged for the best given the rest, once around.
  WeightedSet EachAnew(WeightedSet causes, const WeightedSet& others, int columns);
  void SwapTogether(const WeightedSet& set, const Members& all, const std::vector<Swap>& swaps);
  void Climb(WeightedSet from);
  void SettleAll();
  double BestWeight() const { return Best().log_weight; }

  const ProjectedNormal& normal_;
  const std::vector<Explanation>& explanations_;
  SetPrior prior_;
  ResidualLikelihood likelihood_;
  FoundSets found_;
  std::set<Key> expanded_, settled_, exchanged_, broken_up_;
  mutable std::vector<Eigen::MatrixXd> own_;  // of candidates, as they are asked for
  struct WithNeed {
    ColumnGroup group;
    Eigen::MatrixXd own;
  };
  mutable std::map<int, WithNeed> with_need_;  // of candidates, as they are asked for
  struct Place {
    WeightedSet set;
    Sweep sweep;
  };
  mutable std::unique_ptr<Place> place_;  // the set asked last, from where those next to it are reached
};

constexpr double kLogOutOfQuestion = -1e6;  // finite: differences of such sets are numbers
constexpr double kWorthKeeping = 12.0;      // log units: e^-12 = 6e-6 of the best

}  // namespace sagitta
