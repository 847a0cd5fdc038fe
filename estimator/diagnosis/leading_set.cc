#include "estimator/diagnosis/leading_set.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "estimator/diagnosis/refit_order.h"
#include "estimator/explanations/moments.h"
#include "estimator/report/explanations_words.h"

namespace sagitta {
namespace {

constexpr int kMostAgain = 3;

LeadingSet WeighAndRefit(const SearchInput& input, const Evidence* before, const LinearizedAbout& about) {
  const ParameterSet& believed = input.baseline.estimate.parameters;
  ParameterSet here = believed;
  here.CopyByName(about.parameters);
  CandidateList candidates = ListCandidates(input.working, here);
  RefineMoments(input.working, believed, &candidates);  // the same moments about any point
  LeadingSet found;
  found.evidence = std::make_unique<Evidence>(input.working, believed, candidates, input.prior, input.sigma_dof,
                                              input.progress, before, about);
  found.posterior = PosteriorOf(*found.evidence, found.evidence->models());
  const auto is_named = [&] { return found.posterior.Something() > input.gate && !found.posterior.sets.empty(); };
  if (is_named()) {
    found.refitted = RefitLeading(input.working, input.baseline, input.joint, input.gate, found.evidence.get(),
                                  &found.posterior, &found.rivals);
  }
  found.is_named = is_named();  // the full model may leave less of it
  if (!found.is_named) {
    found.refitted =
        RefitSet(*found.evidence, found.evidence->BestOfNothing(), input.working, input.baseline, input.joint);
  }
  return found;
}

std::set<std::string> PathsOf(const LinearizedAbout& about) {
  std::set<std::string> paths;
  for (const EffectSpec& spec : about.effects) paths.insert(spec.Path());
  return paths;
}

LinearizedAbout AboutLeading(const LeadingSet& found) {
  return {SpecsOf(CandidatesOf(found.refitted.effects)), found.refitted.with_effects.estimate.parameters};
}

bool IsRefuted(const LeadingSet& found) {
  if (!found.is_named || !found.refitted.IsUsable() || found.refitted.effects.empty()) return false;
  const double error = LinearizationError(*found.evidence, found.refitted);
  VLOG(1) << "diagnosis: the linear model is off by " << error << " of the leading set's log evidence";
  return error > kInDoubt;
}

}  // namespace

LeadingSet FindLeading(const SearchInput& input, const Evidence* before) {
  LeadingSet found = WeighAndRefit(input, before, {});
  std::set<std::set<std::string>> known;  // effects about which the model was linearized
  for (int again = 0; again < kMostAgain && IsRefuted(found); ++again) {
    const LinearizedAbout about = AboutLeading(found);
    if (!known.insert(PathsOf(about)).second) break;
    if (input.progress) input.progress(WeighingAboutWhatWasFound());
    LeadingSet anew = WeighAndRefit(input, found.evidence.get(), about);
    if (!anew.is_named || !anew.refitted.IsUsable()) break;  // "nothing" is far from here: no linearization reaches it
    found = std::move(anew);
  }
  return found;
}

}  // namespace sagitta
