// From the most probable set to effects: effects in order of strength, refitted, and judged on untouched rows.
#pragma once

#include <vector>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/diagnosis/undecided.h"

namespace sagitta {

struct SelectedEffect {
  int explanation = 0;
  Candidate candidate;
  MemberFit fit;      // the others given
  double loss = 0.0;  // of log weight where it is left out
};

// The catalogue's effects of the set, strongest first, without the pieces of a nameless cause; a compensator starts
// from the spring of its shape that the data ask for, and a compliance that it acts through, which comes before it,
// from its value in the set.
std::vector<SelectedEffect> SelectedEffectsOf(const Evidence& evidence, const WeightedModel& model,
                                              const DiagnosedModel& lacking);
std::vector<Candidate> CandidatesOf(const std::vector<SelectedEffect>& effects);
std::vector<int> ExplanationsOf(const std::vector<SelectedEffect>& effects);
// One explanation by itself, with what it needs.
WeightedModel Alone(const Evidence& evidence, int view, int explanation);

// The best sets once more, in the full model: where it has no optimum a set is none, and what the linear model promised
// is replaced by what the full one keeps. With D the residual's square at the best values, linear and full,
//
//   log weight += log f(D_full) - log f(D_linear)
//
// which leaves determinants and priors as they are: they change little over the few standard deviations that the two
// optima are apart.
struct RefittedSet {
  WeightedModel model;
  DiagnosedModel lacking;               // the believed model with the noise that goes with the set
  std::vector<SelectedEffect> effects;  // of the catalogue
  DiagnosedModel with_effects;
  bool is_found = true;  // no: an optimum without what the linear model found, of many, is none

  bool IsUsable() const { return is_found && sagitta::IsUsable(with_effects.estimate.status); }
};

// working: what the evidence is made of. baseline: fitted with the noise as stated.
RefittedSet RefitSet(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& working,
                     const DiagnosedModel& baseline, const JointOptions& joint);

// The most probable sets by name, refitted; `evidence` and `posterior` follow. The leading one is returned: of those
// with an optimum in the full model, or the first as it is where none has one. gate: of Posterior::Leading. rivals: the
// other refitted sets that do not hold all its effects.
RefittedSet RefitLeading(const CalibrationProblem& working, const DiagnosedModel& baseline, const JointOptions& joint,
                         double gate, Evidence* evidence, Posterior* posterior, std::vector<RivalSet>* rivals);

// Log likelihood of the set's effects alone in the full model, which has neither functions without a name nor a
// deviation that follows the pose: two settings of an effect are compared by it whatever else the set holds.
double LogOfFull(const Evidence& evidence, const RefittedSet& refitted);
// What the full model finds more of log likelihood than the linear one in the set's effects, those without a name left
// out, which the full model cannot hold.
double LogFullOverLinear(const Evidence& evidence, const RefittedSet& refitted);

// What is known of a spring beyond its columns, once it is fitted: its rest length, and which way it acts, in place of
// which way the springs act that its columns stand for.
double LogPriorOfFitted(const Evidence& evidence, const RefittedSet& refitted, const SelectedEffect& spring);

// P of a reduction by chance, the best of so many tests: chi-square in the noise that is stated; F in units of the
// scatter that is left (chi-square per degree of freedom, dof of them) where that is more, or where none is stated.
double CorrectedP(double reduction, int parameters, double scatter, int dof, bool is_sigma_stated, int tests);

// What each candidate alone does with the believed model, to first order, most evident first.
std::vector<ScreenedCandidate> Screen(const Evidence& evidence, const DiagnosedModel& baseline);

// The aligned nominal robot in the parameters of an extended model: what it does not have is zero, but for the shape of
// a spring, which pulls nothing where its rate is zero.
ParameterSet AlignedAs(const ParameterSet& nominal, const ParameterSet& extended);
bool IsEstimated(const EffectSpec& spec, const Estimate& estimate);

// P that values as far from 0 come about by chance, by the full estimator's covariance: what it says against an effect.
double WaldP(const EffectSpec& spec, const Estimate& estimate);

// floor: m, of the gap.
std::vector<EffectGroup> GroupEffects(const std::vector<FoundEffect>& effects, const DiagnosedModel& lacking,
                                      const DiagnosedModel& baseline, const DiagnosedModel& final, double floor,
                                      const JointOptions& joint);

}  // namespace sagitta
