#include "estimator/diagnosis/undecided.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "estimator/least_squares/bounded_step.h"
#include "estimator/report/diagnosis_caution_words.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {

namespace {

// Of the probability of all: in doubles shares add up to 1 without one below this, and a rival would have to be
// 1 / sqrt(2.2e-16) = 7e7 standard deviations away for it to double a variance.
constexpr double kNoShareOfSets = std::numeric_limits<double>::epsilon();

double OfAll(double probability, const std::vector<RivalSet>& rivals) {
  return std::accumulate(rivals.begin(), rivals.end(), probability,
                         [](double sum, const RivalSet& rival) { return sum + rival.probability; });
}

}  // namespace

BetweenParts ErrorOfChoice(const Estimate& estimate, double probability, const std::vector<RivalSet>& rivals) {
  BetweenParts found;
  const double all = OfAll(probability, rivals);
  const auto counts = [all](const RivalSet& rival) { return rival.probability > kNoShareOfSets * all; };
  if (!(all > 0.0) || std::none_of(rivals.begin(), rivals.end(), counts)) return found;
  const auto coordinates = static_cast<Eigen::Index>(estimate.estimated.size());
  found.covariance = Eigen::MatrixXd::Zero(coordinates, coordinates);
  for (const RivalSet& rival : rivals) {
    if (!counts(rival)) continue;
    ParameterSet other = estimate.parameters;
    other.CopyByName(rival.parameters);
    const Eigen::VectorXd all_moved = TangentDifference(other, estimate.parameters);
    Eigen::VectorXd moved = all_moved(estimate.estimated);
    if (!estimate.held.coordinates.empty()) moved -= estimate.held.slopes * all_moved(estimate.held.coordinates);
    found.covariance += rival.probability / all * moved * moved.transpose();
  }
  found.variance = found.covariance.diagonal();
  found.reason = EffectsAreUndecided();
  found.draws = Eigen::VectorXd::Constant(coordinates, std::numeric_limits<double>::infinity());
  return found;
}

std::vector<std::vector<EffectSpec>> WhatRivalsHold(double probability, const std::vector<RivalSet>& rivals,
                                                    double share) {
  std::vector<std::vector<EffectSpec>> instead;
  for (const RivalSet& rival : rivals) {
    if (rival.probability > share * OfAll(probability, rivals)) instead.push_back(rival.instead);
  }
  return instead;
}

void AddTo(const BetweenParts& more, BetweenParts* between) {
  if (!more.known()) return;
  if (!between->known()) {
    *between = more;
    return;
  }
  if (between->covariance.size() == 0)
    between->covariance = Eigen::MatrixXd::Zero(more.covariance.rows(), more.covariance.cols());
  between->reason = more.reason + ", and " + between->reason;
  between->covariance += more.covariance;
  for (Eigen::Index i = 0; i < more.variance.size(); ++i) {
    const double own = between->variance[i], added = more.variance[i];
    between->draws[i] = own > 0.0 ? WelchDof(own, between->draws[i], added, more.draws[i]) : more.draws[i];
    between->variance[i] = own + added;
  }
}

}  // namespace sagitta
