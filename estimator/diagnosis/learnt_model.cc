#include "estimator/diagnosis/learnt_model.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "estimator/diagnosis/driver_functions.h"
#include "estimator/diagnosis/selected_effects.h"
#include "estimator/diagnosis/unnamed_list.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"

namespace sagitta {
namespace {

constexpr size_t kMostTried = 12;  // functions: each costs a refit

Candidate CandidateOf(const EffectSpec& spec, const Robot& robot, double scale) {
  Candidate candidate{spec};
  for (const EffectParameter& parameter : FindEffect(spec.effect)->parameters(robot, spec)) {
    candidate.loose.push_back(spec.Path() + "/" + parameter.name);
  }
  candidate.prior_scale = scale;
  return candidate;
}

// Between neighbouring values of the driver on fitted shots, in the unit of `from` and `to`.
double LargestGap(const Driver& driver, const CalibrationProblem& problem) {
  if (driver.of_shot.size() == 0) return 0.0;
  const Eigen::VectorXd fitted = driver.of_shot(FittedShots(problem));
  double largest = 0.0;
  for (const Gap& gap : Gaps(fitted, static_cast<int>(fitted.size()) + 1)) {
    largest = std::max(largest, gap.second - gap.first);
  }
  return largest;
}

// A spring's shape is a narrow valley, and flat beside smooth functions: it stays where it was found.
DiagnosedModel WithSpringsAsTheyAre(const DiagnosedModel& model) {
  DiagnosedModel held = model;
  held.problem = std::make_shared<CalibrationProblem>(*model.problem);
  for (int i = 0; i < held.problem->parameters.num_coordinates(); ++i) {
    Coordinate& coordinate = held.problem->parameters.coordinate(i);
    const bool is_spring = coordinate.kind == CoordinateKind::kCompensator;
    if (is_spring && coordinate.compensator_part != CompensatorPart::kKc) coordinate.free = false;
  }
  return held;
}

class Learner {
 public:
  Learner(const Evidence& evidence, const WeightedModel& leading, const DiagnosedModel& final,
          const JointOptions& joint)
      : evidence_(evidence),
        search_(evidence.SearchIn(leading.view)),
        set_(leading.set),
        final_(WithSpringsAsTheyAre(final)),
        with_(final_),
        joint_(joint) {
    if (leading.pieces.empty()) return;
    WeightedModel as_effects = leading;
    as_effects.pieces.clear();
    for (const SelectedEffect& effect : SelectedEffectsOf(evidence, as_effects, final)) {
      if (leading.HasPiece(effect.explanation)) pieces_.emplace(effect.explanation, effect.candidate);
    }
  }

  std::optional<LearntModel> Run(const DiagnosedModel& baseline) {
    WeightedSet kept;
    for (size_t k = 0; k < set_.members.size(); ++k) {
      const int member = set_.members[k];
      if (evidence_.list().IsUnnamed(member) && !Take(member, set_.scales[k])) continue;
      if (pieces_.count(member) > 0) continue;
      kept.members.push_back(member);
      kept.scales.push_back(set_.scales[k]);
    }
    set_ = search_.Evaluate(kept.members, kept.scales);
    while (TakeNext()) continue;
    for (const auto& [member, piece] : pieces_) TakeAll({piece});
    if (added_.empty()) return std::nullopt;
    LearntModel learnt;
    const ParameterSet& start = with_.estimate.parameters;
    learnt.model = JudgeFully(with_.problem, start, start, joint_);
    if (!IsUsable(learnt.model.estimate.status) || IsNoBetter(learnt.model, final_)) return std::nullopt;
    learnt.gap = JudgeGap(baseline, learnt.model, evidence_.IsSigmaStated());
    for (const Candidate& candidate : added_) learnt.functions.push_back(WithValues(candidate.spec, learnt.model));
    return learnt;
  }

 private:
  // On untouched rows; without any it may be.
  static bool IsNoBetter(const DiagnosedModel& with, const DiagnosedModel& without) {
    return HoldoutRms(with) >= HoldoutRms(without);
  }

  // Adds it to the model where that does untouched rows good and the model has it not. False: it is not taken.
  bool Take(int explanation, double scale) {
    passed_.insert(evidence_.list().name[explanation]);
    std::vector<Candidate> fresh;
    const UnnamedFunction& function = evidence_.list().functions[evidence_.list().unnamed[explanation]];
    const double gap = LargestGap(function.driver, *final_.problem);
    for (const EffectSpec& spec : function.effects) {
      for (const auto& [level, size] : LevelsOf(spec, scale, gap)) {
        if (!Has(level)) fresh.push_back(CandidateOf(level, final_.problem->robot(), size));
      }
    }
    return !fresh.empty() && TakeAll(fresh);
  }

  bool TakeAll(const std::vector<Candidate>& fresh) {
    DiagnosedModel with = PredictingHoldout(Extend(with_, fresh, joint_));
    if (!IsUsable(with.estimate.status) || IsNoBetter(with, with_)) return false;
    with_ = std::move(with);
    added_.insert(added_.end(), fresh.begin(), fresh.end());
    return true;
  }

  bool Has(const EffectSpec& spec) const {
    return std::any_of(added_.begin(), added_.end(),
                       [&](const Candidate& candidate) { return candidate.spec.Path() == spec.Path(); });
  }

  // The best that is left, by the evidence; what does no good is passed over. False: none stands out.
  bool TakeNext() {
    std::vector<double> scales;
    const std::vector<double> weights = search_.Additions(set_, &scales);
    while (passed_.size() < kMostTried) {
      int best = -1;
      for (size_t k = 0; k < weights.size(); ++k) {
        const int explanation = static_cast<int>(k);
        if (!evidence_.list().IsUnnamed(explanation) || !(weights[k] > set_.log_weight + kStandsOut)) continue;
        if (passed_.count(evidence_.list().name[k]) > 0) continue;
        if (best < 0 || weights[k] > weights[static_cast<size_t>(best)]) best = explanation;
      }
      if (best < 0) return false;
      if (!Take(best, scales[static_cast<size_t>(best)])) continue;
      std::vector<int> members = set_.members;
      members.insert(std::lower_bound(members.begin(), members.end(), best), best);
      set_ = search_.Evaluate(members);
      return true;
    }
    return false;
  }

  static EffectSpec WithValues(EffectSpec spec, const DiagnosedModel& model) {
    const Robot robot = model.problem->model().WithValues(model.estimate.parameters.ModelValues());
    for (const EffectSpec& own : robot.effects) {
      if (own.Path() == spec.Path()) return own;
    }
    return spec;
  }

  const Evidence& evidence_;
  const SetSearch search_;
  WeightedSet set_;
  DiagnosedModel final_;
  DiagnosedModel with_;
  JointOptions joint_;
  std::map<int, Candidate> pieces_;  // of the nameless cause that are like effects of the catalogue, by explanation
  std::vector<Candidate> added_;
  std::set<std::string> passed_;  // names of functions that were tried
};

}  // namespace

std::vector<std::pair<EffectSpec, double>> LevelsOf(const EffectSpec& spec, double scale, double gap) {
  std::vector<std::pair<EffectSpec, double>> levels = {{spec, scale}};
  if (IsOfRamps(spec)) return levels;  // they carry over by themselves
  const int own = spec.IntegerSetting("knots", 0);
  const double range = spec.NumberSetting("to", 0.0) - spec.NumberSetting("from", 0.0);
  int narrowest = own;
  for (auto wide = std::rbegin(kUnnamedBumps); wide != std::rend(kUnnamedBumps); ++wide) {
    if (*wide >= own || range / (narrowest - 1) >= gap) continue;
    levels.emplace_back(spec, scale * own / *wide);
    levels.back().first.settings["knots"] = std::to_string(*wide);
    narrowest = *wide;
  }
  return levels;
}

std::optional<LearntModel> LearnModel(const Evidence& evidence, const WeightedModel& leading,
                                      const DiagnosedModel& baseline, const DiagnosedModel& final,
                                      const JointOptions& joint) {
  return Learner(evidence, leading, final, joint).Run(baseline);
}

}  // namespace sagitta
