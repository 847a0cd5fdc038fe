// What is asked of an effect of the most probable set, from the same normal equations: what else would take its place,
// and is it named and estimated alike on two disjoint halves of the data?
#pragma once

#include <vector>

#include "estimator/diagnosis/posterior.h"

namespace sagitta {

struct Alternative {
  EffectSpec spec;
  double probability = 0.0;  // over all sets
  double overlap = 0.0;      // share of the effect's chi-square reduction that it reproduces
};

// What each explanation would do in the place of one member of a set, the others staying at their scales: one sweep of
// the whole set serves all places.
class Places {
 public:
  // Of a set of the listed explanations; `normal` and `explanations` must outlive this.
  Places(const ProjectedNormal& normal, const std::vector<Explanation>& explanations, const SetPrior& prior,
         const ResidualLikelihood& likelihood, const WeightedSet& set);

  // Log weights of the set with the listed explanations in the place of its k-th member; -infinity where the others
  // exclude one.
  std::vector<double> Weights(size_t place, const std::vector<int>& of) const;
  // Of one more group, given all but the k-th member.
  Eigen::MatrixXd Information(const ColumnGroup& group, size_t place) const;
  Eigen::VectorXd Gradient(const ColumnGroup& group, size_t place) const;

 private:
  const std::vector<Explanation>& explanations_;
  SetPrior prior_;
  ResidualLikelihood likelihood_;
  std::vector<int> members_;
  Sweep sweep_;
  std::vector<Sweep::WithoutOne> without_;  // each member
};
// Of a model's set among all explanations.
Places PlacesOf(const Evidence& evidence, const WeightedModel& model);

// Probability of each name in the effect's place, given the others of the set: most probable first, the effect's own
// included, unnamed ones too. place: of the effect in the set.
std::vector<NamedProbability> InPlaceOf(const Evidence& evidence, const Places& places, size_t place);
// The other explanations of a member's name, best first in its place.
std::vector<int> OthersOfItsName(const Evidence& evidence, const WeightedModel& model, int member);

// Those of the catalogue with a probability of kWorthListing or more in the effect's place.
std::vector<Alternative> FindAlternatives(const Evidence& evidence, const Posterior& posterior, const Places& places,
                                          const WeightedModel& model, size_t place,
                                          const std::vector<NamedProbability>& in_place);
constexpr double kWorthListing = 0.01;  // FORMATS section 6

// Chi-square reduction of a member, given the others; and parameters that the data cannot tell: of the prior variance
// a fifth or more is left.
struct MemberFit {
  double reduction = 0.0;
  int parameters = 0;
  std::vector<std::string> poorly_determined;  // coordinates
  std::vector<std::string> loose;              // names of those that need their prior
};
// Square of the residual at the set's values beside the widest prior, as refits have it (refit.h), of a spring beside
// its own; the prior's own term left out.
double ResidualAtBest(const Evidence& evidence, const WeightedModel& model);
// given: its normal equations given the others.
MemberFit FitOf(const Evidence& evidence, int member, const GivenOthers& given);
// Every member of a model's set given the others, at their scales.
std::vector<GivenOthers> EachGivenOthers(const Evidence& evidence, const WeightedModel& model);

// The effect's name on one half of the poses, contiguous in the order of the rows: its probability in its place, the
// others given; and what the half says of its parameters, in typical sizes.
struct HalfResult {
  double probability = 0.0;
  std::string best;  // name that leads
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
};

// Do two halves of the poses say the same of an effect?
struct Confirmation {
  std::vector<HalfResult> halves;
  double compatible_p = 1.0;  // of the halves' values being one; not a number where there is nothing to compare
};

// Of the members at these places; in_place: of each, what else could stand there, with its probability. Each half is
// summed once for all of them.
std::vector<Confirmation> ConfirmEach(const Evidence& evidence, const WeightedModel& model,
                                      const std::vector<size_t>& places,
                                      const std::vector<std::vector<NamedProbability>>& in_place);

}  // namespace sagitta
