// The noise that a diagnosis takes: what is stated, put right where the data say otherwise. What the noise is can only
// be told beside the effects, and the other way round: it follows the extended model, in rounds.
#pragma once

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

// Penalised gain of what is no effect before it counts. Gains are twice a log odds: 10 at level 0.01, more at
// smaller ones.
double EvidenceNeeded(double significance);

constexpr double kNotTold = std::numeric_limits<double>::quiet_NaN();

struct NoiseFinding {
  bool is_stated = true;
  bool asks_repeatability = false;  // to be estimated: what is found is no finding
  // Of the instrument's sigma over the stated one, or over the scatter that is taken where none is stated.
  double scale = 1.0, low = kNotTold, high = kNotTold;
  bool scale_differs = false;
  // A rest without a name is part of the scatter: it only bounds the scale (where markers do not tell it) and the
  // repeatability from above.
  bool is_bound = false, repeatability_is_bound = false;
  bool repeatability_is_overstated = false;  // the rows scatter less: what is stated is not taken
  double taken_of_repeats = 1.0;             // of a sigma from repeats, within their interval
  double repeatability = 0.0, repeatability_low = 0.0, repeatability_high = 0.0;  // rad; 0: none found
  std::vector<std::string> outliers;                                              // file:line
  int outliers_held_out = 0;                                                      // of them
  bool is_finding = false;

  bool HasUndeclaredRepeatability() const {
    return repeatability > 0.0 && !repeatability_is_bound && !asks_repeatability;
  }
};

class NoiseBook {
 public:
  NoiseBook(const CalibrationProblem& problem, double significance, const JointOptions& joint);

  bool sigma_is_stated() const { return sigma_is_stated_; }
  bool repeatability_is_stated() const { return repeatability_is_stated_; }
  const NoiseFinding& finding() const { return finding_; }

  // Before anything is named: a sigma where nothing states one, outliers, the scale that rigid markers tell, and no
  // stated repeatability that the rows contradict.
  void Prepare(DiagnosedModel* baseline);
  // Declares joint repeatability where it says more than `rival`, the penalised gain of the best other cause; where
  // nothing states sigma, that of the instrument beside it. What leaves far more scatter beside it is none.
  void AddRepeatability(double rival, DiagnosedModel* baseline);
  // Sigma where nothing states it, its scale where markers tell, repeatability that nobody declared (where it says more
  // than `unnamed`, the gain of a cause outside the catalogue; or that the rows contradict) and outliers that were none
  // follow the extended model.
  // True when the baseline has changed.
  bool Follow(const DiagnosedModel& extended, double unnamed, DiagnosedModel* baseline);
  // Outliers among the untouched rows say nothing of the model: other markers of their shot give them away, and no
  // hold-out figure counts them. A single marker that is off could as well be the model's error, and counts.
  void SetAsideHeldOut(DiagnosedModel* baseline, DiagnosedModel* final);
  // P that the noise as stated, or what rigid markers have shown it to be, scatters as much as this model.
  double LackOfFit(const DiagnosedModel& model) const;
  // Last: the scatter tells the instrument's noise too, or bounds it where something has structure. Scatter that
  // differs from what is stated, but not from what the markers' rigidity tells, is no structure. True where that shows
  // that sigma is not what is stated.
  bool Close(const DiagnosedModel& final, bool has_structure, double significance);

 private:
  // Factor on the repeats' sigma; 1 where sigma does not come from repeats.
  double WithinRepeats(const Estimate& estimate) const;
  bool IsWithinRepeats() const;
  double OverStated(const Estimate& estimate) const;
  // Refits a model whose problem has changed; it stays what it was where that fails (false).
  bool Replace(const CalibrationProblem& problem, DiagnosedModel* model) const;
  double FindScale(const DiagnosedModel& model);
  // Pure error: P that what is left beside the bodies' rigidity scatters by the noise that the rigidity shows.
  double BesideRigidity(const DiagnosedModel& model) const;
  // Factor on the sigmas at hand, or on kFallbackSigma, that makes them the scatter about the model.
  double Scatter(const DiagnosedModel& model) const;
  bool RefutesRepeatability(const DiagnosedModel& model) const;
  void TakeRepeatabilityAs(bool stated);
  bool AllowsAnotherSigma(const DiagnosedModel& model, double significance) const;
  void ScaleByScatter(const Estimate& final, bool has_structure);
  double FindRepeatability(const DiagnosedModel& model, double at_least);
  bool MoveOutliers(const DiagnosedModel& model, DiagnosedModel* baseline);
  bool FollowNoise(const DiagnosedModel& extended, double unnamed, DiagnosedModel* baseline);

  const CalibrationProblem& stated_;
  double significance_;
  JointOptions joint_;
  bool sigma_is_stated_, repeatability_is_stated_;
  bool sigma_follows_repeatability_;   // both are open, and rows tell them apart
  double beside_repeatability_ = 1.0;  // factor on the sigmas that goes with what was found last
  double applied_ = 1.0;               // scale that is in the baseline's sigmas already
  bool scale_is_measured_ = false;     // by rigid bodies
  std::vector<int> outliers_;          // that are fitted no longer
  std::set<int> returned_;             // that were some once
  NoiseFinding finding_;
};

}  // namespace sagitta
