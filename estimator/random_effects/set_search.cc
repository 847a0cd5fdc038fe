#include "estimator/random_effects/set_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "models/constants.h"

namespace sagitta {
namespace {

// Sets that share the probability with the best are explored like it: e^-4 = 2 %, which 50 of them can have at most.
constexpr double kWorthExploring = 4.0;
constexpr int kMostExplored = 12;  // such sets: what lies beyond them is found by the climb from each
constexpr int kScaleRounds = 3;    // of each member's best scale given the others
// Explanations at once: the prior has 0.3^20 = 3e-11 for more. Data that ask for more of them, which those of a large
// enough campaign always do, show what the catalogue does not hold, and a sum of so many is no explanation.
constexpr size_t kMostMembers = 20;
constexpr size_t kAveragedTogether = 3;  // members: 6^3 combinations; of more, each with the best of the others
constexpr double kUnsettled = 1e-3;      // of the probability: a tenth of what is reported
constexpr size_t kMostSwaps = 1000;   // of one set: where a thousand sets share the probability they differ in details
constexpr int kSeveralColumns = 3;    // of a member: with fewer it stands for no two others
constexpr size_t kMostBrokenUp = 6;   // members: a set of more is of what the catalogue does not hold (kMostMembers)
constexpr int kMostInPlace = 5;       // in the place of a general one: the prior has 0.3^4 = 1 % for more
constexpr size_t kMostSettled = 100;  // where a hundred sets share it, each has about a hundredth

}  // namespace

SetSearch::SetSearch(const ProjectedNormal& normal, const std::vector<Explanation>& explanations, const SetPrior& prior,
                     const ResidualLikelihood& likelihood)
    : normal_(normal), explanations_(explanations), prior_(prior), likelihood_(likelihood) {}

bool SetSearch::IsExcluded(const Key& members, int candidate) const {
  const int own = explanations_[candidate].excludes;
  return std::any_of(members.begin(), members.end(), [&](int m) { return explanations_[m].excludes == own; });
}

int SetSearch::LackedBy(const Key& members, int candidate) const {
  const int needed = explanations_[candidate].needs;
  return std::count(members.begin(), members.end(), needed) > 0 ? kNoExplanation : needed;
}

std::vector<double> SetSearch::SharesOf(const Key& members) const {
  std::vector<double> shares;
  for (const int m : members) shares.push_back(explanations_[m].share);
  return shares;
}

double SetSearch::LogOfLack(const Key& members, int more) const {
  if (!prior_.holds_weight || (more != kNoExplanation && explanations_[more].is_weight)) return 0.0;
  const bool holds = std::any_of(members.begin(), members.end(), [&](int m) { return explanations_[m].is_weight; });
  return holds ? 0.0 : kLogOutOfQuestion;
}

double SetSearch::LogPriorOf(const Key& members) const { return prior_.Log(SharesOf(members)) + LogOfLack(members); }

double SetSearch::LogPriorWithMore(const Key& members, int count) const {
  std::vector<double> shares = SharesOf(members);
  shares.resize(shares.size() + static_cast<size_t>(count), 1.0);
  return prior_.Log(shares);
}

SetSearch::Coming SetSearch::ComingTo(const Key& members, int candidate) const {
  const Explanation& own = explanations_[candidate];
  const int lacked = LackedBy(members, candidate);
  if (lacked == kNoExplanation) return {&own.group, &OwnOf(static_cast<size_t>(candidate)), std::log(own.share), 1};
  WithNeed& both = with_need_[candidate];
  if (both.own.size() == 0) {
    both.group = Joined(explanations_[lacked].group, own.group);
    both.own = OwnInformation(normal_, both.group);
  }
  return {&both.group, &both.own, std::log(own.share * explanations_[lacked].share), 2};
}

WeightedSet SetSearch::With(WeightedSet set, int candidate, double scale) const {
  const int lacked = LackedBy(set.members, candidate);
  if (lacked != kNoExplanation) set = Grown(std::move(set), lacked, scale);
  return Grown(std::move(set), candidate, scale);
}

WeightedSet SetSearch::Less(const WeightedSet& set, size_t place) const {
  WeightedSet less = set;
  for (const size_t gone : GoingWith(explanations_, set.members, place)) less = Without(std::move(less), gone);
  return less;
}

Members SetSearch::Less(Members members, const WeightedSet& set, size_t place) const {
  for (const size_t gone : GoingWith(explanations_, set.members, place)) members.Remove(gone);
  return members;
}

// Coordinate ascent over the scales, each member's given the others at theirs; then the average over each.
WeightedSet SetSearch::Evaluate(const std::vector<int>& given_members, const std::vector<double>& scales) const {
  const std::vector<double> ones(given_members.size(), 1.0);
  return EvaluateFrom(given_members, Members(normal_, GroupsOf(explanations_, given_members),
                                             scales.size() == given_members.size() ? scales : ones));
}

const Sweep& SetSearch::SweepOf(const WeightedSet& set) const {
  const Difference difference = place_ ? DifferenceOf(place_->set, set) : Difference();
  // A move costs a pass over the matrix, and so does a member of the first sweep.
  if (!place_ || difference.gone.size() + difference.come.size() > set.members.size() + 1) {
    place_ = std::make_unique<Place>(Place{set, Sweep(normal_, GroupsOf(explanations_, set.members), set.scales)});
    return place_->sweep;
  }
  for (const size_t k : difference.gone) place_->sweep.Remove(k);
  for (const size_t k : difference.come) {
    place_->sweep.Insert(k, explanations_[set.members[k]].group, set.scales[k]);
  }
  place_->set = set;
  return place_->sweep;
}

Members SetSearch::MembersOf(const WeightedSet& set) const {
  const Difference difference = place_ ? DifferenceOf(place_->set, set) : Difference();
  // Moves of all members cost what the inverse does anew.
  if (!place_ || difference.gone.size() + difference.come.size() > set.members.size()) {
    return Members(normal_, GroupsOf(explanations_, set.members), set.scales);
  }
  Members members = place_->sweep.members();
  for (const size_t k : difference.gone) members.Remove(k);
  for (const size_t k : difference.come) members.Insert(k, explanations_[set.members[k]].group, set.scales[k]);
  return members;
}

// Of m <= kAveragedTogether members  log mean over all s of L(s); of more, at the best scales s^,
//   log L(s^) + sum_k (log mean_s L(s_k = s) - log L(s^)),
// and what the signs say at the best scales.
// The weight is that times the prior: log w = log L + log P(set).
WeightedSet SetSearch::EvaluateFrom(const std::vector<int>& given_members, Members members) const {
  WeightedSet set{given_members, members.scales(), likelihood_.Log(normal_.residual), 0.0};
  // A pass that moves no scale has seen each member given the others at their best.
  bool moved = !set.members.empty();
  for (int round = 0; moved && round <= kScaleRounds; ++round) {
    moved = false;
    double averages = 0.0;  // of each member's scales, over its best
    for (size_t k = 0; k < set.members.size(); ++k) {
      const std::vector<double> logs = LogsOfScales(likelihood_, members.Of(k));
      const auto most = std::max_element(logs.begin(), logs.end());
      const double best = kScales[most - logs.begin()];
      set.log_likelihood = *most;
      averages += LogMean(logs) - *most;
      if (best == set.scales[k] || round == kScaleRounds) continue;
      set.scales[k] = best;
      members.Rescale(k, best);
      moved = true;
    }
    set.log_likelihood += averages;
  }
  if (!set.members.empty() && set.members.size() <= kAveragedTogether) set.log_likelihood = AverageOverScales(members);
  set.log_likelihood += members.LogOfSigns(likelihood_);
  set.log_weight = set.log_likelihood + LogPriorOf(set.members);
  return set;
}

// Over all combinations: conditioned on the scales of all but the last, each of the last. Each combination begins with
// the members as they are given: what rounding leaves grows with every scale that is raised.
double SetSearch::AverageOverScales(const Members& members) const {
  const size_t last = members.size() - 1;
  std::vector<double> logs;
  const std::function<void(const Members&, size_t)> add = [&](const Members& here, size_t next) {
    if (next == last) {
      for (const double log : LogsOfScales(likelihood_, here.Of(last))) logs.push_back(log);
      return;
    }
    for (int s = 0; s < here.NumScales(next); ++s) {
      Members rescaled = here;
      if (kScales[s] != here.scales()[next]) rescaled.Rescale(next, kScales[s]);
      add(rescaled, next + 1);
    }
  };
  add(members, 0);
  return LogMean(logs);
}

const Eigen::MatrixXd& SetSearch::OwnOf(size_t candidate) const {
  if (own_.empty()) own_.resize(explanations_.size());
  Eigen::MatrixXd& own = own_[candidate];
  if (own.size() == 0) own = OwnInformation(normal_, explanations_[candidate].group);
  return own;
}

std::vector<double> SetSearch::Additions(const WeightedSet& given) const {
  std::vector<double> scales;
  return AdditionsTo(given, {}, &scales);
}

// log w(set + k) = log L(set) + log B_k + log P(set + k), B_k by what the sweep leaves of G_kk and g_k; k with what it
// needs where the set lacks that. log B_k is no more than with its widest scale and a certain sign.
std::vector<double> SetSearch::AdditionsTo(const WeightedSet& set, const Asked& asked,
                                           std::vector<double>* scales) const {
  const Sweep& sweep = SweepOf(set);
  const double bases[] = {LogPriorWithMore(set.members, 1), LogPriorWithMore(set.members, 2)};
  const double nothing = likelihood_.Log(sweep.residual());
  std::vector<double> weights(explanations_.size(), -kInfinity);
  scales->assign(explanations_.size(), 1.0);
  double most = asked.most;
  for (size_t k = 0; k < explanations_.size(); ++k) {
    const Explanation& candidate = explanations_[k];
    if (IsExcluded(set.members, static_cast<int>(k)) || !(candidate.share > 0.0)) continue;
    if (candidate.group.size() >= asked.columns || (candidate.is_general && !asked.general)) continue;
    const Coming coming = ComingTo(set.members, static_cast<int>(k));
    const GivenOthers given{*coming.own - sweep.Taken(*coming.group),
                            sweep.Gradient(*coming.group),
                            sweep.residual(),
                            0.0,
                            coming.group->num_scales,
                            coming.group->not_negative};
    const double base =
        set.log_likelihood + bases[coming.count - 1] + coming.log_share + LogOfLack(set.members, static_cast<int>(k));
    if (asked.within < kInfinity) {
      const double most_quad = MostQuads(given.information, given.gradient)[0];
      const double most_gain = likelihood_.Log(given.residual - most_quad) - nothing + MostOfSigns(given.not_negative);
      if (base + most_gain < most - asked.within) continue;
    }
    weights[k] = base + AverageGain(likelihood_, given, &(*scales)[k]);
    most = std::max(most, weights[k]);
  }
  return weights;
}

void SetSearch::Record(WeightedSet set, bool replaces) {
  const WeightedSet* known = found_.Find(set.members);
  const bool is_better =
      known == nullptr || replaces || (settled_.count(set.members) == 0 && set.log_weight > known->log_weight);
  if (is_better) found_.Put(std::move(set));
}

WeightedSet SetSearch::Settled(const WeightedSet& set, const Members* conditioned) {
  if (settled_.insert(set.members).second) {
    Record(EvaluateFrom(set.members, conditioned == nullptr ? MembersOf(set) : *conditioned), true);
  }
  return *found_.Find(set.members);
}

void SetSearch::Expand(const WeightedSet& given) {
  if (!expanded_.insert(given.members).second || given.members.size() >= kMostMembers) return;
  std::vector<double> scales;
  const std::vector<double> weights =
      AdditionsTo(given, {std::numeric_limits<int>::max(), true, BestWeight(), kWorthKeeping}, &scales);
  const double most = std::max(BestWeight(), *std::max_element(weights.begin(), weights.end()));
  for (size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] >= most - kWorthKeeping) RecordGrown(given, static_cast<int>(k), scales[k], weights[k]);
  }
}

void SetSearch::RecordGrown(WeightedSet set, int candidate, double scale, double log_weight) {
  set = With(std::move(set), candidate, scale);
  set.log_weight = log_weight;
  set.log_likelihood = log_weight - LogPriorOf(set.members);
  Record(std::move(set));
}

std::vector<WeightedSet> SetSearch::WithoutEach(const WeightedSet& set, const Members& all) const {
  std::vector<WeightedSet> without;
  double averages = 0.0;  // of each member's scales, over its best, and of its signs
  std::vector<double> own_averages;
  for (size_t m = 0; m < set.members.size(); ++m) {
    WeightedSet others = Less(set, m);
    const GivenOthers given = all.Of(m);
    others.log_likelihood = likelihood_.Log(given.residual) - 0.5 * given.log_det;
    without.push_back(std::move(others));
    own_averages.push_back(LossOfScale(likelihood_, given) + LogOfSigns(likelihood_, given, set.scales[m]));
    averages += own_averages.back();
  }
  for (size_t m = 0; m < without.size(); ++m) {
    WeightedSet& others = without[m];
    const WeightedSet* known = found_.Find(others.members);
    if (known != nullptr) {
      others = *known;
    } else if (others.members.size() <= kAveragedTogether || others.members.size() + 1 < set.members.size()) {
      others = EvaluateFrom(others.members, Less(all, set, m));
    } else {
      others.log_likelihood += averages - own_averages[m];
      others.log_weight = others.log_likelihood + LogPriorOf(others.members);
    }
  }
  return without;
}

std::vector<double> SetSearch::LossesOf(const WeightedSet& set) const {
  const Members all(normal_, GroupsOf(explanations_, set.members), set.scales);
  const double whole = EvaluateFrom(set.members, all).log_weight;
  std::vector<double> losses;
  for (size_t m = 0; m < set.members.size(); ++m) {
    losses.push_back(whole - EvaluateFrom(Less(set, m).members, Less(all, set, m)).log_weight);
  }
  return losses;
}

// Every member's place for every candidate: each is removed from what is left of the candidates given all, at the
// others' scales. Without a member G is no less than given all: what a candidate can add at most is first asked with
// that of all, which a factor for all places says. What another member needs has no other in its place.
std::vector<SetSearch::Swap> SetSearch::SwapsOf(const WeightedSet& set, const Sweep& sweep,
                                                const std::vector<WeightedSet>& without) {
  std::vector<Sweep::WithoutOne> sweeps;
  std::vector<std::array<double, 2>> bases;  // of one and of two that come, without the likelihood of what is left
  for (size_t m = 0; m < set.members.size(); ++m) {
    sweeps.push_back(sweep.Without(m));
    const bool goes_alone = without[m].members.size() + 1 == set.members.size();
    const double log_likelihood = goes_alone ? without[m].log_likelihood : -kInfinity;
    const auto base = [&](int count) {
      return log_likelihood + LogPriorWithMore(without[m].members, count) - likelihood_.Log(sweeps[m].residual);
    };
    bases.push_back({base(1), base(2)});
  }
  const Eigen::MatrixXd of_all = sweep.Gradients(sweeps);
  std::vector<Swap> swaps;
  double most = BestWeight();
  for (size_t k = 0; k < explanations_.size(); ++k) {
    if (!(explanations_[k].share > 0.0)) continue;
    const Coming coming = ComingTo(set.members, static_cast<int>(k));
    const Eigen::MatrixXd given_all = *coming.own - sweep.Taken(*coming.group);
    const Eigen::MatrixXd gradients = ColumnsOf(*coming.group, of_all).transpose();
    const Eigen::VectorXd most_quads = MostQuads(given_all, gradients);
    Eigen::MatrixXd solved;  // where it is asked for
    for (size_t m = 0; m < set.members.size(); ++m) {
      const bool is_it = set.members[m] == static_cast<int>(k) || set.members[m] == explanations_[k].needs;
      if (is_it || IsExcluded(without[m].members, static_cast<int>(k))) continue;
      const double lack = LogOfLack(without[m].members, static_cast<int>(k));
      const double base = bases[m][coming.count - 1] + coming.log_share + lack, residual = sweeps[m].residual;
      const double most_gain =
          likelihood_.Log(residual - most_quads[static_cast<long>(m)]) + MostOfSigns(coming.group->not_negative);
      const auto place = static_cast<long>(m);
      if (base + most_gain < most - kWorthKeeping) continue;
      if (solved.size() == 0) solved = sweep.Solved(*coming.group);
      double scale = 1.0;
      const GivenOthers given{given_all + sweeps[m].Information(solved),
                              gradients.col(place),
                              residual,
                              0.0,
                              coming.group->num_scales,
                              coming.group->not_negative};
      const double weight = base + likelihood_.Log(residual) + AverageGain(likelihood_, given, &scale);
      if (weight < most - kWorthKeeping) continue;
      most = std::max(most, weight);
      swaps.push_back({m, static_cast<int>(k), scale, weight});
    }
  }
  std::stable_sort(swaps.begin(), swaps.end(),
                   [](const Swap& a, const Swap& b) { return a.log_weight > b.log_weight; });
  if (swaps.size() > kMostSwaps) swaps.resize(kMostSwaps);
  return swaps;
}

bool SetSearch::Exchange(const WeightedSet& set) {
  if (set.members.empty() || !exchanged_.insert(set.members).second) return false;
  const Sweep& sweep = SweepOf(set);
  const std::vector<WeightedSet> without = WithoutEach(set, sweep.members());
  for (const WeightedSet& others : without) Record(others);
  std::vector<Swap> swaps = SwapsOf(set, sweep, without);
  const double most = swaps.empty() ? BestWeight() : std::max(BestWeight(), swaps.front().log_weight);
  for (const Swap& swap : swaps) {
    if (swap.log_weight < most - kWorthKeeping) break;
    RecordGrown(without[swap.member], swap.candidate, swap.scale, swap.log_weight);
  }
  for (size_t m = 0; m < without.size(); ++m) swaps.push_back({m, -1, 1.0, without[m].log_weight});
  std::stable_sort(swaps.begin(), swaps.end(),
                   [](const Swap& a, const Swap& b) { return a.log_weight > b.log_weight; });
  SwapTogether(set, sweep.members(), swaps);
  return Best().members != set.members;
}

WeightedSet SetSearch::WithBestCause(const WeightedSet& set, int columns) {
  std::vector<double> scales;
  const std::vector<double> weights = AdditionsTo(set, {columns, false, -kInfinity, 0.0}, &scales);
  const auto best = std::max_element(weights.begin(), weights.end()) - weights.begin();
  if (weights[best] == -kInfinity) return set;
  return Settled(With(set, static_cast<int>(best), scales[best]));
}

// Two periodic errors of one joint, for example: a smooth function of its angle explains both, each alone half, and
// next to the function neither adds anything. Without it they are found one after the other, and each anew given the
// others, because what is best alone may follow both.
bool SetSearch::BreakUp(const WeightedSet& set) {
  if (set.members.size() > kMostBrokenUp || !broken_up_.insert(set.members).second) return false;
  for (size_t m = 0; m < set.members.size(); ++m) {
    const int columns = explanations_[set.members[m]].group.size();
    if (columns < kSeveralColumns) continue;
    const WeightedSet others = Settled(Less(set, m));
    WeightedSet causes = others;
    for (int left = kMostInPlace - 1; left >= 0; --left) {
      const double before = SweepOf(causes).residual();
      WeightedSet more = WithBestCause(causes, columns);
      const double after = SweepOf(more).residual();
      // The best come first: those that are left explain no more than this one each.
      const double at_best = std::max(0.0, after - left * (before - after));
      const double most = more.log_weight + likelihood_.Log(at_best) - likelihood_.Log(after);
      if (!(more.log_weight > causes.log_weight) || most < set.log_weight) break;
      causes = EachAnew(std::move(more), others, columns);
    }
  }
  return Best().members != set.members;
}

WeightedSet SetSearch::EachAnew(WeightedSet causes, const WeightedSet& others, int columns) {
  for (const int old : Key(causes.members)) {
    const size_t place = PlaceIn(causes.members, old);
    if (place == causes.members.size() || causes.members[place] != old) continue;  // gone with what it needs
    if (causes.members.size() < 2 || std::count(others.members.begin(), others.members.end(), old) > 0) continue;
    const WeightedSet anew = WithBestCause(Settled(Less(causes, place)), columns);
    if (anew.log_weight > causes.log_weight) causes = anew;
  }
  return causes;
}

// The swaps and drops that make the set better by themselves, best first, one for each place: each is kept if the set
// is better still with it.
void SetSearch::SwapTogether(const WeightedSet& set, const Members& all, const std::vector<Swap>& swaps) {
  WeightedSet now = set;
  Members members = all;
  std::set<int> done;
  for (const Swap& swap : swaps) {
    if (swap.log_weight <= set.log_weight) return;
    const int out = set.members[swap.member];
    if (!done.insert(out).second) continue;
    const size_t at = PlaceIn(now.members, out);
    if (at == now.members.size() || now.members[at] != out) continue;  // gone with what it needs
    WeightedSet swapped = Less(now, at);
    Members theirs = Less(members, now, at);
    if (swap.candidate >= 0) {
      if (IsExcluded(swapped.members, swap.candidate)) continue;
      WeightedSet grown = With(swapped, swap.candidate, swap.scale);
      for (const size_t k : DifferenceOf(swapped, grown).come) {
        theirs.Insert(k, explanations_[grown.members[k]].group, grown.scales[k]);
      }
      swapped = std::move(grown);
    }
    const WeightedSet settled = Settled(swapped, &theirs);
    if (!(settled.log_weight > now.log_weight)) continue;
    now = settled;
    members = MembersOf(now);
  }
}

// To the nearest set that no addition, drop or swap improves: each move is up, by evaluations that are kept.
void SetSearch::Climb(WeightedSet from) {
  from = Settled(from);
  while (true) {
    Expand(from);
    if (Best().members == from.members && !Exchange(from) && !BreakUp(from)) return;
    do {
      from = Settled(Best());
    } while (Best().members != from.members);
  }
}

// What an addition says of a set keeps the others' scales: the most probable sets are evaluated by themselves, all but
// kUnsettled of the probability, and no more than kMostSettled.
void SetSearch::SettleAll() {
  const double best = BestWeight();
  const auto weight = [best](const WeightedSet& set) { return std::exp(set.log_weight - best); };
  std::vector<const WeightedSet*> unsettled;  // best first: their weights stay until it is their turn
  double all = 0.0, open = 0.0;
  found_.BestFirst(kWorthKeeping, [&](const WeightedSet& set) {
    all += weight(set);
    if (settled_.count(set.members) > 0) return true;
    open += weight(set);
    unsettled.push_back(&set);
    return true;
  });
  for (size_t k = 0; k < unsettled.size() && k < kMostSettled && open > kUnsettled * all; ++k) {
    open -= weight(*unsettled[k]);
    all -= weight(*unsettled[k]);
    all += weight(Settled(WeightedSet(*unsettled[k])));
  }
}

void SetSearch::ClimbFrom(const WeightedSet& start) {
  Record(Evaluate({}), true);
  if (explanations_.empty()) return;
  if (!start.members.empty()) Record(Evaluate(start.members, start.scales));
  Expand(*found_.Find({}));
  Climb(*found_.Find(start.members));
}

std::vector<WeightedSet> SetSearch::Explore() {
  for (int explored = 0; explored < kMostExplored && !explanations_.empty(); ++explored) {
    const WeightedSet* next = nullptr;
    found_.BestFirst(kWorthExploring, [&](const WeightedSet& set) {
      if (expanded_.count(set.members) == 0) next = &set;
      return next == nullptr;
    });
    if (next == nullptr) break;
    const WeightedSet from = Settled(*next);
    Expand(from);
    Exchange(from);
  }
  if (!explanations_.empty()) Climb(Best());
  SettleAll();
  place_.reset();
  std::vector<WeightedSet> sets = found_.Within(kWorthKeeping);
  const bool holds_nothing =
      std::any_of(sets.begin(), sets.end(), [](const WeightedSet& set) { return set.members.empty(); });
  if (!holds_nothing) sets.push_back(Empty());
  return sets;
}

}  // namespace sagitta
