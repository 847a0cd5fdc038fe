#include "estimator/diagnosis/set_aside.h"

#include <algorithm>

#include "estimator/diagnosis/noise_check.h"
#include "estimator/explanations/moments.h"

namespace sagitta {
namespace {

constexpr double kShareOfOutliers = 0.1;  // of the significance
constexpr int kMostSetAsideRounds = 12;   // each sets aside all above a twentieth of the worst (noise_check.cc)

bool Replace(const CalibrationProblem& problem, const JointOptions& joint, DiagnosedModel* model) {
  DiagnosedModel refit = RefitFully(problem, model->estimate, joint);
  const bool usable = IsUsable(refit.estimate.status);
  if (usable) *model = std::move(refit);
  return usable;
}

// Moments at which the model's effects begin.
std::vector<double> Moments(const Robot& robot) {
  std::vector<double> moments;
  for (const EffectSpec& spec : robot.effects) {
    const std::string setting = MomentOf(robot, spec);
    if (!setting.empty()) moments.push_back(spec.NumberSetting(setting, 0.0));
  }
  return moments;
}

// Whether no more than one other time was measured between an observation and a moment: such a row may be on the wrong
// side of it, because the moment was found without the row.
bool IsNextToAny(const std::vector<double>& moments, const CalibrationProblem& problem, int observation) {
  const double own = problem.shot_inputs()[problem.data().observations[observation].shot].conditions.time;
  return std::any_of(moments.begin(), moments.end(), [&](double moment) {
    std::set<double> between;
    for (const ShotInput& shot : problem.shot_inputs()) {
      const double time = shot.conditions.time;
      if (time > std::min(own, moment) && time < std::max(own, moment)) between.insert(time);
    }
    return between.size() <= 1;
  });
}

}  // namespace

void SetAside::FromFitted(DiagnosedModel* model) {
  for (int round = 0; round < kMostSetAsideRounds && Follow(*model, model); ++round) {
  }
}

bool SetAside::Follow(const DiagnosedModel& extended, DiagnosedModel* baseline) {
  const CalibrationProblem& seen = *extended.problem;
  const ParameterSet& parameters = extended.estimate.parameters;
  const double significance = kShareOfOutliers * significance_;
  std::vector<int> back = ExplainedOutliers(seen, parameters, outliers_, significance);
  const std::vector<double> moments = Moments(seen.robot());
  for (const int i : outliers_) {
    const bool is_back = std::find(back.begin(), back.end(), i) != back.end();
    if (!is_back && IsNextToAny(moments, seen, i)) back.push_back(i);
  }
  std::vector<int> out =
      FindOutliers(seen, parameters, seen.CalibrationObservations(), significance, false, outliers_.size());
  const auto came_back = [&](int i) { return returned_.count(i) > 0; };
  out.erase(std::remove_if(out.begin(), out.end(), came_back), out.end());
  if (back.empty() && out.empty()) return false;
  CalibrationProblem problem = *baseline->problem;
  for (const int i : back) problem.mutable_data()->ExcludeRow(i, false);
  for (const int i : out) problem.mutable_data()->ExcludeRow(i);
  if (!Replace(problem, joint_, baseline)) return false;
  for (const int i : back) outliers_.erase(std::find(outliers_.begin(), outliers_.end(), i));
  returned_.insert(back.begin(), back.end());
  outliers_.insert(outliers_.end(), out.begin(), out.end());
  return true;
}

void SetAside::FromHeldOut(bool lacks_nothing, DiagnosedModel* baseline, DiagnosedModel* final) {
  CalibrationProblem cleaned = *final->problem;
  std::vector<int> removed;
  for (int round = 0; round < kMostSetAsideRounds; ++round) {
    const std::vector<int> outliers =
        FindOutliers(cleaned, final->estimate.parameters, cleaned.ValidationObservations(),
                     kShareOfOutliers * significance_, !lacks_nothing, removed.size());
    if (outliers.empty()) break;
    for (const int i : outliers) cleaned.mutable_data()->ExcludeRow(i);
    removed.insert(removed.end(), outliers.begin(), outliers.end());
  }
  if (removed.empty()) return;
  CalibrationProblem before = *baseline->problem;
  for (const int i : removed) before.mutable_data()->ExcludeRow(i);
  DiagnosedModel cleaned_baseline = *baseline;  // both or none: the gap compares the same rows
  if (!Replace(before, joint_, &cleaned_baseline) || !Replace(cleaned, joint_, final)) return;
  *baseline = std::move(cleaned_baseline);
  outliers_.insert(outliers_.end(), removed.begin(), removed.end());
  held_out_ = static_cast<int>(removed.size());
}

}  // namespace sagitta
