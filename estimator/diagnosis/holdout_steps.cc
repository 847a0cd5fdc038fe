#include "estimator/diagnosis/holdout_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/diagnosis/gap.h"

namespace sagitta {

void HoldoutSteps::Measure(const DiagnosedModel& lacking, const DiagnosedModel& final,
                           const std::vector<SelectedEffect>& effects, const std::vector<Explanation>& list,
                           const JointOptions& joint) {
  up_to_.clear();
  for (int k = 0; k < static_cast<int>(effects.size()); ++k) {
    up_to_.push_back(static_cast<size_t>(GoesFirst(list, effects, k)) + 1);
  }
  models_.resize(std::min(models_.size(), effects.size()));
  if (models_.empty()) models_.push_back(PredictingHoldout(lacking));
  for (size_t count = models_.size(); count < effects.size(); ++count) {
    const size_t first = count > 1 && up_to_[count - 2] == count ? count - 2 : count - 1;
    const bool is_near = IsUsable(models_[first].estimate.status);
    const auto begin = effects.begin() + static_cast<long>(is_near ? first : 0);
    const std::vector<SelectedEffect> fresh(begin, effects.begin() + static_cast<long>(count));
    models_.push_back(PredictingHoldout(Extend(is_near ? models_[first] : lacking, CandidatesOf(fresh), joint)));
  }
  models_.push_back(final);
}

void HoldoutSteps::Drop(size_t out, size_t left) { models_.resize(std::min({models_.size(), out + 1, left})); }

bool HoldoutSteps::AreUsable(size_t effect) const {
  return IsUsable(models_[effect].estimate.status) && IsUsable(models_[up_to_[effect]].estimate.status);
}

int HoldoutSteps::Worst() const {
  const size_t count = up_to_.size();
  for (size_t k = count; k > 0; --k) {
    if (AreUsable(k - 1) && MakesHoldoutWorse(models_[k - 1], models_[up_to_[k - 1]])) return static_cast<int>(k) - 1;
  }
  std::vector<double> rms;
  for (const DiagnosedModel& model : models_) {
    rms.push_back(IsUsable(model.estimate.status) ? HoldoutRms(model) : kNotKnown);
  }
  const auto is_less = [](double a, double b) { return a < b || (!std::isnan(a) && std::isnan(b)); };
  const size_t best = std::min_element(rms.begin(), rms.end(), is_less) - rms.begin();
  if (best == count || !MakesHoldoutWorse(models_[best], models_.back())) return -1;
  int worst = -1;
  double most = 0.0;
  for (size_t k = best; k < count; ++k) {
    if (!(rms[up_to_[k]] - rms[k] > most)) continue;
    most = rms[up_to_[k]] - rms[k];
    worst = static_cast<int>(k);
  }
  return worst;
}

std::vector<double> HoldoutSteps::Gains() const {
  std::vector<double> gains;
  for (size_t k = 0; k < up_to_.size(); ++k) {
    gains.push_back(AreUsable(k) ? HoldoutGain(models_[k], models_[up_to_[k]])
                                 : std::numeric_limits<double>::infinity());
  }
  return gains;
}

int GoesFirst(const std::vector<Explanation>& list, const std::vector<SelectedEffect>& effects, int place) {
  if (place < 0) return -1;
  return static_cast<int>(GoingWith(list, ExplanationsOf(effects), static_cast<size_t>(place)).front());
}

}  // namespace sagitta
