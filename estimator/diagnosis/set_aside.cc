#include "estimator/diagnosis/set_aside.h"

#include <algorithm>

#include "estimator/diagnosis/noise_check.h"
#include "estimator/explanations/moments.h"
#include "estimator/report/diagnosis_caution_words.h"

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

// Rows that no fit counts; models share their problems.
void ExcludeFrom(DiagnosedModel* model, const std::vector<int>& rows) {
  model->problem = std::make_shared<CalibrationProblem>(*model->problem);
  for (const int i : rows) model->problem->mutable_data()->ExcludeRow(i);
}

// Moments at which effects begin.
std::vector<double> Moments(const Robot& robot, const std::vector<EffectSpec>& effects) {
  std::vector<double> moments;
  for (const EffectSpec& spec : effects) {
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

// Held-out rows with no fitted visit between them and one of the moments.
std::vector<int> HeldOutNextTo(const std::vector<double>& moments, const CalibrationProblem& problem) {
  const auto time_of = [&](int observation) {
    return problem.shot_inputs()[problem.data().observations[observation].shot].conditions.time;
  };
  std::set<double> fitted;
  for (const int i : problem.CalibrationObservations()) fitted.insert(time_of(i));
  std::vector<int> rows;
  for (const int i : problem.ValidationObservations()) {
    const double own = time_of(i);
    const bool is_next = std::any_of(moments.begin(), moments.end(), [&](double moment) {
      const auto after = fitted.lower_bound(std::min(own, moment));
      return after == fitted.end() || *after > std::max(own, moment);
    });
    if (is_next) rows.push_back(i);
  }
  return rows;
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
  const std::vector<double> moments = Moments(seen.robot(), seen.robot().effects);
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

void SetAside::FromHeldOut(bool lacks_nothing, DiagnosedModel* baseline, DiagnosedModel* final, DiagnosedModel* lacking,
                           std::vector<DiagnosedModel>* prefixes) {
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
  ExcludeFrom(lacking, removed);
  for (DiagnosedModel& prefix : *prefixes) ExcludeFrom(&prefix, removed);
  outliers_.insert(outliers_.end(), removed.begin(), removed.end());
  held_out_ = static_cast<int>(removed.size());
}

void SetAside::NextToMoments(const std::vector<EffectSpec>& effects, const std::vector<DiagnosedModel*>& models,
                             std::vector<std::string>* cautions) const {
  const CalibrationProblem& problem = *models.front()->problem;
  const Measurements& data = problem.data();
  const std::vector<int> rows = HeldOutNextTo(Moments(problem.robot(), effects), problem);
  if (rows.empty() || rows.size() == problem.ValidationObservations().size()) return;
  std::vector<DiagnosedModel> without;
  for (const DiagnosedModel* model : models) {
    CalibrationProblem judged = *model->problem;
    for (const int i : rows) judged.mutable_data()->ExcludeRow(i);
    without.push_back(*model);
    if (!Replace(judged, joint_, &without.back())) return;
  }
  std::vector<std::string> names;
  for (const int i : rows) {
    const std::string& id = data.configurations[data.shots[data.observations[i].shot].configuration].id;
    if (std::find(names.begin(), names.end(), id) == names.end()) names.push_back(id);
  }
  for (size_t m = 0; m < models.size(); ++m) *models[m] = std::move(without[m]);
  cautions->push_back(AreNextToAMoment(names));
}

}  // namespace sagitta
