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

// Log factor on a model's weight when one mass is multiplied.
struct Changed {
  const char* words;
  double nothing, catalogue, unnamed, further;  // factors

  double LogFactor(const Evidence& evidence, const WeightedModel& model) const {
    const size_t count = model.set.members.size();
    if (count == 0) return std::log(HasUnnamed(evidence, model) ? unnamed : nothing);
    double log = static_cast<double>(count - 1) * std::log(further);
    for (const int m : model.set.members) log += std::log(evidence.list().IsUnnamed(m) ? unnamed : catalogue);
    return log;
  }
};

std::string Leading(const Posterior& posterior) {
  if (posterior.Something() < 0.5) return "nothing is missing";
  if (posterior.sets.empty()) return "";
  std::string words;
  for (const std::string& name : posterior.sets[0].names) words += (words.empty() ? "" : " and ") + name;
  return words.empty() ? "something without a name" : words;
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
      names.insert(list.name[m]);
      auto& entries = list.IsUnnamed(m) ? functions : named;
      NamedProbability& entry = entries.emplace(list.name[m], NamedProbability{list.name[m], m, 0.0}).first->second;
      if (model.probability > most[list.name[m]]) {
        most[list.name[m]] = model.probability;
        entry.explanation = m;
      }
      entry.probability += model.probability;
    }
    const NameSet fresh{names, has_unnamed, 0.0, static_cast<int>(i)};  // the first of a kind is the most probable
    sets.emplace(std::make_pair(names, IsPose(evidence, model)), fresh).first->second.probability += model.probability;
  }
  const auto sorted = [](const auto& entries) {
    std::vector<typename std::decay_t<decltype(entries)>::mapped_type> entries_by_probability;
    for (const auto& [key, entry] : entries) entries_by_probability.push_back(entry);
    std::stable_sort(entries_by_probability.begin(), entries_by_probability.end(),
                     [](const auto& a, const auto& b) { return a.probability > b.probability; });
    return entries_by_probability;
  };
  posterior.sets = sorted(sets);
  posterior.explanations = sorted(named);
  posterior.functions = sorted(functions);
  return posterior;
}

std::vector<std::string> WhatFlips(const Evidence& evidence, const Posterior& posterior) {
  const std::string now = Leading(posterior);
  std::vector<std::string> flips;
  for (const double factor : {kThreefold, 1.0 / kThreefold}) {
    const Changed changes[] = {{"nothing", factor, 1.0, 1.0, 1.0},
                               {"catalogue", 1.0, factor, 1.0, 1.0},
                               {"unnamed", 1.0, 1.0, factor, 1.0},
                               {"further", 1.0, 1.0, 1.0, factor}};
    for (const Changed& change : changes) {
      std::vector<WeightedModel> changed = evidence.models();
      for (WeightedModel& model : changed) model.log_weight += change.LogFactor(evidence, model);
      Normalise(&changed);
      const std::string then = Leading(PosteriorOf(evidence, changed));
      if (then == now) continue;
      flips.push_back(std::string("With a prior of '") + change.words + "' three times as " +
                      (factor > 1.0 ? "large" : "small") + ": " + then + " instead of " + now + ".");
    }
  }
  return flips;
}

}  // namespace sagitta
