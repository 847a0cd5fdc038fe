// What is asked of an effect of the most probable set, from the same normal equations: what else would replace it,
// and is it named and estimated alike on two disjoint halves of the data?
#pragma once

#include <string>
#include <vector>

#include "estimator/evidence/posterior.h"
#include "problems/significance.h"

namespace sagitta {

constexpr double kWorthListing = 0.01;  // FORMATS section 6

struct Alternative {
  EffectSpec spec;
  double probability = 0.0;  // over all sets
  double overlap = 0.0;      // share of the effect's chi-square reduction that it reproduces
};

// The other explanations of a member's name, best first in its place.
std::vector<int> OthersOfItsName(const Evidence& evidence, const WeightedModel& model, int member);

// Chi-square reduction of a group, given the others.
struct MemberFit {
  double reduction = 0.0;
  int parameters = 0;
};
// By what the others leave.
MemberFit FitOf(const GivenOthers& given);
// Fills in what the data determine poorly of a member, given the others: of the prior variance a fifth or more is left;
// and what needs its prior.
void MarkUndetermined(const Evidence& evidence, int member, const GivenOthers& given, Candidate* candidate);
// Square of the residual at the set's values with the widest prior, as refits have it (diagnosed_model.h), of a spring
// with its own; the prior's own term left out.
double ResidualAtBest(const Evidence& evidence, const WeightedModel& model);

// The effect's name on one half of the poses, contiguous in the order of the rows: its probability in its place, the
// others given; and what the half says of its parameters, in typical sizes.
struct HalfResult {
  double probability = 0.0;
  std::string best;  // name that leads
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
};

// Do two halves of the poses say the same of an effect?
constexpr double kHalvesContradict = kDefaultSignificance;  // p below which their values do not
constexpr double kHalvesDiffer = 0.05;                      // and below which that they agree is not said: outside 95 %
struct Confirmation {
  std::vector<HalfResult> halves;
  double compatible_p = 1.0;  // of the halves' values being one; not a number where there is nothing to compare
};

// Probability of each name in the place of each member of a model's set, given the others: most probable first, the
// member's own included, unnamed ones too.
std::vector<std::vector<NamedProbability>> InPlaces(const Evidence& evidence, const WeightedModel& model);

// What else of the catalogue could stand in an effect's place, with a probability of kWorthListing or more given the
// others or over all sets; and the two halves.
struct CheckedEffect {
  std::vector<Alternative> alternatives;
  Confirmation confirmation;
};
// Of some members of a model's set. in_places: InPlaces of the model.
std::vector<CheckedEffect> CheckEffects(const Evidence& evidence, const Posterior& posterior,
                                        const WeightedModel& model,
                                        const std::vector<std::vector<NamedProbability>>& in_places,
                                        const std::vector<int>& members);

}  // namespace sagitta
