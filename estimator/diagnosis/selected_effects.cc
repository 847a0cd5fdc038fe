#include "estimator/diagnosis/selected_effects.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "estimator/diagnosis/refit_order.h"
#include "estimator/diagnosis/setting_values.h"
#include "estimator/explanations/compensator_shapes.h"
#include "estimator/explanations/drivers.h"
#include "estimator/statistics/distributions.h"
#include "models/effects/learnt_deviation.h"

namespace sagitta {
namespace {

constexpr size_t kMostSprings = 8;  // of 144 shapes: neighbours in ratio and in direction
constexpr size_t kMostGroups = 5;   // FORMATS section 6

// By which a spring's joint gives way, rad/(N m): what is believed, or what the set's compliance says; typical where
// that is less than nothing.
double ComplianceIn(const Evidence& evidence, const WeightedModel& model, int spring) {
  const ExplanationList& list = evidence.list();
  const int compliance = list.math[spring].needs;
  if (compliance == kNoExplanation) return ComplianceOf(evidence.parameters(), list.SpecOf(spring).target);
  const double typical = evidence.columns().TypicalOf(list.math[compliance].group.columns[0]);
  const double found = typical * evidence.ValuesOfMember(model, compliance).values[0];
  return found > 0.0 ? found : typical;
}

// A spring directly after the compliance that it acts through.
void PutTogether(const Evidence& evidence, std::vector<SelectedEffect>* effects) {
  const std::vector<Explanation>& list = evidence.list().math;
  for (size_t k = 1; k < effects->size(); ++k) {
    const auto spring = effects->begin() + static_cast<long>(k);
    const auto own = std::find_if(effects->begin(), spring, [&](const SelectedEffect& effect) {
      return effect.explanation == list[spring->explanation].needs;
    });
    if (own != spring) std::rotate(own + 1, spring, spring + 1);
  }
}

// A spring moves no joint that is stiff, and from there no step is seen to help.
void StartCompliances(const Evidence& evidence, const WeightedModel& model, std::vector<SelectedEffect>* effects) {
  const std::vector<Explanation>& list = evidence.list().math;
  for (const SelectedEffect& spring : *effects) {
    for (SelectedEffect& own : *effects) {
      if (own.explanation != list[spring.explanation].needs) continue;
      own.candidate.spec.values = {ComplianceIn(evidence, model, spring.explanation)};
      own.loss = std::max(own.loss, spring.loss);
    }
  }
}

// The spring whose torque moves the joint as the set's columns with their values do.
EffectSpec SeededSpring(const Evidence& evidence, const WeightedModel& model, int member,
                        const DiagnosedModel& lacking) {
  const CalibrationProblem& problem = *lacking.problem;
  EffectSpec spring = evidence.list().start[member];
  const ColumnGroup& group = evidence.list().math[member].group;
  const Eigen::VectorXd coefficients = group.mixing * evidence.ValuesOfMember(model, member).values;
  const Eigen::VectorXd turned = kTypicalTurn * evidence.columns().FunctionOf(group.columns) * coefficients;
  const int joint = problem.robot().chain.FindJoint(spring.target);
  const Eigen::VectorXd angles = JointValues(problem, joint);
  std::vector<int> shots;
  for (const int i : problem.CalibrationObservations()) shots.push_back(problem.data().observations[i].shot);
  SeedSpring(angles(shots), turned(shots) / ComplianceIn(evidence, model, member), &spring);
  return spring;
}

// Springs of the next most probable shapes in an effect's place, best first.
std::vector<EffectSpec> OtherSprings(const Evidence& evidence, const WeightedModel& model, const SelectedEffect& effect,
                                     const DiagnosedModel& lacking) {
  std::vector<EffectSpec> springs;
  for (const int shape : OthersOfItsName(evidence, model, effect.explanation)) {
    if (springs.size() == kMostSprings) break;
    WeightedModel with = model;
    std::replace(with.set.members.begin(), with.set.members.end(), effect.explanation, shape);
    springs.push_back(SeededSpring(evidence, with, shape, lacking));
  }
  return springs;
}

bool IsRateAlone(const Evidence& evidence, const std::vector<int>& columns) {
  return columns.size() == 1 && evidence.columns().Has(columns[0]) &&
         evidence.columns().Name(columns[0]) == NameOf(CompensatorPart::kKc);
}

DiagnosedModel LackingGiven(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& working,
                            const DiagnosedModel& baseline, const JointOptions& joint) {
  const bool is_other = !evidence.ViewOf(model).IsStated();
  if (!is_other && !evidence.IsSigmaOpen(model)) return baseline;
  DiagnosedModel refit = RefitFully(WithNoiseOf(evidence, model, working), baseline.estimate, joint);
  return IsUsable(refit.estimate.status) ? refit : baseline;
}

// The set's effects of the catalogue.
WeightedModel NamedOf(const RefittedSet& refitted) {
  WeightedModel named = refitted.model;
  named.set.members.clear();
  named.set.scales.clear();
  for (const SelectedEffect& effect : refitted.effects) named.set.members.push_back(effect.explanation);
  std::sort(named.set.members.begin(), named.set.members.end());
  for (const int member : named.set.members)
    named.set.scales.push_back(refitted.model.set.scales[refitted.model.PlaceOf(member)]);
  return named;
}

// By how much more of log likelihood the set's named effects have than nothing, to first order.
double LinearGain(const Evidence& evidence, const RefittedSet& refitted) {
  const WeightedModel named = NamedOf(refitted);
  WeightedModel nothing = named;
  nothing.set.members.clear();
  nothing.set.scales.clear();
  const ResidualLikelihood likelihood = evidence.LikelihoodOf(named.view);
  return likelihood.Log(ResidualAtBest(evidence, named)) - likelihood.Log(ResidualAtBest(evidence, nothing));
}

// What the refit keeps of its linear evidence; lowest: it has no optimum.
double Kept(const Evidence& evidence, const RefittedSet& refitted) {
  return refitted.IsUsable() ? LogFullOverLinear(evidence, refitted) : -std::numeric_limits<double>::infinity();
}

// A spring's shape is a narrow valley, or one without an end where the data hardly determine it, and not the only one:
// near the start's shape, and near others, the refit may find its floor. The first that keeps the linear evidence is
// used, else the best; where that has lost more than half of what the set is evident by, the spring was not found.
void TryOtherSprings(const Evidence& evidence, const JointOptions& joint, RefittedSet* refitted) {
  RefittedSet best = *refitted;
  double kept = Kept(evidence, best);
  for (size_t k = 0; k < refitted->effects.size(); ++k) {
    SelectedEffect& effect = refitted->effects[k];
    if (!IsNewSpring(effect.candidate.spec)) continue;
    std::vector<EffectSpec> springs = OtherSprings(evidence, refitted->model, effect, refitted->lacking);
    springs.insert(springs.begin(), effect.candidate.spec);
    for (const EffectSpec& spring : springs) {
      if (kept >= -kInDoubt) break;
      effect.candidate.spec = spring;
      effect.candidate.keeps_shape = true;
      refitted->with_effects = Extend(refitted->lacking, CandidatesOf(refitted->effects), joint);
      const double here = Kept(evidence, *refitted);
      if (here > kept) best = *refitted, kept = here;
    }
    *refitted = best;
  }
  const double gain = LinearGain(evidence, *refitted);
  refitted->is_found = gain < kInDoubt || kept > -0.5 * gain;
}

// Where the sign of a torque leaves the set without an optimum: the sharpest that has one.
void RoundSigns(const Evidence& evidence, const JointOptions& joint, RefittedSet* refitted) {
  for (size_t k = 0; k < refitted->effects.size(); ++k) {
    RefittedSet sharper = *refitted;
    for (const EffectSpec& rounded : Rounded(evidence.robot(), refitted->effects[k].candidate.spec)) {
      ChangeTo(rounded, &sharper.effects[k].candidate);
      sharper.with_effects = Extend(sharper.lacking, CandidatesOf(sharper.effects), joint);
      const double better = Kept(evidence, sharper) - Kept(evidence, *refitted);
      if (!sharper.IsUsable() || better <= 0.0) break;
      *refitted = sharper;
    }
  }
}

bool HasNewSpring(const RefittedSet& refitted) {
  return std::any_of(refitted.effects.begin(), refitted.effects.end(),
                     [](const SelectedEffect& effect) { return IsNewSpring(effect.candidate.spec); });
}

// Whether a coordinate is a parameter of one of them.
bool IsOfAny(const std::vector<SelectedEffect>& effects, const Coordinate& coordinate) {
  return std::any_of(effects.begin(), effects.end(), [&coordinate](const SelectedEffect& effect) {
    return IsParameterOf(effect.candidate.spec, coordinate.name);
  });
}

// What priors of the effects have of the refit's chi-square.
double SquareOfPriors(const RefittedSet& refitted) {
  const ParameterSet& parameters = refitted.with_effects.estimate.parameters;
  double sum = 0.0;
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    const Coordinate& coordinate = parameters.coordinates()[i];
    const int believed = refitted.lacking.estimate.parameters.FindCoordinate(coordinate.name);
    const bool is_new = believed < 0 || !refitted.lacking.estimate.parameters.coordinates()[believed].estimated();
    const bool has_own = coordinate.has_prior() && coordinate.estimated() && is_new;
    if (has_own && IsOfAny(refitted.effects, coordinate))
      sum += std::pow(PriorResidual(coordinate, parameters.Value(i)), 2);
  }
  return sum;
}

// Not a number where the set holds what has no name.
double LogCorrection(const Evidence& evidence, const RefittedSet& refitted) {
  if (!refitted.IsUsable()) return -std::numeric_limits<double>::infinity();
  const bool has_unnamed =
      refitted.effects.size() != refitted.model.set.members.size() || evidence.FollowsPose(refitted.model);
  if (has_unnamed) return std::numeric_limits<double>::quiet_NaN();
  double log = LogFullOverLinear(evidence, refitted);
  for (const SelectedEffect& effect : refitted.effects) {
    if (IsNewSpring(effect.candidate.spec)) log += LogPriorOfFitted(evidence, refitted, effect);
  }
  return log;
}

// Effects of the catalogue that `model` holds and the other does not.
std::vector<EffectSpec> Instead(const Evidence& evidence, const WeightedModel& model, const WeightedModel& other) {
  const ExplanationList& list = evidence.list();
  std::vector<EffectSpec> own;
  for (const int member : model.set.members) {
    if (list.IsUnnamed(member) || model.HasPiece(member)) continue;
    const bool is_common = std::any_of(other.set.members.begin(), other.set.members.end(),
                                       [&](int m) { return list.name[m] == list.name[member]; });
    if (!is_common) own.push_back(list.SpecOf(member));
  }
  return own;
}

std::vector<RivalSet> RivalsOf(const WeightedModel& leading, const std::vector<RefittedSet>& refitted,
                               const Evidence& evidence, const Posterior& posterior) {
  std::vector<RivalSet> rivals;
  for (const RefittedSet& each : refitted) {
    if (!each.IsUsable() || Instead(evidence, leading, each.model).empty()) continue;
    const auto set = std::find_if(posterior.sets.begin(), posterior.sets.end(), [&](const NameSet& own) {
      const WeightedModel& best = evidence.models()[own.best];
      return best.view == each.model.view && best.set.members == each.model.set.members;
    });
    if (set == posterior.sets.end()) continue;
    rivals.push_back({set->probability, Instead(evidence, each.model, leading), each.with_effects.estimate.parameters});
  }
  return rivals;
}

}  // namespace

std::vector<SelectedEffect> SelectedEffectsOf(const Evidence& evidence, const WeightedModel& model,
                                              const DiagnosedModel& lacking) {
  const ExplanationList& list = evidence.list();
  const std::vector<double> losses = evidence.SearchIn(model.view).LossesOf(model.set);
  const Members members = evidence.MembersOf(model);
  // What determines an effect only by what is usual of another one is not determined.
  const std::vector<double> widest(model.set.members.size(), kWidestScale);
  const Members given_hardly_anything = evidence.MembersOf(model, &widest);
  std::vector<SelectedEffect> effects;
  for (size_t k = 0; k < model.set.members.size(); ++k) {
    const int member = model.set.members[k];
    if (list.IsUnnamed(member) || model.HasPiece(member)) continue;
    SelectedEffect effect;
    effect.explanation = member;
    effect.candidate = list.candidates[list.candidate[member]];
    if (IsNewSpring(list.start[member])) {
      effect.candidate.spec = SeededSpring(evidence, model, member, lacking);
    }
    effect.candidate.rate_alone = IsRateAlone(evidence, list.math[member].group.columns);
    effect.fit = FitOf(members.Of(k));
    MarkUndetermined(evidence, member, given_hardly_anything.Of(k), &effect.candidate);
    effect.candidate.prior_scale = std::max(kLargestUsual, model.set.scales[k]);
    effect.loss = losses[k];
    effects.push_back(std::move(effect));
  }
  StartCompliances(evidence, model, &effects);
  std::stable_sort(effects.begin(), effects.end(), [](const auto& a, const auto& b) { return a.loss > b.loss; });
  PutTogether(evidence, &effects);
  return effects;
}

std::vector<Candidate> CandidatesOf(const std::vector<SelectedEffect>& effects) {
  std::vector<Candidate> candidates;
  for (const SelectedEffect& effect : effects) candidates.push_back(effect.candidate);
  return candidates;
}

std::vector<int> ExplanationsOf(const std::vector<SelectedEffect>& effects) {
  std::vector<int> explanations;
  for (const SelectedEffect& effect : effects) explanations.push_back(effect.explanation);
  return explanations;
}

WeightedModel Alone(const Evidence& evidence, int view, int explanation) {
  const int needed = evidence.list().math[explanation].needs;
  std::vector<int> members = {explanation};
  if (needed != kNoExplanation) members = EachOnce(members, {needed});
  const std::vector<double> scales(members.size(), 1.0);
  return {view, {members, scales, 0.0, 0.0}, 0.0, 0.0};
}

RefittedSet RefitSet(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& working,
                     const DiagnosedModel& baseline, const JointOptions& joint) {
  RefittedSet refitted;
  refitted.model = model;
  refitted.lacking = LackingGiven(evidence, model, working, baseline, joint);
  refitted.effects = SelectedEffectsOf(evidence, model, refitted.lacking);
  refitted.with_effects = Extend(refitted.lacking, CandidatesOf(refitted.effects), joint);
  if (!refitted.IsUsable()) RoundSigns(evidence, joint, &refitted);
  if (HasNewSpring(refitted) && Kept(evidence, refitted) < -kInDoubt) TryOtherSprings(evidence, joint, &refitted);
  return refitted;
}

RefittedSet RefitLeading(const CalibrationProblem& working, const DiagnosedModel& baseline, const JointOptions& joint,
                         double gate, Evidence* evidence, Posterior* posterior, std::vector<RivalSet>* rivals) {
  rivals->clear();
  std::vector<RefittedSet> refitted;
  RefitOrder order(*posterior);
  bool any_usable = false;
  for (size_t s = posterior->Leading(gate); s < posterior->sets.size(); s = order.Next()) {
    const WeightedModel& best = evidence->models()[posterior->sets[s].best];
    refitted.push_back(RefitSet(*evidence, best, working, baseline, joint));
    any_usable |= refitted.back().IsUsable();
    const double correction = LogCorrection(*evidence, refitted.back());
    VLOG(1) << "diagnosis: refit of set " << s << " (" << posterior->sets[s].probability
            << ") moves its log evidence by " << correction << "; " << refitted.back().with_effects.estimate.message;
    order.Add(s, correction);
  }
  if (!any_usable) return refitted[0];
  std::vector<double> corrections(evidence->models().size(), 0.0);
  for (size_t s = 0; s < posterior->sets.size(); ++s) {
    for (const int m : posterior->sets[s].models) corrections[m] = order.CorrectionOf(s);
  }
  evidence->Correct(corrections);
  *posterior = PosteriorOf(*evidence, evidence->models());
  if (posterior->sets.empty()) return refitted[0];
  const WeightedModel& leading = evidence->models()[posterior->sets[posterior->Leading(gate)].best];
  *rivals = RivalsOf(leading, refitted, *evidence, *posterior);
  for (RefittedSet& each : refitted) {
    const bool is_same = each.model.set.members == leading.set.members && each.model.pieces == leading.pieces;
    if (each.model.view == leading.view && is_same) return each;
  }
  return RefitSet(*evidence, leading, working, baseline, joint);
}

double LogPriorOfFitted(const Evidence& evidence, const RefittedSet& refitted, const SelectedEffect& spring) {
  const CalibrationProblem& problem = *refitted.lacking.problem;
  const ParameterSet& parameters = refitted.with_effects.estimate.parameters;
  const std::string& joint = spring.candidate.spec.target;
  const Eigen::VectorXd angles = JointValues(problem, problem.robot().chain.FindJoint(joint));
  const double share = evidence.list().springs.at(joint).Of(SpringTorques(parameters, angles(FittedShots(problem))));
  return LogPriorOfSpring(parameters) + std::log(share / evidence.list().place[spring.explanation].weight);
}

double LogOfFull(const Evidence& evidence, const RefittedSet& refitted) {
  const double unit = UnitOfRows(evidence, refitted.model);
  return evidence.LikelihoodOf(NamedOf(refitted).view)
      .Log(unit * (refitted.with_effects.estimate.chi2 - SquareOfPriors(refitted)));
}

double LogFullOverLinear(const Evidence& evidence, const RefittedSet& refitted) {
  if (evidence.FollowsPose(refitted.model)) return 0.0;  // the full model has no deviation that follows the pose
  const WeightedModel named = NamedOf(refitted);
  return LogOfFull(evidence, refitted) - evidence.LikelihoodOf(named.view).Log(ResidualAtBest(evidence, named));
}

double CorrectedP(double reduction, int parameters, double scatter, int dof, bool is_sigma_stated, int tests) {
  const double m = std::max(1, parameters);
  const bool is_known = (is_sigma_stated && scatter <= 1.0) || dof <= 0;
  const double p = is_known ? ChiSquareSurvival(reduction, m) : FSurvival(reduction / (m * scatter), m, dof);
  return std::min(1.0, tests * p);
}

std::vector<ScreenedCandidate> Screen(const Evidence& evidence, const DiagnosedModel& baseline) {
  const ExplanationList& list = evidence.list();
  const ProjectedNormal& normal = evidence.NormalOf(0);
  const ResidualLikelihood likelihood = evidence.LikelihoodOf(0);
  const int tests = list.NumNamed();
  std::map<std::string, ScreenedCandidate> best;  // by name
  for (size_t k = 0; k < list.math.size(); ++k) {
    if (list.IsUnnamed(static_cast<int>(k))) continue;
    const GivenOthers alone = GivenNothing(normal, list.math[k].group);
    const double log_evidence = AverageGain(likelihood, alone);
    const auto entry = best.find(list.name[k]);
    if (entry != best.end() && entry->second.log_evidence >= log_evidence) continue;
    const MemberFit fit = FitOf(alone);
    if (fit.parameters == 0) continue;
    best[list.name[k]] = {list.start[k], static_cast<int>(k), fit.reduction, fit.parameters, 1.0, log_evidence, {}};
  }
  std::vector<ScreenedCandidate> screened;
  const double left = baseline.estimate.chi2 / std::max(1, baseline.estimate.dof);
  for (auto& [name, entry] : best) {
    const int dof = baseline.estimate.dof - entry.parameters;
    entry.corrected_p = CorrectedP(entry.reduction, entry.parameters, left, dof, evidence.IsSigmaStated(), tests);
    screened.push_back(std::move(entry));
  }
  std::stable_sort(screened.begin(), screened.end(),
                   [](const auto& a, const auto& b) { return a.log_evidence > b.log_evidence; });
  return screened;
}

ParameterSet AlignedAs(const ParameterSet& nominal, const ParameterSet& extended) {
  ParameterSet aligned = extended;
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(aligned.num_coordinates());
  for (int i = 0; i < aligned.num_coordinates(); ++i) {
    const Coordinate& coordinate = aligned.coordinates()[i];
    if (nominal.FindCoordinate(coordinate.name) < 0 && !IsSpringShape(coordinate)) delta[i] = -aligned.Value(i);
  }
  aligned.Plus(delta);
  aligned.CopyByName(nominal);
  return aligned;
}

bool IsEstimated(const EffectSpec& spec, const Estimate& estimate) {
  return std::any_of(estimate.table.begin(), estimate.table.end(),
                     [&](const ParameterEstimate& row) { return row.free && IsParameterOf(spec, row.name); });
}

double WaldP(const EffectSpec& spec, const Estimate& estimate) {
  if (!IsEstimated(spec, estimate)) return 1.0;
  if (IsGravityCompensator(spec)) return 0.0;  // its torque may be certain where its rate is a trade with its shape
  std::vector<int> own;
  for (size_t c = 0; c < estimate.estimated.size(); ++c) {
    if (IsParameterOf(spec, estimate.parameters.coordinates()[estimate.estimated[c]].name))
      own.push_back(static_cast<int>(c));
  }
  Eigen::VectorXd values(static_cast<long>(own.size()));
  for (size_t k = 0; k < own.size(); ++k) {
    values[k] = estimate.parameters.Value(estimate.estimated[own[k]]);
  }
  const Eigen::MatrixXd covariance = estimate.covariance(own, own);
  const double square = values.dot(covariance.ldlt().solve(values));
  return ChiSquareSurvival(square, static_cast<double>(own.size()));
}

std::vector<EffectGroup> GroupEffects(const std::vector<FoundEffect>& effects, const DiagnosedModel& lacking,
                                      const DiagnosedModel& baseline, const DiagnosedModel& final, double floor,
                                      const JointOptions& joint) {
  std::vector<EffectGroup> groups;
  for (size_t k = 0; k < effects.size(); ++k) {
    const std::string& effect = effects[k].candidate.spec.effect;
    auto own =
        std::find_if(groups.begin(), groups.end(), [&](const EffectGroup& group) { return group.effect == effect; });
    if (own == groups.end() && groups.size() == kMostGroups) {
      own = groups.end() - 1;
      own->effect = "others";
    }
    if (own == groups.end()) own = groups.insert(groups.end(), EffectGroup{effect, {}, kNotKnown});
    own->effects.push_back(static_cast<int>(k));
  }
  if (baseline.estimate.validation.observations == 0) return groups;
  const auto beyond_floor = [&](const DiagnosedModel& model) {
    const HoldoutSums sums = SumHoldout(model);
    return std::max(0.0, sums.squares.sum() - floor * floor * sums.coordinates.sum());
  };
  const double all = beyond_floor(baseline);
  double last = all;
  DiagnosedModel so_far = lacking;
  std::vector<Candidate> added;  // beyond those of `so_far`
  for (size_t g = 0; g < groups.size() && all > 0.0; ++g) {
    for (const int k : groups[g].effects) added.push_back(effects[k].candidate);
    const DiagnosedModel here = g + 1 == groups.size() ? final : Extend(so_far, added, joint);
    if (!IsUsable(here.estimate.status)) continue;
    const double now = beyond_floor(here);
    groups[g].share_of_gap = (last - now) / all;
    last = now;
    so_far = here;
    added.clear();
  }
  return groups;
}

}  // namespace sagitta
