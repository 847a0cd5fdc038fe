// What the weights of all sets say, by name: one name for all change points of a jump and all shapes of a compensator.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "estimator/evidence/evidence.h"

namespace sagitta {

struct NameSet {
  std::vector<int> names;    // places among all names in their order, ascending
  std::vector<int> effects;  // of them those of the catalogue
  std::vector<int> pieces;   // names of the pieces of a nameless cause, in the most probable of the models
  bool has_unnamed = false;
  double probability = 0.0;
  int best = 0;             // of the models
  std::vector<int> models;  // all of them
};

// A name with the probability that its explanation holds.
struct NamedProbability {
  std::string name;
  int explanation = 0;  // the most probable of that name
  double probability = 0.0;
};

// Probabilities of names and of sets of names.
struct Posterior {
  double nothing = 0.0;                        // no explanation, noise as stated
  double noise = 0.0;                          // no explanation, noise other than stated
  double unnamed = 0.0;                        // sets that hold something without a name
  std::vector<NameSet> sets;                   // most probable first
  std::vector<NamedProbability> explanations;  // of the catalogue, most probable first
  std::vector<NamedProbability> functions;     // unnamed ones

  double Something() const { return 1.0 - nothing - noise; }
  double MoreThan(size_t names) const;  // that so many do not suffice
  // Place among `sets`, of which there is one, of the one to name. The most probable set may be one of many that share
  // the probability, of which most hold the same effect and each something else: that effect is named. gate: of the
  // probability, given what is named, that an effect is to be added, above which the most probable one is.
  size_t Leading(double gate) const;
  // Of an effect of that set. It is named with even odds (as in the median probability model: Barbieri and Berger,
  // Annals of Statistics 32 (2004) 870), or with more than what has no name: others share its place then.
  bool IsNamed(double probability) const { return probability >= std::min(kEvenOdds, unnamed); }
  double Of(const std::string& name) const;
};

// The unnamed part of a deviation that follows the pose in its own way counts as unnamed; pieces of a nameless cause
// have no name.
Posterior PosteriorOf(const Evidence& evidence, const std::vector<WeightedModel>& models);

// P that an effect of the catalogue holds on any target, with any settings.
double ProbabilityOf(const std::string& effect, const Evidence& evidence, const std::vector<WeightedModel>& models);

// Log of a model's prior with other masses over that with the evidence's own.
double LogPriorRatio(const Evidence& evidence, const WeightedModel& model, const PriorMasses& then);

// What would be named otherwise with a prior mass three times as large or as small.
struct Flip {
  std::string mass;  // as in the experiment's `prior`
  bool is_larger = false;
  bool is_something = false;     // something is missing then
  std::vector<int> more, fewer;  // explanations that are named then only, now only
};

// gate: of the probability that something is missing, above which it is named.
std::vector<Flip> WhatFlips(const Evidence& evidence, const Posterior& posterior, double gate);

}  // namespace sagitta
