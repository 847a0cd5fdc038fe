#include "estimator/diagnosis/selected_effects.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "estimator/diagnosis/compensator_shapes.h"
#include "estimator/statistics/distributions.h"
#include "models/effects/learnt_deviation.h"

namespace sagitta {
namespace {

constexpr double kWorseBeyondChance = 0.01;
constexpr double kBetterBeyondChance = 0.05;  // as of its interval: neither may say that it is chance
constexpr size_t kMostSprings = 8;            // of 144 shapes: neighbours in ratio and in direction
constexpr size_t kMostGroups = 5;             // FORMATS section 6

// The spring whose torque moves the joint as the set's columns with their values do.
EffectSpec SeededSpring(const Evidence& evidence, const WeightedModel& model, int member,
                        const DiagnosedModel& lacking) {
  const CalibrationProblem& problem = *lacking.problem;
  EffectSpec spring = evidence.list().start[member];
  const ColumnGroup& group = evidence.list().math[member].group;
  const Eigen::VectorXd coefficients = group.mixing * evidence.ValuesOfMember(model, member).values;
  const Eigen::VectorXd turned = kTypicalTurn * evidence.columns().FunctionOf(group.columns) * coefficients;
  const int joint = problem.robot().chain.FindJoint(spring.target);
  std::vector<double> angles, torques;
  const double compliance = ComplianceOf(lacking.estimate.parameters, spring.target);
  for (const int i : problem.CalibrationObservations()) {
    const int shot = problem.data().observations[i].shot;
    angles.push_back(problem.shot_inputs()[shot].conditions.q[joint]);
    torques.push_back(turned[shot] / compliance);
  }
  const auto vector = [](const std::vector<double>& list) {
    return Eigen::Map<const Eigen::VectorXd>(list.data(), static_cast<long>(list.size()));
  };
  SeedSpring(vector(angles), vector(torques), &spring);
  return spring;
}

// Squared untouched residuals per configuration, m^2; 0 of the others.
Eigen::VectorXd HoldoutSquares(const DiagnosedModel& model, std::vector<int>* counts) {
  const Measurements& data = model.problem->data();
  const std::vector<int> held_out = data.PointsAmong(model.problem->ValidationObservations());
  const Eigen::Matrix3Xd misfit = HoldoutMisfit(model);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(static_cast<long>(data.configurations.size()));
  counts->assign(data.configurations.size(), 0);
  for (size_t k = 0; k < held_out.size(); ++k) {
    const int c = data.shots[data.observations[held_out[k]].shot].configuration;
    squares[c] += misfit.col(static_cast<long>(k)).squaredNorm();
    (*counts)[c] += 3;
  }
  return squares;
}

}  // namespace

std::vector<SelectedEffect> SelectedEffectsOf(const Evidence& evidence, const WeightedModel& model,
                                              const DiagnosedModel& lacking) {
  const ExplanationList& list = evidence.list();
  const std::vector<double> losses = evidence.SearchIn(model.view).LossesOf(model.set);
  const std::vector<GivenOthers> given = EachGivenOthers(evidence, model);
  std::vector<SelectedEffect> effects;
  for (size_t k = 0; k < model.set.members.size(); ++k) {
    const int member = model.set.members[k];
    if (list.IsUnnamed(member) || model.HasPiece(member)) continue;
    SelectedEffect effect;
    effect.explanation = member;
    effect.candidate = list.candidates[list.candidate[member]];
    if (IsGravityCompensator(effect.candidate.spec)) {
      effect.candidate.spec = SeededSpring(evidence, model, member, lacking);
    }
    effect.fit = FitOf(evidence, member, given[k]);
    effect.candidate.poorly_determined = effect.fit.poorly_determined;
    effect.candidate.loose = effect.fit.loose;
    effect.loss = losses[k];
    effects.push_back(std::move(effect));
  }
  std::stable_sort(effects.begin(), effects.end(), [](const auto& a, const auto& b) { return a.loss > b.loss; });
  return effects;
}

std::vector<EffectSpec> OtherSprings(const Evidence& evidence, const WeightedModel& model, const SelectedEffect& effect,
                                     const DiagnosedModel& lacking) {
  std::vector<int> shapes;
  for (const NamedProbability& shape : ShapesInPlaceOf(evidence, model, effect.explanation)) {
    if (shape.explanation != effect.explanation) shapes.push_back(shape.explanation);
  }
  shapes.resize(std::min(shapes.size(), kMostSprings));
  std::vector<EffectSpec> springs;
  for (const int shape : shapes) {
    WeightedModel with = model;
    std::replace(with.set.members.begin(), with.set.members.end(), effect.explanation, shape);
    springs.push_back(SeededSpring(evidence, with, shape, lacking));
  }
  return springs;
}

std::vector<Candidate> CandidatesOf(const std::vector<SelectedEffect>& effects) {
  std::vector<Candidate> candidates;
  for (const SelectedEffect& effect : effects) candidates.push_back(effect.candidate);
  return candidates;
}

double CorrectedP(double reduction, int parameters, double scatter, int dof, bool is_sigma_stated, int tests) {
  const double m = std::max(1, parameters);
  const bool is_known = (is_sigma_stated && scatter <= 1.0) || dof <= 0;
  const double p = is_known ? ChiSquareSurvival(reduction, m) : FSurvival(reduction / (m * scatter), m, dof);
  return std::min(1.0, tests * p);
}

ParameterSet AlignedWith(const std::vector<SelectedEffect>& effects, const ParameterSet& extended,
                         const ParameterSet& nominal) {
  ParameterSet aligned = extended;
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(aligned.num_coordinates());
  for (int i = 0; i < aligned.num_coordinates(); ++i) {
    const Coordinate& coordinate = aligned.coordinates()[i];
    const bool is_shape =
        coordinate.kind == CoordinateKind::kCompensator && coordinate.compensator_part != CompensatorPart::kKc;
    const bool is_new = std::any_of(effects.begin(), effects.end(), [&](const SelectedEffect& effect) {
      return IsParameterOf(effect.candidate.spec, coordinate.name);
    });
    if (is_new && !is_shape) delta[i] = -aligned.Value(i);
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
  if (IsGravityCompensator(spec)) return 0.0;  // no values of it are those of no effect
  std::vector<int> own;
  for (size_t c = 0; c < estimate.estimated.size(); ++c) {
    if (IsParameterOf(spec, estimate.parameters.coordinates()[estimate.estimated[c]].name))
      own.push_back(static_cast<int>(c));
  }
  Eigen::VectorXd values(static_cast<long>(own.size()));
  for (size_t k = 0; k < own.size(); ++k) {
    values[static_cast<long>(k)] = estimate.parameters.Value(estimate.estimated[static_cast<size_t>(own[k])]);
  }
  const Eigen::MatrixXd covariance = estimate.covariance(own, own);
  const double square = values.dot(covariance.ldlt().solve(values));
  return ChiSquareSurvival(square, static_cast<double>(own.size()));
}

int CountHeldOut(const DiagnosedModel& model) {
  const Measurements& data = model.problem->data();
  std::set<int> configurations;
  for (const int k : data.PointsAmong(model.problem->ValidationObservations())) {
    configurations.insert(data.shots[data.observations[k].shot].configuration);
  }
  return static_cast<int>(configurations.size());
}

double HoldoutGain(const DiagnosedModel& before, const DiagnosedModel& after) {
  std::vector<int> counts;
  const Eigen::VectorXd gains = HoldoutSquares(before, &counts) - HoldoutSquares(after, &counts);
  const double scatter = gains.norm();
  return scatter > 0.0 ? gains.sum() / scatter : 0.0;
}

bool IsBeyondChance(double gain) { return gain > NormalQuantile(1.0 - kBetterBeyondChance); }

bool MakesHoldoutWorse(const DiagnosedModel& before, const DiagnosedModel& after) {
  std::vector<int> counts;
  const Eigen::VectorXd now = HoldoutSquares(after, &counts), then = HoldoutSquares(before, &counts);
  const int held_out = CountHeldOut(after);
  if (held_out < kFewHeldOut) return false;
  const double limit = NormalQuantile(1.0 - kWorseBeyondChance);
  if ((now - then).sum() > limit * (now - then).norm()) return true;
  // A few configurations that are far off say nothing by their own scatter. Root mean squares of n points scatter by
  // 1 / sqrt(6 n) of themselves, and two of the same points by less.
  const double growth = 1.0 + limit / std::sqrt(6.0 * static_cast<double>(held_out));
  return now.sum() > growth * growth * then.sum();
}

bool IsFarFromFloor(const DiagnosedModel& model, bool is_sigma_stated, double significance) {
  if (!is_sigma_stated || model.estimate.validation.observations == 0) return false;
  const int held_out = CountHeldOut(model);
  if (held_out < kFewHeldOut) return false;
  // Rows of one configuration may share what they deviate by: three coordinates each count.
  const double floor = model.estimate.noise_floor, rms = model.estimate.validation.rms;
  return floor > 0.0 && ChiSquareSurvival(3.0 * static_cast<double>(held_out) * rms * rms / (floor * floor),
                                          3.0 * static_cast<double>(held_out)) < 0.1 * significance;
}

std::vector<EffectGroup> GroupEffects(const std::vector<FoundEffect>& effects, const DiagnosedModel& lacking,
                                      const DiagnosedModel& baseline, const DiagnosedModel& final,
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
  std::vector<int> counts;
  const double floor = final.estimate.noise_floor;
  const auto beyond_floor = [&](const DiagnosedModel& model) {
    const double sum = HoldoutSquares(model, &counts).sum();
    return std::max(0.0, sum - floor * floor * std::accumulate(counts.begin(), counts.end(), 0));
  };
  const double all = beyond_floor(baseline);
  double last = all;
  DiagnosedModel so_far = lacking;
  std::vector<Candidate> added;  // beyond those of `so_far`
  for (size_t g = 0; g < groups.size() && all > 0.0; ++g) {
    for (const int k : groups[g].effects) added.push_back(effects[static_cast<size_t>(k)].candidate);
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
