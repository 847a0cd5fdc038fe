#include "estimator/diagnosis/leading_set.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "estimator/diagnosis/refit_order.h"
#include "estimator/diagnosis/scanned_settings.h"
#include "estimator/explanations/compensator_shapes.h"
#include "estimator/explanations/moments.h"
#include "estimator/least_squares/held_influence.h"
#include "estimator/report/explanations_words.h"

namespace sagitta {
namespace {

// Of what has no name: where that says ten times more, the linear model is not to blame for it.
constexpr double kItsFault = 0.1;

// between: those of the list.
LeadingSet WeighAndRefit(const SearchInput& input, const std::vector<Candidate>& between, const Evidence* before,
                         const LinearizedAbout& about) {
  const ParameterSet& believed = input.baseline.estimate.parameters;
  ParameterSet here = believed;
  here.CopyByName(about.parameters);
  CandidateList candidates = ListCandidates(input.working, here);
  candidates.candidates.insert(candidates.candidates.end(), between.begin(), between.end());
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

// The view of the noise with the same groups in which no deviation follows the pose; else the stated one, the first.
int ViewWithoutPose(const Evidence& evidence, const WeightedModel& model) {
  NoiseView plain = evidence.ViewOf(model);
  plain.kind = NoiseView::Kind::kStated;
  plain.sigma = 0.0;
  const auto& views = evidence.views();
  const auto same = std::find_if(views.begin(), views.end(),
                                 [&](const ViewedNormal& each) { return SizesOf(each.view) == SizesOf(plain); });
  return same == views.end() ? 0 : static_cast<int>(same - views.begin());
}

// The members of a set that are asked for, with their scales.
template <typename IsAskedFor>
WeightedSet MembersThat(const WeightedSet& all, const IsAskedFor& is_asked_for) {
  WeightedSet some;
  for (size_t k = 0; k < all.members.size(); ++k) {
    if (!is_asked_for(all.members[k])) continue;
    some.members.push_back(all.members[k]);
    some.scales.push_back(all.scales[k]);
  }
  return some;
}

// The leading set with all its effects of the catalogue, those too that may be pieces of a nameless cause, and nothing
// else: a function without a name, or a deviation that follows the pose, may be no more than what the linearization has
// wrong of these.
RefittedSet WithoutUnnamed(const SearchInput& input, const LeadingSet& found) {
  WeightedModel model = found.refitted.model;
  const bool follows_pose = found.evidence->FollowsPose(model);
  if (!follows_pose && model.set.members.size() == found.refitted.effects.size()) return found.refitted;
  if (follows_pose) model.view = ViewWithoutPose(*found.evidence, model);
  model.set = MembersThat(model.set, [&](int m) { return !found.evidence->list().IsUnnamed(m); });
  model.pieces.clear();
  return RefitSet(*found.evidence, model, input.working, input.baseline, input.joint);
}

// What the believed model's data do not determine is held, and the effects may show it: of a last axis that stands
// upright, the height of a marker on it, which only a foot that tilts needs. Held or not is decided again with them,
// and what is held rests where the rows have it then (held_rest.h).
void DecideHeldAnew(const SearchInput& input, RefittedSet* effects) {
  DiagnosedModel& with = effects->with_effects;
  if (!effects->IsUsable() || HeldCoordinates(input.baseline.estimate.parameters).empty()) return;
  const ParameterSet aligned = AlignedAs(input.baseline.estimate.aligned, with.problem->parameters);
  const DiagnosedModel judged = JudgeFully(with.problem, with.estimate.parameters, aligned, input.joint);
  if (IsUsable(judged.estimate.status)) with = judged;
}

double LogLikelihoodOf(const Evidence& evidence, const WeightedModel& model) {
  return evidence.SearchIn(model.view).Evaluate(model.set.members, model.set.scales).log_likelihood +
         evidence.views()[model.view].given_believed.log_constant;
}

// What functions without a name, and a deviation that follows the pose, add to a set's log likelihood.
double GainOfUnnamed(const Evidence& evidence, const WeightedModel& all, const WeightedModel& without) {
  if (all.view == without.view && all.set.members.size() == without.set.members.size()) return 0.0;
  return LogLikelihoodOf(evidence, all) - LogLikelihoodOf(evidence, without);
}

// Effects whose setting is none of the list's.
void AppendTuned(const Evidence& evidence, const RefittedSet& refitted, std::vector<Candidate>* between) {
  for (const SelectedEffect& effect : refitted.effects) {
    const EffectSpec& spec = effect.candidate.spec;
    const auto is_it = [&spec](const Candidate& listed) { return listed.spec.Path() == spec.Path(); };
    const std::vector<Candidate>& listed = evidence.list().candidates;  // those between too
    if (!IsNewSpring(spec) && std::none_of(listed.begin(), listed.end(), is_it)) between->push_back({spec});
  }
}

// All of them but a spring through a compliance of the set: about it, the compliance's column would hold its torque,
// and promise that the compliance does what the spring does.
std::vector<EffectSpec> AboutWhat(const Evidence& evidence, const RefittedSet& refitted) {
  std::vector<EffectSpec> specs;
  for (const SelectedEffect& effect : refitted.effects) {
    if (evidence.list().math[effect.explanation].needs == kNoExplanation) specs.push_back(effect.candidate.spec);
  }
  return specs;
}

// Whether what the linear model is off by, or what other settings than the listed ones add, is in doubt. Where what has
// no name says ten times more, it is not the linear model's fault.
bool Refutes(double error, double gain_of_unnamed) { return error > kInDoubt && error > kItsFault * gain_of_unnamed; }

// What has no name may be what a weight does through a compliance that is missing too, or by the sign of a torque: all
// columns are of the torque without the weight, until the model is linearized about it.
bool HidesProducts(const Evidence& evidence, const WeightedModel& named, double gain_of_unnamed) {
  const std::vector<EffectSpec>& about = evidence.about().effects;
  const bool is_about_weight =
      std::any_of(about.begin(), about.end(), [&](const auto& spec) { return IsWeight(evidence.robot(), spec); });
  const std::vector<int>& members = named.set.members;
  const bool has_weight =
      std::any_of(members.begin(), members.end(), [&](int m) { return evidence.list().math[m].is_weight; });
  return has_weight && !is_about_weight && gain_of_unnamed > kInDoubt;
}

// What the leading set's named effects lose with no weight among them, and the best other cause in their place.
double LossOfWeights(const Evidence& evidence, const WeightedModel& named) {
  const SetSearch search = evidence.SearchIn(named.view);
  const std::vector<Explanation>& list = evidence.list().math;
  const WeightedSet others = MembersThat(named.set, [&](int m) { return !list[m].is_weight; });
  if (others.members.size() == named.set.members.size()) return 0.0;
  const WeightedSet without = search.Evaluate(others.members, others.scales);
  double most = without.log_weight;
  const std::vector<double> added = search.Additions(without);
  for (size_t k = 0; k < added.size(); ++k) {
    if (!list[k].is_weight) most = std::max(most, added[k]);
  }
  return search.Evaluate(named.set.members, named.set.scales).log_weight - most;
}

}  // namespace

LeadingSet FindLeading(const SearchInput& input, const Evidence* before) {
  const ParameterSet& believed = input.baseline.estimate.parameters;
  // Between those of the list: moments, and settings of what was found.
  std::vector<Candidate> between = RefinedMoments(input.working, believed, ListCandidates(input.working, believed));
  LeadingSet found = WeighAndRefit(input, between, before, {});
  std::set<std::set<std::string>> known;  // effects about which the model was linearized
  for (int again = 0; found.is_named; ++again) {
    RefittedSet effects = WithoutUnnamed(input, found);
    if (effects.effects.empty() || !effects.IsUsable()) break;
    DecideHeldAnew(input, &effects);
    const double error = std::abs(LogFullOverLinear(*found.evidence, effects));
    const double gain = TuneSettings(*found.evidence, input.joint, &effects);
    VLOG(1) << "diagnosis: the linear model is off by " << error << " of the leading effects' log evidence";
    const double unnamed = GainOfUnnamed(*found.evidence, found.refitted.model, effects.model);
    found.is_refuted = Refutes(error, unnamed);
    if (!Refutes(std::max(error, gain), unnamed) && !HidesProducts(*found.evidence, effects.model, unnamed)) break;
    const bool holds_weight = LossOfWeights(*found.evidence, effects.model) > kWorthKeeping + error;
    const LinearizedAbout about{AboutWhat(*found.evidence, effects), effects.with_effects.estimate.parameters,
                                holds_weight};
    if (again == input.most_again || !known.insert(PathsOf(about)).second) break;
    AppendTuned(*found.evidence, effects, &between);
    if (input.progress) input.progress(WeighingAboutWhatWasFound());
    LeadingSet anew = WeighAndRefit(input, between, found.evidence.get(), about);
    if (!anew.is_named || !anew.refitted.IsUsable()) break;  // "nothing" is far from here: no linearization reaches it
    found = std::move(anew);
  }
  return found;
}

}  // namespace sagitta
