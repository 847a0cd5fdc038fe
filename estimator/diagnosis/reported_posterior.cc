#include "estimator/diagnosis/reported_posterior.h"

#include <algorithm>

#include "estimator/report/explanations_words.h"

namespace sagitta {
namespace {

constexpr double kMostOfTheSets = 0.99;  // of the probability: FORMATS section 6

}  // namespace

ReportedPosterior ReportPosterior(const Evidence& evidence, const Posterior& posterior, const Posterior& averaged,
                                  const PriorMasses& prior, double gate) {
  const ExplanationList& list = evidence.list();
  ReportedPosterior report;
  report.nothing = posterior.nothing;
  report.noise = posterior.noise;
  report.unnamed = averaged.unnamed;
  report.prior = prior;
  for (const NamedProbability& entry : averaged.explanations) {
    report.explanations.push_back({list.start[entry.explanation], entry.probability});
  }
  double sum = posterior.nothing + posterior.noise;
  for (const NameSet& set : posterior.sets) {
    if (sum >= kMostOfTheSets) break;
    sum += set.probability;
    const WeightedModel& best = evidence.models()[set.best];
    report.sets.push_back(list.ByName(best.set.members, set.probability, best.pieces));
    if (evidence.ViewOf(best).kind == NoiseView::Kind::kPose) {
      report.sets.back().unnamed.push_back(JointsFollowPose());
    }
  }
  for (const Flip& flip : WhatFlips(evidence, posterior, gate)) {
    report.flips.push_back(
        {flip.mass, flip.is_larger, flip.is_something, list.ByName(flip.more, 0.0), list.ByName(flip.fewer, 0.0)});
  }
  return report;
}

}  // namespace sagitta
