// The set of effects that leads: everything weighed on one linearization, the likely sets refitted in the full model,
// and, where the full model refutes that linearization, both once more about what was found.
//
// The linearization about the believed model is as good as that model is near. Where something large is missing, values
// that it estimates are off by what they absorb: a weight moves a joint by compliance times torque, so where a
// compliance is 20 % too large every column of a weight is, too. What that leaves over looks like a smooth function, so
// pieces of a nameless cause are refitted as the effects that they may be. About the optimum of the leading set's
// effects its neighbours (one more, one less, another instead) are weighed where they are, as in each step of
// Gauss-Newton.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "estimator/diagnosis/selected_effects.h"

namespace sagitta {

struct LeadingSet {
  std::unique_ptr<Evidence> evidence;
  Posterior posterior;    // of the evidence's models
  bool is_named = false;  // something is missing, with more than the gate
  RefittedSet refitted;   // the leading set; where nothing is named the best that holds nothing
  std::vector<RivalSet> rivals;
  bool is_refuted = false;  // the full model still refutes the linearization: probabilities are rough
};

// What a search is given.
struct SearchInput {
  const CalibrationProblem& working;  // what the evidence is made of
  const DiagnosedModel& baseline;     // fitted with the noise as stated
  const PriorMasses& prior;
  double sigma_dof = 0.0;  // what states the noise (ResidualLikelihood)
  double gate = 0.0;       // of the probability
  const JointOptions& joint;
  std::function<void(const std::string&)> progress;  // may be empty
  int most_again = 3;  // steps of Gauss-Newton, of which each squares what is off: from 60 % to 2 %
};

// before: of other rows of the same problem; the search starts from its best set. May be null.
LeadingSet FindLeading(const SearchInput& input, const Evidence* before);

}  // namespace sagitta
