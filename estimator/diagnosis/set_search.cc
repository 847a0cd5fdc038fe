#include "estimator/diagnosis/set_search.h"

#include <algorithm>
#include <cmath>

namespace sagitta {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();
// Sets that share the probability with the best are explored like it: e^-4 = 2 %, and no more of them than that share
// allows (each at 2 % or more: 50).
constexpr double kWorthExploring = 4.0;
constexpr int kMostExplored = 12;
constexpr int kScaleRounds = 3;

}  // namespace

double SetPrior::Log(const std::vector<double>& shares) const {
  if (shares.empty()) return std::log(nothing);
  const double m = static_cast<double>(shares.size());
  double log = std::log(1.0 - nothing) + (m - 1.0) * std::log(further) + std::lgamma(m + 1.0);
  for (const double share : shares) log += std::log(share);
  return log;
}

SetSearch::SetSearch(const ProjectedNormal& normal, const std::vector<Explanation>& explanations, const SetPrior& prior,
                     const ResidualLikelihood& likelihood)
    : normal_(normal), explanations_(explanations), prior_(prior), likelihood_(likelihood) {}

bool SetSearch::IsExcluded(const Key& members, int candidate) const {
  return std::any_of(members.begin(), members.end(),
                     [&](int m) { return explanations_[m].excludes == explanations_[candidate].excludes; });
}

std::vector<double> SetSearch::SharesOf(const Key& members) const {
  std::vector<double> shares;
  for (const int m : members) shares.push_back(explanations_[m].share);
  return shares;
}

// Coordinate ascent over the scales: each member's beside the others at theirs, by a sweep with those.
WeightedSet SetSearch::Evaluate(const std::vector<int>& members, const std::vector<double>& scales) const {
  WeightedSet set{members, scales, likelihood_.Log(normal_.residual), 0.0};
  if (set.scales.size() != members.size()) set.scales.assign(members.size(), 1.0);
  for (int round = 0; round < kScaleRounds && !members.empty(); ++round) {
    const std::vector<double> before = set.scales;
    double averages = 0.0;  // of each member's scales, over its best
    for (size_t k = 0; k < members.size(); ++k) {
      std::vector<const ColumnGroup*> others;
      std::vector<double> theirs;
      for (size_t i = 0; i < members.size(); ++i) {
        if (i == k) continue;
        others.push_back(&explanations_[members[i]].group);
        theirs.push_back(set.scales[i]);
      }
      const SmallSweep given(normal_, others, theirs, explanations_[members[k]].group);
      std::vector<double> logs;
      for (const double scale : kScales) {
        const GroupGain gain = GainOf(given.information, given.gradient, scale);
        logs.push_back(likelihood_.Log(given.residual - gain.quad) - 0.5 * (given.log_det + gain.log_det));
      }
      const auto best = std::max_element(logs.begin(), logs.end());
      set.scales[k] = kScales[best - logs.begin()];
      set.log_likelihood = *best;
      averages += LogSumExp(logs) - std::log(kNumScales) - *best;
    }
    if (set.scales == before || members.size() == 1 || round + 1 == kScaleRounds) {
      set.log_likelihood += averages;
      break;
    }
  }
  set.log_weight = set.log_likelihood + prior_.Log(SharesOf(members));
  return set;
}

std::vector<double> SetSearch::Additions(const WeightedSet& given, std::vector<double>* scales) const {
  std::vector<const ColumnGroup*> groups;
  for (const int m : given.members) groups.push_back(&explanations_[m].group);
  const Sweep sweep(normal_, groups, given.scales);
  std::vector<double> shares = SharesOf(given.members);
  shares.push_back(1.0);
  const double base = given.log_likelihood + prior_.Log(shares);
  std::vector<double> weights(explanations_.size(), kNever);
  if (scales != nullptr) scales->assign(explanations_.size(), 1.0);
  std::vector<double> logs(kNumScales);
  for (size_t k = 0; k < explanations_.size(); ++k) {
    const Explanation& candidate = explanations_[k];
    if (IsExcluded(given.members, static_cast<int>(k)) || !(candidate.share > 0.0)) continue;
    const Eigen::MatrixXd information = sweep.Information(candidate.group);
    const Eigen::VectorXd gradient = sweep.Gradient(candidate.group);
    for (int s = 0; s < kNumScales; ++s) {
      logs[s] = likelihood_.Gain(sweep.residual(), GainOf(information, gradient, kScales[s]));
    }
    weights[k] = base + LogSumExp(logs) - std::log(kNumScales) + std::log(candidate.share);
    if (scales != nullptr) (*scales)[k] = kScales[std::max_element(logs.begin(), logs.end()) - logs.begin()];
  }
  return weights;
}

void SetSearch::Record(WeightedSet set, bool replaces) {
  Key key = set.members;
  const auto entry = found_.find(key);
  if (entry == found_.end()) {
    found_.emplace(std::move(key), std::move(set));
  } else if (replaces || (settled_.count(key) == 0 && set.log_weight > entry->second.log_weight)) {
    entry->second = std::move(set);
  }
}

WeightedSet SetSearch::Settled(const WeightedSet& set) {
  if (settled_.emplace(set.members, true).second) Record(Evaluate(set.members, set.scales), true);
  return found_.at(set.members);
}

void SetSearch::Expand(const WeightedSet& given) {
  if (!expanded_.emplace(given.members, true).second) return;
  std::vector<double> scales;
  const std::vector<double> weights = Additions(given, &scales);
  const double most = std::max(BestWeight(), *std::max_element(weights.begin(), weights.end()));
  for (size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] < most - kWorthKeeping) continue;
    WeightedSet grown = given;
    const auto at =
        std::lower_bound(grown.members.begin(), grown.members.end(), static_cast<int>(k)) - grown.members.begin();
    grown.members.insert(grown.members.begin() + at, static_cast<int>(k));
    grown.scales.insert(grown.scales.begin() + at, scales[k]);
    grown.log_weight = weights[k];
    grown.log_likelihood = weights[k] - prior_.Log(SharesOf(grown.members));
    Record(std::move(grown));
  }
}

WeightedSet SetSearch::Without(const WeightedSet& set, size_t member) const {
  Key members = set.members;
  std::vector<double> scales = set.scales;
  members.erase(members.begin() + static_cast<long>(member));
  scales.erase(scales.begin() + static_cast<long>(member));
  const auto known = found_.find(members);
  return known != found_.end() ? known->second : Evaluate(members, scales);
}

const WeightedSet& SetSearch::Best() const {
  return std::max_element(found_.begin(), found_.end(),
                          [](const auto& a, const auto& b) { return a.second.log_weight < b.second.log_weight; })
      ->second;
}

bool SetSearch::Exchange(const WeightedSet& set) {
  for (size_t m = 0; m < set.members.size(); ++m) {
    const WeightedSet without = Without(set, m);
    Record(without);
    Expand(without);
  }
  return Best().members != set.members;
}

// To the nearest set that no addition, drop or swap improves: each step is up, by evaluations that are kept.
WeightedSet SetSearch::Climb(WeightedSet from) {
  from = Settled(from);
  while (true) {
    Expand(from);
    if (Best().members == from.members && !Exchange(from)) return from;
    do {
      from = Settled(Best());
    } while (Best().members != from.members);
  }
}

// What an addition says of a set keeps the others' scales: all that are kept are evaluated by themselves.
void SetSearch::SettleAll() {
  std::vector<WeightedSet> open;
  for (const auto& [key, set] : found_) {
    if (settled_.count(key) == 0 && set.log_weight > BestWeight() - kWorthKeeping) open.push_back(set);
  }
  for (const WeightedSet& set : open) Settled(set);
}

std::vector<WeightedSet> SetSearch::Run() {
  Record(Evaluate({}), true);
  if (!explanations_.empty()) {
    Climb(found_.at({}));
    for (int explored = 0; explored < kMostExplored; ++explored) {
      const double best = BestWeight();
      const WeightedSet* next = nullptr;
      for (const auto& [key, set] : found_) {
        const bool is_open = expanded_.count(key) == 0 && set.log_weight > best - kWorthExploring;
        if (is_open && (next == nullptr || set.log_weight > next->log_weight)) next = &set;
      }
      if (next == nullptr) break;
      const WeightedSet from = Settled(*next);
      Expand(from);
      Exchange(from);
    }
    Climb(Best());
    SettleAll();
  }
  const double best = BestWeight();
  std::vector<WeightedSet> sets;
  for (const auto& [key, set] : found_) {
    if (key.empty() || set.log_weight > best - kWorthKeeping) sets.push_back(set);
  }
  std::stable_sort(sets.begin(), sets.end(),
                   [](const WeightedSet& a, const WeightedSet& b) { return a.log_weight > b.log_weight; });
  return sets;
}

}  // namespace sagitta
