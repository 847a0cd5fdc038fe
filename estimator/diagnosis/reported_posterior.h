// The posterior as it is reported: by effect, target and settings, in words where there is no name.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estimator/evidence/posterior.h"

namespace sagitta {

// What another prior would name.
struct ReportedFlip {
  std::string mass;
  bool is_larger = false;  // three times, else a third
  bool is_something = false;
  NamedSet more, fewer;  // than is named
};

// The probabilities by name, and what they would be under another prior.
struct ReportedPosterior {
  double nothing = 1.0, noise = 0.0, unnamed = 0.0;
  std::vector<std::pair<EffectSpec, double>> explanations;
  std::vector<NamedSet> sets;  // all that are needed for 99 %
  PriorMasses prior;
  std::vector<ReportedFlip> flips;
};

// `posterior` is of the evidence's models; effects and what has no name have the probabilities of `averaged`. gate: of
// the probability that something is missing, above which it is named.
ReportedPosterior ReportPosterior(const Evidence& evidence, const Posterior& posterior, const Posterior& averaged,
                                  const PriorMasses& prior, double gate);

}  // namespace sagitta
