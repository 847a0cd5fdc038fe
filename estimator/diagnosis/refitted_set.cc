#include "estimator/diagnosis/refitted_set.h"

#include <algorithm>
#include <limits>

#include "estimator/diagnosis/refit.h"

namespace sagitta {
namespace {

// Of the probability: a set that may lead once others have lost what the full model does not keep.
constexpr double kMayLead = 0.05;
constexpr size_t kMostRefitted = 4;

// near: the believed model with a noise like that of this model.
DiagnosedModel LackingBeside(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& working,
                             const DiagnosedModel& baseline, const Estimate& near, const JointOptions& joint) {
  const bool is_other = evidence.views()[model.view].view.kind != NoiseView::Kind::kStated;
  if (!is_other && evidence.IsSigmaStated() && evidence.SigmaIsWrong(model) <= kEvenOdds) return baseline;
  DiagnosedModel refit = RefitFully(WithNoiseOf(evidence, model, working), near, joint);
  return IsUsable(refit.estimate.status) ? refit : baseline;
}

// A spring's shape is a narrow valley, or one without an end where the data hardly tell it: near the start's shape, and
// near others, the refit may find its floor.
void TryOtherSprings(const Evidence& evidence, const JointOptions& joint, RefittedSet* refitted) {
  for (SelectedEffect& effect : refitted->effects) {
    if (!IsGravityCompensator(effect.candidate.spec)) continue;
    effect.candidate.keeps_shape = true;
    std::vector<EffectSpec> springs = OtherSprings(evidence, refitted->model, effect, refitted->lacking);
    springs.insert(springs.begin(), effect.candidate.spec);
    for (const EffectSpec& spring : springs) {
      effect.candidate.spec = spring;
      refitted->with_effects = Extend(refitted->lacking, CandidatesOf(refitted->effects), joint);
      if (refitted->IsUsable()) return;
    }
  }
}

// Sets that may lead, by their best models.
std::vector<size_t> MayLead(const Posterior& posterior) {
  std::vector<size_t> sets;
  for (size_t s = 0; s < posterior.sets.size() && sets.size() < kMostRefitted; ++s) {
    if (s == 0 || posterior.sets[s].probability >= kMayLead) sets.push_back(s);
  }
  return sets;
}

// Sets of one view have almost the same noise, and where it is large many steps lead from the stated one to it.
const RefittedSet* LastOfView(const std::vector<RefittedSet>& refitted, int view) {
  const auto last = std::find_if(refitted.rbegin(), refitted.rend(),
                                 [view](const RefittedSet& each) { return each.model.view == view; });
  return last == refitted.rend() ? nullptr : &*last;
}

}  // namespace

RefittedSet RefitSet(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& working,
                     const DiagnosedModel& baseline, const JointOptions& joint, const RefittedSet* near) {
  RefittedSet refitted;
  refitted.model = model;
  const Estimate& start = near == nullptr ? baseline.estimate : near->lacking.estimate;
  refitted.lacking = LackingBeside(evidence, model, working, baseline, start, joint);
  refitted.effects = SelectedEffectsOf(evidence, model, refitted.lacking);
  refitted.with_effects = Extend(refitted.lacking, CandidatesOf(refitted.effects), joint);
  if (!refitted.IsUsable()) TryOtherSprings(evidence, joint, &refitted);
  return refitted;
}

double LogCorrection(const Evidence& evidence, const RefittedSet& refitted) {
  if (!refitted.IsUsable()) return -std::numeric_limits<double>::infinity();
  if (refitted.effects.size() != refitted.model.set.members.size()) return 0.0;
  const ResidualLikelihood likelihood = evidence.LikelihoodOf(refitted.model.view);
  const double nothing = evidence.views()[refitted.model.view].beside.normal.residual;
  // In units of the rows' sigma: the refit may have another.
  const double unit = nothing / refitted.lacking.estimate.chi2;
  return likelihood.Log(unit * refitted.with_effects.estimate.chi2) -
         likelihood.Log(ResidualAtBest(evidence, refitted.model));
}

RefittedSet RefitLeading(const CalibrationProblem& working, const DiagnosedModel& baseline, const JointOptions& joint,
                         Evidence* evidence, Posterior* posterior) {
  std::vector<RefittedSet> refitted;
  std::vector<double> corrections(evidence->models().size(), 0.0);
  bool any_usable = false;
  for (const size_t s : MayLead(*posterior)) {
    const NameSet& set = posterior->sets[s];
    const WeightedModel& best = evidence->models()[set.best];
    refitted.push_back(RefitSet(*evidence, best, working, baseline, joint, LastOfView(refitted, best.view)));
    any_usable |= refitted.back().IsUsable();
    const double correction = LogCorrection(*evidence, refitted.back());
    for (const int m : set.models) corrections[m] = correction;
  }
  if (!any_usable) return refitted[0];
  evidence->Correct(corrections);
  *posterior = PosteriorOf(*evidence, evidence->models());
  if (posterior->sets.empty()) return refitted[0];
  const WeightedModel& leading = evidence->models()[posterior->sets[0].best];
  for (RefittedSet& each : refitted) {
    const bool is_same = each.model.set.members == leading.set.members && each.model.pieces == leading.pieces;
    if (each.model.view == leading.view && is_same) return each;
  }
  return RefitSet(*evidence, leading, working, baseline, joint, LastOfView(refitted, leading.view));
}

}  // namespace sagitta
