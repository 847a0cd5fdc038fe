// Choosing the effects that a believed model lacks: forward steps, each refitted
// in the full joint model; steps that have a rival are dropped or swapped, after
// every growth up to four steps, and at the end beyond.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/diagnosis/screening.h"

namespace sagitta {

struct SelectionOptions {
  double significance = 0.005;  // of a step, corrected for the whole search
  int most_steps = 24;
  int refitted = 8;  // best of the screening that are refitted
  double tie = 6.0;  // of the best penalised reduction: ties go to the simpler
  // The best decoy on the baseline. Where it alone leaves nothing to explain, three
  // steps that lose to it are a stack that imitates it, and the search ends.
  double decoy_gain = -1e300;
  bool decoy_explains_all = false;
  JointOptions joint;
  int num_threads = 1;
  std::function<void(const std::string&)> progress;
};

struct ScreenedCandidate {
  Candidate candidate;
  Score score;
  double corrected_p = 1.0;
  std::vector<EffectSpec> starts;     // of the refit; more than one where the effect is not linear
  std::optional<double> holdout_rms;  // m, with this candidate alone beside the believed model; of the best few
};

// Whether a coordinate of this name is a parameter of the effect.
bool IsParameterOf(const EffectSpec& spec, const std::string& name);

// What a step did when it was chosen, beside the noise that was taken then: where that shrinks as more is explained, it
// does more in the end.
struct ChosenStep {
  Candidate candidate;
  int parameters = 0;
  double reduction = 0.0;  // chi-square, after refit
  double penalised = 0.0;
  double corrected_p = 1.0;
};

// The rule of FORMATS section 6 among significant steps (not empty): the best penalised, or the simplest that ties with
// it and is not oversized. That is the effect. Its targets and settings all have the same parameters: one that tells
// fewer of them is not simpler for it, its rivals only have what chance gives (about 1 each; 2 as in Akaike's
// criterion). Twins, which move every marker alike (the scales of two stations), fit alike but for rounding: the first
// in the list.
ChosenStep PickByRule(const std::vector<ChosenStep>& steps, double tie);

// All candidates scored against the model, best penalised first.
std::vector<ScreenedCandidate> Screen(const DiagnosedModel& model, const std::vector<Candidate>& candidates);

// The model with these effects more, refitted from its own optimum: parameters, chi-square and degrees of freedom.
// What is reported of it comes from JudgeFully.
DiagnosedModel Extend(const DiagnosedModel& model, const std::vector<Candidate>& added, const JointOptions& options);
std::vector<Candidate> CandidatesOf(const std::vector<ChosenStep>& steps);

// Forward selection in which steps are dropped and swapped, from those of `start`;
// `model` becomes the extended one.
std::vector<ChosenStep> SelectEffects(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates,
                                      const SelectionOptions& options, const std::vector<ChosenStep>& start,
                                      DiagnosedModel* model);

// Penalised chi-square reduction of a set of steps against the baseline.
double PenalisedTotal(const DiagnosedModel& baseline, const DiagnosedModel& model,
                      const std::vector<ChosenStep>& steps);

}  // namespace sagitta
