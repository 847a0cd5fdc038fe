// The believed model with effects more, fitted again.
#pragma once

#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/explanations/candidates.h"

namespace sagitta {

// Whether a coordinate of this name is a parameter of the effect.
bool IsParameterOf(const EffectSpec& spec, const std::string& name);

// Refitted from the model's own optimum, what the data determine poorly of these effects (Candidate::loose) with its
// widest prior: parameters, chi-square and degrees of freedom, by Gauss-Newton where that converges and nothing becomes
// so uncertain that it has to be held. What is reported comes from JudgeFully.
DiagnosedModel Extend(const DiagnosedModel& model, const std::vector<Candidate>& added, const JointOptions& options);

}  // namespace sagitta
