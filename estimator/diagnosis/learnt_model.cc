#include "estimator/diagnosis/learnt_model.h"

#include <glog/logging.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "estimator/diagnosis/selected_effects.h"
#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_list.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"

namespace sagitta {
namespace {

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

// A spring's shape is a narrow valley, and flat together with smooth functions: it stays where it was found.
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
  Learner(const Evidence& evidence, const WeightedModel& leading, const PoseGroups& groups, const DiagnosedModel& final,
          const JointOptions& joint)
      : evidence_(evidence),
        search_(evidence.SearchIn(leading.view)),
        groups_(groups),
        leading_(leading.set),
        final_(WithSpringsAsTheyAre(final)),
        joint_(joint) {
    if (leading.pieces.empty()) return;
    WeightedModel as_effects = leading;
    as_effects.pieces.clear();
    for (const SelectedEffect& effect : SelectedEffectsOf(evidence, as_effects, final)) {
      if (leading.HasPiece(effect.explanation)) pieces_.emplace(effect.explanation, effect.candidate);
    }
  }

  std::optional<LearntModel> Run(const DiagnosedModel& baseline) {
    Choose();
    const DiagnosedModel with = Extended();
    if (added_.empty()) return std::nullopt;
    LearntModel learnt;
    const ParameterSet& start = with.estimate.parameters;
    const ParameterSet nominal = AlignedAs(baseline.estimate.aligned, with.problem->parameters);
    learnt.model = JudgeFully(with.problem, start, nominal, joint_);
    if (!IsUsable(learnt.model.estimate.status)) return std::nullopt;
    VLOG(1) << "diagnosis: with what was learnt untouched rows are off by " << 1e3 * HoldoutRms(learnt.model)
            << " mm, without by " << 1e3 * HoldoutRms(final_) << ", as believed by " << 1e3 * HoldoutRms(baseline);
    if (HoldoutRms(learnt.model) >= std::min(HoldoutRms(final_), HoldoutRms(baseline))) return std::nullopt;
    // What the functions' own coefficients are uncertain by is no noise.
    learnt.gap = JudgeGap(baseline, learnt.model, baseline.estimate.noise_floor, evidence_.IsSigmaStated());
    for (const Candidate& candidate : added_) learnt.functions.push_back(WithValues(candidate.spec, learnt.model));
    return learnt;
  }

 private:
  // What the leading set holds beyond the effects that are named; then what groups of poses confirm.
  void Choose() {
    set_ = search_.Evaluate(leading_.members, leading_.scales);
    errors_ = groups_.ErrorsLeftOut(set_);
    for (const int member : leading_.members) {
      if (!evidence_.list().IsUnnamed(member)) continue;
      chosen_.push_back(member);
      asked_.insert(evidence_.list().name[member]);
    }
    while (ChooseNext()) continue;
    for (const auto& [member, piece] : pieces_) chosen_.push_back(member);
  }

  // False: it does not predict what is left out of the fit better beyond chance.
  bool Choose(int explanation) {
    asked_.insert(evidence_.list().name[explanation]);
    const WeightedSet with = search_.Evaluate(EachOnce(set_.members, {explanation}));
    const Eigen::VectorXd errors = groups_.ErrorsLeftOut(with), gains = errors_ - errors;
    const double gain = gains.sum() / gains.norm();
    VLOG(1) << "diagnosis: " << evidence_.list().name[explanation] << " predicts what is left out better by " << gain
            << " standard errors";
    if (!IsBeyondChance(gain)) return false;
    set_ = with;
    errors_ = errors;
    chosen_.push_back(explanation);
    return true;
  }

  // The best that is left, by the evidence; what does no good is passed over. False: none stands out.
  bool ChooseNext() {
    const std::vector<double> weights = search_.Additions(set_);
    while (true) {
      int best = -1;
      for (const int k : groups_.asked()) {
        const double weight = weights[k];
        if (!evidence_.list().IsUnnamed(k) || !(weight > set_.log_weight + kStandsOut)) continue;
        if (asked_.count(evidence_.list().name[k]) > 0) continue;
        if (best < 0 || weight > weights[best]) best = k;
      }
      if (best < 0) return false;
      if (Choose(best)) return true;
    }
  }

  // With what was chosen; without the last of it where the refit does not converge.
  DiagnosedModel Extended() {
    for (; !chosen_.empty(); chosen_.pop_back()) {
      added_.clear();
      for (const int explanation : chosen_) Add(explanation);
      DiagnosedModel with = Extend(final_, added_, joint_);
      if (IsUsable(with.estimate.status)) return with;
    }
    added_.clear();
    return final_;
  }

  void Add(int explanation) {
    const auto piece = pieces_.find(explanation);
    if (piece != pieces_.end()) {
      added_.push_back(piece->second);
      return;
    }
    const double scale = set_.scales[PlaceIn(set_.members, explanation)];
    const UnnamedFunction& function = evidence_.list().functions[evidence_.list().unnamed[explanation]];
    const double gap = LargestGap(function.driver, *final_.problem);
    for (const EffectSpec& spec : function.effects) {
      for (const auto& [level, size] : LevelsOf(spec, scale, gap)) {
        if (!Has(level)) added_.push_back(CandidateOf(level, final_.problem->robot(), size));
      }
    }
  }

  bool Has(const EffectSpec& spec) const {
    return std::any_of(added_.begin(), added_.end(),
                       [&](const Candidate& candidate) { return candidate.spec.Path() == spec.Path(); });
  }

  static EffectSpec WithValues(EffectSpec spec, const DiagnosedModel& model) {
    const Robot robot = model.problem->RobotWith(model.estimate.parameters);
    for (const EffectSpec& own : robot.effects) {
      if (own.Path() == spec.Path()) return own;
    }
    return spec;
  }

  const Evidence& evidence_;
  const SetSearch search_;
  const PoseGroups& groups_;
  const WeightedSet leading_;
  DiagnosedModel final_;
  JointOptions joint_;
  std::map<int, Candidate> pieces_;  // of the nameless cause that are like effects of the catalogue, by explanation
  WeightedSet set_;
  Eigen::VectorXd errors_;       // that it leaves on each group
  std::set<std::string> asked_;  // names of functions
  std::vector<int> chosen_;      // explanations
  std::vector<Candidate> added_;
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

std::optional<LearntModel> LearnModel(const Evidence& evidence, const WeightedModel& leading, const PoseGroups& groups,
                                      const DiagnosedModel& baseline, const DiagnosedModel& final,
                                      const JointOptions& joint) {
  return Learner(evidence, leading, groups, final, joint).Run(baseline);
}

}  // namespace sagitta
