// What the weights of all sets say, by name: one name for all change points of a jump and all shapes of a compensator.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "estimator/evidence/evidence.h"

namespace sagitta {

struct NameSet {
  std::vector<int> names;  // places among all names in their order, ascending
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
  double Of(const std::string& name) const;
};

// The unnamed part of a deviation that follows the pose in its own way counts as unnamed; pieces of a nameless cause
// have no name.
Posterior PosteriorOf(const Evidence& evidence, const std::vector<WeightedModel>& models);

// P that an effect of the catalogue holds on any target, with any settings.
double ProbabilityOf(const std::string& effect, const Evidence& evidence, const std::vector<WeightedModel>& models);

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
