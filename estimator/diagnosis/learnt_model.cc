#include "estimator/diagnosis/learnt_model.h"

#include <algorithm>
#include <limits>

#include "models/effects/catalogue.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kMostFunctions = 12;  // each costs a refit
constexpr int kFewestKnots = 4;        // a sag: fewer columns than that are waves or a step,
constexpr int kFineKnots = 25;         // which these follow
constexpr int kDigits = 7;             // of a range

const char* EffectOf(Source::Kind kind) {
  switch (kind) {
    case Source::Kind::kJoint:
      return "learnt_deviation";
    case Source::Kind::kStation:
      return "learnt_station_motion";
    case Source::Kind::kMarker:
      return "learnt_marker_motion";
    default:
      return "";  // nothing of the kind is defined
  }
}

// The same function as an effect; nothing where its definition knows no such driver.
std::optional<EffectSpec> SpecOf(const ExplanationList& list, int explanation, const CalibrationProblem& problem) {
  const UnnamedFunction& what = list.functions[list.unnamed[explanation]];
  if (what.driver.column.empty()) return std::nullopt;
  const std::string effect = EffectOf(what.sources[0].kind);
  if (effect.empty()) return std::nullopt;
  EffectSpec spec{effect, what.acts_on, {{"by", what.driver.column}}, {}};
  const std::vector<std::string>& known = FindEffect(spec.effect)->settings[0].choices;
  if (std::find(known.begin(), known.end(), what.driver.column) == known.end()) return std::nullopt;
  if (what.driver.column == "q") spec.settings["driver"] = what.driver.name;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const int i : problem.CalibrationObservations()) {
    const double at = what.driver.of_shot[problem.data.observations[i].shot];
    low = std::min(low, at);
    high = std::max(high, at);
  }
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
  Learner(const Evidence& evidence, const WeightedModel& leading, const DiagnosedModel& lacking,
          const std::vector<ChosenStep>& steps, const DiagnosedModel& final, const JointOptions& joint)
      : evidence_(evidence),
        search_(evidence.SearchIn(leading.view)),
        set_(leading.set),
        lacking_(lacking),
        added_(CandidatesOf(steps)),
        with_(final),
        joint_(joint) {}

  std::optional<LearntModel> Run(const DiagnosedModel& baseline) {
    const std::vector<int> members = set_.members;
    for (size_t k = 0; k < members.size(); ++k) {
      if (evidence_.list().IsUnnamed(members[k])) Take(members[k], set_.scales[k]);
    }
    set_ = search_.Evaluate(set_.members, set_.scales);
    while (functions_.size() < kMostFunctions && TakeNext()) continue;
    if (functions_.empty()) return std::nullopt;
    LearntModel learnt;
    const ParameterSet& start = with_.estimate.parameters;
    learnt.model = JudgeFully(with_.problem, start, start, joint_);
    if (!IsUsable(learnt.model.estimate.status)) return std::nullopt;
    learnt.gap = JudgeGap(baseline, learnt.model, evidence_.IsSigmaStated());
    for (EffectSpec& spec : functions_) learnt.functions.push_back(WithValues(std::move(spec), learnt.model));
    return learnt;
  }

 private:
  // Adds it to the model unless that does untouched rows harm. False: it is not taken.
  bool Take(int explanation, double scale) {
    const std::optional<EffectSpec> spec = SpecOf(evidence_.list(), explanation, *lacking_.problem);
    if (!spec) return false;
    added_.push_back(CandidateOf(*spec, lacking_.problem->robot, scale));
    DiagnosedModel with = Extend(lacking_, added_, joint_);
    if (!IsUsable(with.estimate.status) || MakesHoldoutWorse(with_, with)) {
      added_.pop_back();
      return false;
    }
    functions_.push_back(*spec);
    with_ = std::move(with);
    return true;
  }

  // The best that is left, by the evidence. False: none stands out, or it does harm.
  bool TakeNext() {
    std::vector<double> scales;
    const std::vector<double> weights = search_.Additions(set_, &scales);
    int best = -1;
    for (size_t k = 0; k < weights.size(); ++k) {
      const int explanation = static_cast<int>(k);
      if (!evidence_.list().IsUnnamed(explanation) || !(weights[k] > set_.log_weight + kStandsOut)) continue;
      if (best >= 0 && weights[k] <= weights[static_cast<size_t>(best)]) continue;
      if (SpecOf(evidence_.list(), explanation, *lacking_.problem)) best = explanation;
    }
    if (best < 0 || !Take(best, scales[static_cast<size_t>(best)])) return false;
    std::vector<int> members = set_.members;
    members.insert(std::lower_bound(members.begin(), members.end(), best), best);
    set_ = search_.Evaluate(members);
    return true;
  }

  static EffectSpec WithValues(EffectSpec spec, const DiagnosedModel& model) {
    const Robot robot = model.problem->model.WithValues(model.estimate.parameters.ModelValues());
    for (const EffectSpec& own : robot.effects) {
      if (own.Path() == spec.Path()) return own;
    }
    return spec;
  }

  const Evidence& evidence_;
  const SetSearch search_;
  WeightedSet set_;
  const DiagnosedModel& lacking_;
  std::vector<Candidate> added_;
  DiagnosedModel with_;
  JointOptions joint_;
  std::vector<EffectSpec> functions_;
};

}  // namespace

std::optional<LearntModel> LearnModel(const Evidence& evidence, const WeightedModel& leading,
                                      const DiagnosedModel& baseline, const DiagnosedModel& lacking,
                                      const std::vector<ChosenStep>& steps, const DiagnosedModel& final,
                                      const JointOptions& joint) {
  return Learner(evidence, leading, lacking, steps, final, joint).Run(baseline);
}

}  // namespace sagitta
