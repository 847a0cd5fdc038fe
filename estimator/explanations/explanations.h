// Everything that could explain the gap, in one list: every effect of the catalogue on every target with every setting,
// compensators of every shape, and what has no name: random functions of what a pose, a load, a time or a place may
// drive. Each is a group of columns with its share of the prior.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "estimator/explanations/candidates.h"
#include "estimator/explanations/compensator_shapes.h"
#include "estimator/explanations/evidence_columns.h"
#include "estimator/explanations/unnamed_functions.h"
#include "estimator/random_effects/set_search.h"
#include "problems/prior_masses.h"

namespace sagitta {

// What shares of the prior are equal over, level by level; then settings, and of one of these what is scanned.
struct PlaceInPrior {
  std::string family, target;
  double weight = 0.0;  // in its family; 0 in all of them: equal
  double listed = 1.0;  // share of its family that is in the list
};

// A set of explanations as people read it.
struct NamedSet {
  double probability = 0.0;
  std::vector<EffectSpec> specs;
  std::vector<std::string> unnamed;  // words
};

// Everything that may be missing, with its share of the prior; lists of equal length.
struct ExplanationList {
  std::vector<Explanation> math;
  std::vector<int> candidate;       // of each, index into `candidates`; -1: unnamed
  std::vector<int> unnamed;         // of each, index into `functions`; -1: of the catalogue
  std::vector<EffectSpec> start;    // of each of the catalogue: a compensator's shape is in its values
  std::vector<std::string> name;    // of each: the same for all change points, and for all shapes of a compensator
  std::vector<PlaceInPrior> place;  // of each
  std::map<std::string, SpringShares> springs;  // by joint, at the fitted shots
  std::vector<Candidate> candidates;            // as listed
  std::vector<UnnamedFunction> functions;
  std::vector<NotTestable> not_testable;

  bool IsUnnamed(int explanation) const { return unnamed[explanation] >= 0; }
  // Effects with their settings: what is tested.
  int NumNamed() const { return static_cast<int>(std::count(unnamed.begin(), unnamed.end(), -1)); }
  const EffectSpec& SpecOf(int explanation) const { return candidates[candidate[explanation]].spec; }
  // pieces: members that are read as parts of a cause without a name, ascending.
  NamedSet ByName(const std::vector<int>& members, double probability, const std::vector<int>& pieces = {}) const;
};

// What an effect is called as an explanation: change points, widths and lags are many settings of one.
std::string NameOfExplanation(const Robot& robot, EffectSpec spec);

// Adds the columns that the explanations need beyond the catalogue's. with_unnamed: also what has no name.
ExplanationList ListExplanations(const CalibrationProblem& problem, const ParameterSet& parameters,
                                 const CandidateList& candidates, const PriorMasses& prior, EvidenceColumns* columns,
                                 bool with_unnamed = true);

// Drops what these rows cannot show and shares the prior among the rest: three times its typical size, an explanation
// would not stand out by one standard deviation. Effects of which nothing is left become not testable.
void DropInvisible(const ProjectedNormal& normal, const PriorMasses& prior, ExplanationList* list);

}  // namespace sagitta
