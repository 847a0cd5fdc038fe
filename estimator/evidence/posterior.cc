#include "estimator/evidence/posterior.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/evidence/nameless_cause.h"

namespace sagitta {
namespace {

constexpr double kThreefold = 3.0;  // a prior three times as large or small, half a decade (docs/DIAGNOSIS.md)

bool HasUnnamed(const Evidence& evidence, const WeightedModel& model) {
  return evidence.FollowsPose(model) || std::any_of(model.set.members.begin(), model.set.members.end(),
                                                    [&](int m) { return evidence.list().IsUnnamed(m); });
}

// Masses multiplied, and those that share one probability normalised anew.
PriorMasses Multiplied(const PriorMasses& masses, const PriorMasses& by) {
  PriorMasses product{masses.nothing * by.nothing, masses.catalogue * by.catalogue, masses.unnamed * by.unnamed,
                      masses.further * by.further};
  const double sum = product.nothing + product.catalogue + product.unnamed;
  product.nothing /= sum, product.catalogue /= sum, product.unnamed /= sum;
  return product;
}

struct Leading {
  bool is_something = false;
  std::vector<int> names;

  bool operator==(const Leading& other) const { return is_something == other.is_something && names == other.names; }
};

Leading LeadingOf(const Posterior& posterior, double gate) {
  if (posterior.Something() <= gate || posterior.sets.empty()) return {};
  return {true, posterior.sets[posterior.Leading(gate)].names};
}

// Names of a list in their order: the first explanation of each, and the place of every explanation's name.
struct NamesInOrder {
  explicit NamesInOrder(const ExplanationList& list) {
    std::map<std::string, int> of_name;  // first explanation, then place
    for (size_t k = 0; k < list.name.size(); ++k) of_name.emplace(list.name[k], static_cast<int>(k));
    for (auto& [name, at] : of_name) {
      first.push_back(at);
      at = static_cast<int>(first.size()) - 1;
    }
    for (const std::string& name : list.name) place.push_back(of_name.at(name));
  }

  std::vector<int> first, place;
};

// The entries, most probable first.
template <typename Key, typename Entry>
std::vector<Entry> ByProbability(const std::map<Key, Entry>& entries) {
  std::vector<Entry> sorted;
  for (const auto& [key, entry] : entries) {
    sorted.push_back(entry);
    sorted.back().probability = std::min(1.0, entry.probability);  // rounding of the sums
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Entry& a, const Entry& b) { return a.probability > b.probability; });
  return sorted;
}

// With p(M) of all models M = (view, set):  P(name) = sum of p(M) over M that hold it;  P(nothing) = sum over the empty
// set as stated of p(M) (1 - P(sigma is wrong | M)), the rest of the empty sets is noise.
class SumsByName {
 public:
  SumsByName(const Evidence& evidence, const std::vector<WeightedModel>& models)
      : evidence_(evidence), all_(evidence.list()) {
    for (size_t i = 0; i < models.size(); ++i) {
      if (models[i].set.members.empty() && !HasUnnamed(evidence, models[i])) {
        AddEmpty(models[i]);
      } else {
        Add(models[i], static_cast<int>(i));
      }
    }
  }

  Posterior ToPosterior() && {
    posterior_.unnamed = std::min(1.0, posterior_.unnamed);
    posterior_.sets = ByProbability(sets_);
    posterior_.explanations = ByProbability(named_);
    posterior_.functions = ByProbability(functions_);
    return std::move(posterior_);
  }

 private:
  void AddEmpty(const WeightedModel& model) {
    const bool is_stated = evidence_.ViewOf(model).IsStated();
    const double wrong = is_stated ? evidence_.SigmaIsWrong(model) : 1.0;
    posterior_.noise += wrong * model.probability;
    posterior_.nothing += (1.0 - wrong) * model.probability;
  }

  // The models come in the order of their probability: the first of a kind is its most probable.
  void Add(const WeightedModel& model, int place) {
    const bool has_unnamed = HasUnnamed(evidence_, model);
    if (has_unnamed) posterior_.unnamed += model.probability;
    std::vector<int> names, effects, pieces;
    for (const int m : model.set.members) {
      const int name = all_.place[m];
      if (model.HasPiece(m)) {
        pieces.push_back(name);
        continue;
      }
      names.push_back(name);
      if (!evidence_.list().IsUnnamed(m)) effects.push_back(name);
      AddMember(m, name, model.probability);
    }
    names = EachOnce(names);
    const NameSet fresh{names, EachOnce(effects), EachOnce(pieces), has_unnamed, 0.0, place, {}};
    NameSet& set = sets_.emplace(std::make_pair(names, evidence_.FollowsPose(model)), fresh).first->second;
    set.probability += model.probability;
    set.models.push_back(place);
  }

  void AddMember(int member, int name, double probability) {
    auto& entries = evidence_.list().IsUnnamed(member) ? functions_ : named_;
    const NamedProbability fresh{evidence_.list().name[member], member, 0.0};
    NamedProbability& entry = entries.emplace(name, fresh).first->second;
    entry.probability += probability;
    double& most = most_[name];
    if (probability <= most) return;
    most = probability;
    entry.explanation = member;
  }

  const Evidence& evidence_;
  NamesInOrder all_;
  Posterior posterior_;
  std::map<std::pair<std::vector<int>, bool>, NameSet> sets_;  // by names, and whether a deviation follows the pose
  std::map<int, NamedProbability> named_, functions_;          // by the place of the name
  std::map<int, double> most_;                                 // of one model with that name
};

// The first explanation of each name that only the former have.
std::vector<int> Without(const NamesInOrder& all, const std::vector<int>& names, const std::vector<int>& others) {
  std::vector<int> own;
  for (const int name : names) {
    if (!std::binary_search(others.begin(), others.end(), name)) own.push_back(all.first[name]);
  }
  return own;
}

}  // namespace

double Posterior::Of(const std::string& name) const {
  for (const std::vector<NamedProbability>* list : {&explanations, &functions}) {
    for (const NamedProbability& entry : *list) {
      if (entry.name == name) return entry.probability;
    }
  }
  return 0.0;
}

double Posterior::MoreThan(size_t names) const {
  double sum = 0.0;
  for (const NameSet& set : sets) {
    if (set.names.size() > names) sum += set.probability;
  }
  return sum;
}

// From nothing on, S: an effect e is added where P(nothing more | S) < 1 - gate and e is more probable than that what
// more is there has no name. Of the first the former is asked before (is something missing?): sets without an effect
// are all without a name.
size_t Posterior::Leading(double gate) const {
  std::vector<int> chosen;
  while (true) {
    double alone = 0.0, without_name = 0.0, all = 0.0;
    size_t first = sets.size();  // of those that hold no other effect: the most probable
    std::map<int, double> with;
    for (size_t s = 0; s < sets.size(); ++s) {
      const NameSet& set = sets[s];
      if (!std::includes(set.effects.begin(), set.effects.end(), chosen.begin(), chosen.end())) continue;
      all += set.probability;
      if (set.effects == chosen) {
        alone += set.probability;
        if (set.has_unnamed) without_name += set.probability;
        first = std::min(first, s);
      }
      for (const int effect : set.effects) {
        if (!std::binary_search(chosen.begin(), chosen.end(), effect)) with[effect] += set.probability;
      }
    }
    const auto best =
        std::max_element(with.begin(), with.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    const bool any_more = alone - without_name < (1.0 - gate) * all;
    const bool is_enough = best == with.end() || !any_more || best->second < without_name;
    if (is_enough && first < sets.size()) return first;
    chosen = EachOnce(chosen, {best->first});
  }
}

Posterior PosteriorOf(const Evidence& evidence, const std::vector<WeightedModel>& models) {
  return SumsByName(evidence, models).ToPosterior();
}

double ProbabilityOf(const std::string& effect, const Evidence& evidence, const std::vector<WeightedModel>& models) {
  const ExplanationList& list = evidence.list();
  double sum = 0.0;
  for (const WeightedModel& model : models) {
    const bool holds = std::any_of(model.set.members.begin(), model.set.members.end(), [&](int m) {
      return !list.IsUnnamed(m) && !model.HasPiece(m) && list.SpecOf(m).effect == effect;
    });
    if (holds) sum += model.probability;
  }
  return std::min(1.0, sum);  // rounding of the sums
}

// Shares are those of a kind in all that may be missing: with the masses they change by
// (mass' / S') / (mass / S), S = catalogue + unnamed. Those of pieces are shares of their nameless cause.
double LogPriorRatio(const Evidence& evidence, const WeightedModel& model, const PriorMasses& then) {
  const PriorMasses& now = evidence.masses();
  const double all = (then.catalogue + then.unnamed) / (now.catalogue + now.unnamed);
  const double named = then.catalogue / now.catalogue / all, unnamed = then.unnamed / now.unnamed / all;
  std::vector<double> shares_now(model.set.members.size(), 1.0), shares_then = shares_now;
  for (size_t k = 0; k < model.set.members.size(); ++k) {
    const int m = model.set.members[k];
    if (!model.HasPiece(m)) shares_then[k] = evidence.list().IsUnnamed(m) ? unnamed : named;
  }
  if (evidence.FollowsPose(model)) {
    shares_now.push_back(1.0);
    shares_then.push_back(unnamed);
  }
  const double log =
      SetPrior{then.nothing, then.further}.Log(shares_then) - SetPrior{now.nothing, now.further}.Log(shares_now);
  if (model.pieces.empty()) return log;
  const auto log_of_piece = [&](double further) {
    return std::log(further / NamelessCauses::OneMore(further, model.set.members.size()));
  };
  return log + static_cast<double>(model.pieces.size()) * (log_of_piece(then.further) - log_of_piece(now.further));
}

std::vector<Flip> WhatFlips(const Evidence& evidence, const Posterior& posterior, double gate) {
  const Leading now = LeadingOf(posterior, gate);
  const NamesInOrder all(evidence.list());
  std::vector<Flip> flips;
  for (const double factor : {kThreefold, 1.0 / kThreefold}) {
    const std::pair<const char*, PriorMasses> changes[] = {{"nothing", {factor, 1.0, 1.0, 1.0}},
                                                           {"catalogue", {1.0, factor, 1.0, 1.0}},
                                                           {"unnamed", {1.0, 1.0, factor, 1.0}},
                                                           {"further", {1.0, 1.0, 1.0, factor}}};
    for (const auto& [mass, by] : changes) {
      const PriorMasses masses = Multiplied(evidence.masses(), by);
      std::vector<WeightedModel> changed = evidence.models();
      for (WeightedModel& model : changed) model.log_weight += LogPriorRatio(evidence, model, masses);
      Normalise(&changed);
      const Leading then = LeadingOf(PosteriorOf(evidence, changed), gate);
      if (then == now) continue;
      flips.push_back({mass, factor > 1.0, then.is_something, Without(all, then.names, now.names),
                       Without(all, now.names, then.names)});
    }
  }
  return flips;
}

}  // namespace sagitta
