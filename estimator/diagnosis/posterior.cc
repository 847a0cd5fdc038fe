#include "estimator/diagnosis/posterior.h"

#include <algorithm>
#include <cmath>

namespace sagitta {
namespace {

constexpr double kThreefold = 3.0;

bool IsPose(const Evidence& evidence, const WeightedModel& model) {
  return evidence.views()[model.view].view.kind == NoiseView::Kind::kPose;
}

bool HasUnnamed(const Evidence& evidence, const WeightedModel& model) {
  return IsPose(evidence, model) || std::any_of(model.set.members.begin(), model.set.members.end(),
                                                [&](int m) { return evidence.list().IsUnnamed(m); });
}

// By SetPrior a set of m members has the prior (1 - nothing) further^(m-1) m! prod share, a share being proportional to
// the mass of its kind: multiplied masses multiply that by f_further^(m-1) prod f_kind, before all is normalised anew.
// Log factor on a model's weight when one mass is multiplied.
struct Changed {
  const char* mass;
  double nothing, catalogue, unnamed, further;  // factors

  double LogFactor(const Evidence& evidence, const WeightedModel& model) const {
    const size_t count = model.set.members.size();
    if (count == 0) return std::log(HasUnnamed(evidence, model) ? unnamed : nothing);
    double log = static_cast<double>(count - 1) * std::log(further);
    for (const int m : model.set.members) {  // of which a piece has the mass of its nameless cause alone
      if (!model.HasPiece(m)) log += std::log(evidence.list().IsUnnamed(m) ? unnamed : catalogue);
    }
    return log;
  }
};

struct Leading {
  bool is_something = false;
  std::set<std::string> names;

  bool operator==(const Leading& other) const { return is_something == other.is_something && names == other.names; }
};

Leading LeadingOf(const Posterior& posterior, double gate) {
  if (posterior.Something() <= gate || posterior.sets.empty()) return {};
  return {true, posterior.sets[0].names};
}

// The first explanation of each name that only the former have.
std::vector<int> Without(const ExplanationList& list, const std::set<std::string>& names,
                         const std::set<std::string>& others) {
  std::vector<int> own;
  for (const std::string& name : names) {
    if (others.count(name) > 0) continue;
    own.push_back(static_cast<int>(std::find(list.name.begin(), list.name.end(), name) - list.name.begin()));
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

// With p(M) of all models M = (view, set):  P(name) = sum of p(M) over M that hold it;  P(nothing) = sum over the empty
// set as stated of p(M) (1 - P(sigma is wrong | M)), the rest of the empty sets is noise.
Posterior PosteriorOf(const Evidence& evidence, const std::vector<WeightedModel>& models) {
  Posterior posterior;
  std::map<std::pair<std::set<std::string>, bool>, NameSet> sets;
  std::map<std::string, NamedProbability> named, functions;
  std::map<std::string, double> most;
  const ExplanationList& list = evidence.list();
  for (size_t i = 0; i < models.size(); ++i) {
    const WeightedModel& model = models[i];
    const bool has_unnamed = HasUnnamed(evidence, model);
    if (has_unnamed) posterior.unnamed += model.probability;
    if (model.set.members.empty() && !has_unnamed) {
      const bool is_stated = evidence.views()[model.view].view.kind == NoiseView::Kind::kStated;
      const double wrong = is_stated ? evidence.SigmaIsWrong(model) : 1.0;
      posterior.noise += wrong * model.probability;
      posterior.nothing += (1.0 - wrong) * model.probability;
      continue;
    }
    std::set<std::string> names;
    for (const int m : model.set.members) {
      if (model.HasPiece(m)) continue;
      names.insert(list.name[m]);
      auto& entries = list.IsUnnamed(m) ? functions : named;
      NamedProbability& entry = entries.emplace(list.name[m], NamedProbability{list.name[m], m, 0.0}).first->second;
      if (model.probability > most[list.name[m]]) {
        most[list.name[m]] = model.probability;
        entry.explanation = m;
      }
      entry.probability += model.probability;
    }
    // The first of a kind is the most probable.
    const NameSet fresh{names, has_unnamed, 0.0, static_cast<int>(i), {}};
    NameSet& set = sets.emplace(std::make_pair(names, IsPose(evidence, model)), fresh).first->second;
    set.probability += model.probability;
    set.models.push_back(static_cast<int>(i));
  }
  const auto sorted = [](const auto& entries) {
    std::vector<typename std::decay_t<decltype(entries)>::mapped_type> entries_by_probability;
    for (const auto& [key, entry] : entries) entries_by_probability.push_back(entry);
    std::stable_sort(entries_by_probability.begin(), entries_by_probability.end(),
                     [](const auto& a, const auto& b) { return a.probability > b.probability; });
    return entries_by_probability;
  };
  for (auto* entries : {&named, &functions}) {  // rounding of the sums
    for (auto& [name, entry] : *entries) entry.probability = std::min(1.0, entry.probability);
  }
  posterior.unnamed = std::min(1.0, posterior.unnamed);
  posterior.sets = sorted(sets);
  posterior.explanations = sorted(named);
  posterior.functions = sorted(functions);
  return posterior;
}

std::vector<Flip> WhatFlips(const Evidence& evidence, const Posterior& posterior, double gate) {
  const Leading now = LeadingOf(posterior, gate);
  std::vector<Flip> flips;
  for (const double factor : {kThreefold, 1.0 / kThreefold}) {
    const Changed changes[] = {{"nothing", factor, 1.0, 1.0, 1.0},
                               {"catalogue", 1.0, factor, 1.0, 1.0},
                               {"unnamed", 1.0, 1.0, factor, 1.0},
                               {"further", 1.0, 1.0, 1.0, factor}};
    for (const Changed& change : changes) {
      std::vector<WeightedModel> changed = evidence.models();
      for (WeightedModel& model : changed) model.log_weight += change.LogFactor(evidence, model);
      Normalise(&changed);
      const Leading then = LeadingOf(PosteriorOf(evidence, changed), gate);
      if (then == now) continue;
      flips.push_back({change.mass, factor > 1.0, then.is_something, Without(evidence.list(), then.names, now.names),
                       Without(evidence.list(), now.names, then.names)});
    }
  }
  return flips;
}

}  // namespace sagitta
