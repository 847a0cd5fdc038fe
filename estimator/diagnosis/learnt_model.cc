#include "estimator/diagnosis/learnt_model.h"

#include <algorithm>
#include <set>

#include "estimator/diagnosis/selected_effects.h"
#include "models/effects/catalogue.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kMostFunctions = 12;  // each costs a refit
constexpr int kFewestKnots = 4;        // a sag: fewer columns than that are waves or a jump,
constexpr int kFineKnots = 25;         // which these follow
constexpr int kDigits = 7;             // of a range

const char* EffectOf(Source::Kind kind) {
  switch (kind) {
    case Source::Kind::kJoint:
      return "learnt_deviation";
    case Source::Kind::kStation:
    case Source::Kind::kStationTurn:
      return "learnt_station_motion";
    case Source::Kind::kMarker:
      return "learnt_marker_motion";
    case Source::Kind::kLink:
      return "learnt_growth";
    case Source::Kind::kPlate:
      break;
  }
  return "";  // nothing of the kind is defined
}

// As a setting `by` names it; "" where none does.
const char* SettingOf(DriverKind kind) {
  switch (kind) {
    case DriverKind::kAngle:
    case DriverKind::kTravel:
      return "q";
    case DriverKind::kTorque:
      return "torque_Nm";
    case DriverKind::kTime:
      return "time_s";
    case DriverKind::kTemperature:
      return "temperature_K";
    case DriverKind::kOther:
      break;
  }
  return "";
}

// Of two angles together.
std::optional<EffectSpec> PairSpec(const UnnamedFunction& what, const Chain& chain) {
  if (what.sources[0].kind != Source::Kind::kJoint || what.depends_on.size() != 2) return std::nullopt;
  for (const std::string& joint : {what.acts_on, what.depends_on[0], what.depends_on[1]}) {
    if (chain.joints[chain.FindJoint(joint)].type != JointType::kRevolute) return std::nullopt;
  }
  return EffectSpec{
      "learnt_pair_deviation", what.acts_on, {{"driver", what.depends_on[0]}, {"with", what.depends_on[1]}}, {}};
}

// The same function as an effect; nothing where there is none that follows it.
std::optional<EffectSpec> SpecOf(const ExplanationList& list, int explanation, const CalibrationProblem& problem) {
  const UnnamedFunction& what = list.functions[list.unnamed[explanation]];
  const std::string by = SettingOf(what.driver.kind);
  if (by.empty()) return PairSpec(what, problem.robot().chain);
  const EffectDefinition* definition = FindEffect(EffectOf(what.sources[0].kind));
  if (definition == nullptr) return std::nullopt;
  const std::vector<std::string>& known = definition->settings[0].choices;
  if (std::find(known.begin(), known.end(), by) == known.end()) return std::nullopt;
  const std::string target = definition->target == EffectTarget::kRobot ? "robot" : what.acts_on;
  EffectSpec spec{definition->name, target, {{"by", by}}, {}};
  const bool is_joint = what.driver.kind == DriverKind::kAngle || what.driver.kind == DriverKind::kTravel;
  if (is_joint) spec.settings["driver"] = what.driver.name;
  const Eigen::VectorXd seen = what.driver.of_shot(FittedShots(problem));
  const double low = seen.minCoeff(), high = seen.maxCoeff();
  const int count = static_cast<int>(list.math[explanation].group.size() / static_cast<long>(what.sources.size()));
  spec.settings["from"] = Significant(low, kDigits);
  spec.settings["to"] = Significant(high, kDigits);
  spec.settings["knots"] = std::to_string(count >= kFewestKnots ? count : kFineKnots);
  return spec;
}

Candidate CandidateOf(const EffectSpec& spec, const Robot& robot, double scale) {
  Candidate candidate{spec};
  for (const EffectParameter& parameter : FindEffect(spec.effect)->parameters(robot, spec)) {
    candidate.loose.push_back(spec.Path() + "/" + parameter.name);
  }
  candidate.prior_scale = scale;
  return candidate;
}

class Learner {
 public:
  Learner(const Evidence& evidence, const WeightedModel& leading, const DiagnosedModel& final,
          const JointOptions& joint)
      : evidence_(evidence),
        search_(evidence.SearchIn(leading.view)),
        set_(leading.set),
        final_(final),
        with_(final),
        joint_(joint) {}

  std::optional<LearntModel> Run(const DiagnosedModel& baseline) {
    for (size_t k = 0; k < set_.members.size(); ++k) {
      if (evidence_.list().IsUnnamed(set_.members[k])) Take(set_.members[k], set_.scales[k]);
    }
    set_ = search_.Evaluate(set_.members, set_.scales);
    while (added_.size() < kMostFunctions && TakeNext()) continue;
    if (added_.empty()) return std::nullopt;
    LearntModel learnt;
    const ParameterSet& start = with_.estimate.parameters;
    learnt.model = JudgeFully(with_.problem, start, start, joint_);
    const bool is_no_better = HoldoutRms(learnt.model) >= HoldoutRms(final_);  // false without a hold-out
    if (!IsUsable(learnt.model.estimate.status) || is_no_better) return std::nullopt;
    learnt.gap = JudgeGap(baseline, learnt.model, evidence_.IsSigmaStated());
    for (const Candidate& candidate : added_) learnt.functions.push_back(WithValues(candidate.spec, learnt.model));
    return learnt;
  }

 private:
  // Adds it to the model unless that does untouched rows harm, or the model has it. False: it is not taken.
  bool Take(int explanation, double scale) {
    const std::optional<EffectSpec> spec = SpecOf(evidence_.list(), explanation, *final_.problem);
    if (!spec || Has(*spec)) return false;
    added_.push_back(CandidateOf(*spec, final_.problem->robot(), scale));
    DiagnosedModel with = Extend(final_, added_, joint_);
    if (IsUsable(with.estimate.status) && !MakesHoldoutWorse(with_, with)) {
      with_ = std::move(with);
      return true;
    }
    added_.pop_back();
    return false;
  }

  bool Has(const EffectSpec& spec) const {
    return std::any_of(added_.begin(), added_.end(),
                       [&](const Candidate& candidate) { return candidate.spec.Path() == spec.Path(); });
  }

  // The best that is left, by the evidence; what does harm is passed over. False: none stands out.
  bool TakeNext() {
    std::vector<double> scales;
    const std::vector<double> weights = search_.Additions(set_, &scales);
    while (true) {
      int best = -1;
      for (size_t k = 0; k < weights.size(); ++k) {
        const int explanation = static_cast<int>(k);
        if (!evidence_.list().IsUnnamed(explanation) || !(weights[k] > set_.log_weight + kStandsOut)) continue;
        if (passed_.count(evidence_.list().name[k]) > 0) continue;
        if (best < 0 || weights[k] > weights[static_cast<size_t>(best)]) best = explanation;
      }
      if (best < 0) return false;
      passed_.insert(evidence_.list().name[best]);
      if (!Take(best, scales[static_cast<size_t>(best)])) continue;
      std::vector<int> members = set_.members;
      members.insert(std::lower_bound(members.begin(), members.end(), best), best);
      set_ = search_.Evaluate(members);
      return true;
    }
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
  const DiagnosedModel& final_;
  DiagnosedModel with_;
  JointOptions joint_;
  std::vector<Candidate> added_;
  std::set<std::string> passed_;  // names of functions that were tried
};

}  // namespace

std::optional<LearntModel> LearnModel(const Evidence& evidence, const WeightedModel& leading,
                                      const DiagnosedModel& baseline, const DiagnosedModel& final,
                                      const JointOptions& joint) {
  return Learner(evidence, leading, final, joint).Run(baseline);
}

}  // namespace sagitta
