#include "estimator/diagnosis/set_aside.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string>

#include "estimator/diagnosis/outlier_rules.h"
#include "estimator/report/diagnosis_caution_words.h"
#include "estimator/statistics/distributions.h"
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

constexpr double kShareOfOutliers = 0.1;  // of the significance, lest rows go that a cause moves
// Each sets aside all above a twentieth of the worst (outlier_rules.cc): 20^12 = 4e15 are all digits of a double.
constexpr int kMostSetAsideRounds = 12;

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

// How many readings at the end of a series are off as a rule and not by chance: from one that is off on most are, two
// at least. Two ends are looked at; to begin at the j-th that is off has 1/j of the significance.
int LengthOfEnd(const std::vector<bool>& is_off, double significance) {
  const int n = static_cast<int>(is_off.size()), off = static_cast<int>(std::count(is_off.begin(), is_off.end(), true));
  int nth = 0;
  for (int first = 0; first < n; ++first) {
    if (!is_off[first]) continue;
    const int last = n - first, there = off - nth;
    ++nth;
    if (there < 2 || 2 * there <= last) continue;
    if (2.0 * nth * HypergeometricSurvival(n, off, last, there) < significance) return last;
  }
  return 0;
}

// One marker in one shot.
struct Reading {
  double time;
  int shot, marker;
  bool is_off;
  std::vector<int> observations;
};

// In the order of time, or of the rows where not all state it.
std::vector<Reading> ReadingsOf(const CalibrationProblem& problem, const std::set<int>& rows,
                                const std::set<int>& off) {
  const std::vector<ShotInput>& shots = problem.shot_inputs();
  const bool is_timed = std::all_of(shots.begin(), shots.end(), [](const auto& s) { return s.conditions.has_time; });
  std::map<std::pair<int, int>, Reading> by_shot;
  for (const int i : rows) {
    const Observation& row = problem.data().observations[i];
    const double time = is_timed ? shots[row.shot].conditions.time : row.shot;
    Reading& reading =
        by_shot.emplace(std::pair(row.shot, row.marker), Reading{time, row.shot, row.marker, false, {}}).first->second;
    reading.is_off |= off.count(i) > 0;
    reading.observations.push_back(i);
  }
  std::vector<Reading> readings;
  for (const auto& [at, reading] : by_shot) readings.push_back(reading);
  std::stable_sort(readings.begin(), readings.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return readings;
}

// What a reading was measured under: what most readings of one load, of a station or of a direction of approach do is
// no mistake of theirs.
std::vector<std::string> ConditionsOf(const CalibrationProblem& problem, const Reading& reading) {
  const ShotConditions& shot = problem.shot_inputs()[reading.shot].conditions;
  std::vector<std::string> conditions = {"load " + shot.load, "station " + shot.station};
  for (int j = 0; j < problem.robot().num_joints(); ++j) {
    if (shot.StatesApproachOf(j))
      conditions.push_back("approach " + std::to_string(j) + " " + std::to_string(shot.approach[j]));
  }
  return conditions;
}

// Those of the rows `off` that are off for a reason that others share: a marker that was seated anew, a tool or a
// station that was moved is off from some moment on or up to it, and so is what was measured under a condition.
std::set<int> WithACause(const CalibrationProblem& problem, const std::set<int>& rows, const std::set<int>& off,
                         double significance) {
  const std::vector<Reading> readings = ReadingsOf(problem, rows, off);
  std::map<std::pair<int, std::string>, std::vector<const Reading*>> series;
  std::map<std::string, std::vector<const Reading*>> conditions;
  for (const Reading& reading : readings) {
    series[{reading.marker, ""}].push_back(&reading);
    series[{reading.marker, problem.shot_inputs()[reading.shot].conditions.station}].push_back(&reading);
    for (const std::string& condition : ConditionsOf(problem, reading)) conditions[condition].push_back(&reading);
  }
  std::set<int> found;
  const auto add = [&](auto first, auto end) {
    for (; first != end; ++first) {
      for (const int i : (*first)->observations) {
        if (off.count(i) > 0) found.insert(i);
      }
    }
  };
  for (const auto& [of, own] : series) {
    std::vector<bool> is_off;
    for (const Reading* reading : own) is_off.push_back(reading->is_off);
    add(own.end() - LengthOfEnd(is_off, significance), own.end());
    std::reverse(is_off.begin(), is_off.end());
    add(own.begin(), own.begin() + LengthOfEnd(is_off, significance));
  }
  for (const auto& [condition, own] : conditions) {
    const auto off_there = std::count_if(own.begin(), own.end(), [](const Reading* r) { return r->is_off; });
    if (2 * off_there > static_cast<long>(own.size())) add(own.begin(), own.end());
  }
  return found;
}

std::set<int> Union(std::initializer_list<std::vector<int>> lists) {
  std::set<int> all;
  for (const std::vector<int>& list : lists) all.insert(list.begin(), list.end());
  return all;
}

}  // namespace

// Rows that were some once and are off all the same.
std::vector<int> SetAside::StillOff(const DiagnosedModel& model) const {
  const std::vector<int> once(returned_.begin(), returned_.end());
  std::vector<int> explained =
      ExplainedOutliers(*model.problem, model.estimate.parameters, once, kShareOfOutliers * significance_);
  std::vector<int> still;
  std::sort(explained.begin(), explained.end());
  std::set_difference(once.begin(), once.end(), explained.begin(), explained.end(), std::back_inserter(still));
  return still;
}

void SetAside::FromFitted(DiagnosedModel* model) {
  for (int round = 0; round < kMostSetAsideRounds && (Follow(*model, {}, model) || FollowWithoutWorst(model));
       ++round) {
  }
}

bool SetAside::FollowWithoutWorst(DiagnosedModel* model) {
  const std::vector<int> rows = RowsOfTheWorst(*model->problem, model->estimate.parameters, significance_);
  if (rows.empty()) return false;
  DiagnosedModel judge = *model;
  ExcludeFrom(&judge, rows);
  const std::shared_ptr<const CalibrationProblem> without = judge.problem;
  if (!Replace(*without, joint_, &judge)) return false;
  judge.problem = model->problem;
  return Follow(judge, {}, model);
}

bool SetAside::FollowExtended(const DiagnosedModel& extended, bool explains_all, DiagnosedModel* baseline) {
  DiagnosedModel judge = extended;
  bool changed = false;
  for (int round = 0; round < kMostSetAsideRounds && Follow(judge, {true, explains_all}, baseline); ++round) {
    changed = true;
    judge.problem = std::make_shared<CalibrationProblem>(*judge.problem);
    const auto& rows = baseline->problem->data().observations;
    for (size_t i = 0; i < rows.size(); ++i)
      judge.problem->mutable_data()->ExcludeRow(static_cast<int>(i), rows[i].excluded);
    judge.estimate = RefitQuickly(*judge.problem, judge.estimate.parameters).estimate;
    if (!IsUsable(judge.estimate.status)) break;
  }
  return changed;
}

bool SetAside::Follow(const DiagnosedModel& judge, const Judge& says, DiagnosedModel* baseline) {
  const CalibrationProblem& seen = *judge.problem;
  const ParameterSet& parameters = judge.estimate.parameters;
  const double significance = kShareOfOutliers * significance_;
  std::vector<int> back = ExplainedOutliers(seen, parameters, outliers_, significance);
  const std::vector<double> moments = Moments(seen.robot(), seen.robot().effects);
  for (const int i : outliers_) {
    const bool is_back = std::find(back.begin(), back.end(), i) != back.end();
    if (!is_back && IsNextToAny(moments, seen, i)) back.push_back(i);
  }
  std::vector<int> out = FindOutliers(seen, parameters, seen.CalibrationObservations(),
                                      {significance, false, says.explains_all, outliers_.size()});
  const std::set<int> caused = WithACause(seen, Union({seen.CalibrationObservations(), outliers_}),
                                          Union({out, outliers_, StillOff(judge)}), significance_);
  for (const int i : outliers_) {
    if (caused.count(i) > 0 && std::find(back.begin(), back.end(), i) == back.end()) back.push_back(i);
  }
  returned_.insert(caused.begin(), caused.end());
  const auto stays = [&](int i) { return (says.is_extended ? caused : returned_).count(i) > 0; };
  out.erase(std::remove_if(out.begin(), out.end(), stays), out.end());
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

void SetAside::FromHeldOut(bool lacks_nothing, bool explains_all, DiagnosedModel* baseline, DiagnosedModel* final,
                           DiagnosedModel* lacking, std::vector<DiagnosedModel>* prefixes) {
  CalibrationProblem cleaned = *final->problem;
  std::vector<int> removed;
  const bool by_their_body = !lacks_nothing && outliers_.empty();
  for (int round = 0; round < kMostSetAsideRounds; ++round) {
    const std::vector<int> outliers =
        FindOutliers(cleaned, final->estimate.parameters, cleaned.ValidationObservations(),
                     {kShareOfOutliers * significance_, by_their_body, explains_all, removed.size()});
    if (outliers.empty()) break;
    for (const int i : outliers) cleaned.mutable_data()->ExcludeRow(i);
    removed.insert(removed.end(), outliers.begin(), outliers.end());
  }
  const std::set<int> caused = WithACause(
      cleaned, Union({cleaned.CalibrationObservations(), cleaned.ValidationObservations(), outliers_, removed}),
      Union({removed, outliers_, StillOff(*final)}), significance_);
  for (const int i : caused) {
    const auto own = std::find(removed.begin(), removed.end(), i);
    if (own == removed.end()) continue;
    cleaned.mutable_data()->ExcludeRow(i, false);
    removed.erase(own);
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
  held_out_ += static_cast<int>(removed.size());
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
