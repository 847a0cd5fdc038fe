// What the posterior says of the noise, with intervals.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/evidence/posterior.h"
#include "models/constants.h"

namespace sagitta {

// Joint values or readings of a shot that were not those: all its points are off together, by far more than others.
struct WrongArrival {
  std::string configuration;
  double off = 0.0;  // m, RMS of its points from what the model predicts
};

// A group of readings that scatters by a factor of its own: times what is stated of it, or where nothing is stated
// times what the others scatter by.
struct GroupFinding {
  ReadingGroup::Kind kind = ReadingGroup::Kind::kStation;
  std::string name;                            // as of NameOf (problems/reading_group.h)
  double factor = 1.0, low = 1.0, high = 1.0;  // 95 %
  // Where it scatters less in one direction than is stated for all, one figure is stated for an instrument that has
  // two: nothing is wrong.
  bool is_finding = false;
};

// Deviation of joints of one kind at an arrival, rad or m, with its 95 % interval, and the mean of what is stated of
// them; sigma 0: none is found.
struct FoundRepeatability {
  double sigma = 0.0, low = 0.0, high = 0.0, stated = 0.0;

  bool HasInterval() const { return high > 0.0; }  // else the rows do not determine one
  bool IsOverstated() const { return HasInterval() ? high < stated : sigma < stated; }
};

// Of the leading set.
struct NoiseFinding {
  bool is_stated = true;
  bool asks_repeatability = false;  // to be estimated: what is found is no finding
  double probability = 0.0;         // that the noise is other than stated, whatever else is missing
  // Of the instrument's sigma over the stated one, or over the scatter that is assumed where none is stated.
  double scale = 1.0, low = kNotKnown, high = kNotKnown;
  bool scale_differs = false;
  bool is_bound = false;                     // a rest without a name is part of the scatter: an upper bound
  bool repeatability_is_overstated = false;  // the joints deviate less than stated
  bool is_of_final = false;                  // joints' deviation is that of the final model's own residuals
  bool is_distinguished_from_pose = true;    // poses were visited again: what follows the pose is no repeatability
  FoundRepeatability turn, travel;           // another than stated, of the joints that turn and of those that slide
  std::vector<GroupFinding> groups;
  std::vector<std::string> outliers;   // file:line
  int outliers_held_out = 0;           // of them
  int outliers_of_arrivals = 0;        // of them, in:
  std::vector<WrongArrival> arrivals;  // each configuration once
  bool is_finding = false;

  int SingleOutliers() const { return static_cast<int>(outliers.size()) - outliers_of_arrivals; }
  // Joints are said to deviate more than stated, and no pose was visited again: a cause that follows the pose looks the
  // same.
  bool MayFollowThePose() const {
    return HasUndeclaredRepeatability() && !is_distinguished_from_pose && !repeatability_is_overstated;
  }
  // That readings of a group scatter otherwise is sure whatever else there is: all sets that count have it.
  bool IsSureOfGroups(double gate) const {
    return !HasUndeclaredRepeatability() && !scale_differs && probability > gate;
  }
  bool HasRepeatability() const { return turn.sigma > 0.0 || travel.sigma > 0.0; }
  bool HasUndeclaredRepeatability() const { return HasRepeatability() && !asks_repeatability; }
  bool IsRepeatabilityStated() const { return turn.stated > 0.0 || travel.stated > 0.0; }
};

// What the evidence is made of. Where nothing states sigma the scatter about the baseline scales the rows; its level
// has no say (Student).
CalibrationProblem WithWorkingSigma(const DiagnosedModel& baseline, bool is_stated);

// The model's problem with the noise of a view, and sigma as the model's residual asks where the stated one is probably
// wrong or none is stated.
CalibrationProblem WithNoiseOf(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& problem);

// What a chi-square of that problem is multiplied by, to be one in the sigmas that the evidence's rows have.
double UnitOfRows(const Evidence& evidence, const WeightedModel& model);

// Of the models that the scatter does not refute, whether more of the probability has sigma wrong than a cause, or
// other noise, that leaves a square of a chance above `level`. What has such a square by the noise as stated is refuted
// by more than its prior says.
bool IsSigmaRefuted(const Evidence& evidence, double level);

// `final`: the extended model with that noise. `stated`: the problem as it was stated.
NoiseFinding FindNoise(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& stated,
                       const DiagnosedModel& final);

// The model with the deviation of its joints that its own residuals show, sigma open where nothing states it: the noise
// of a view goes with all that its set holds, and less of that leaves more. Of poses that were visited once. The model
// itself where no fit is usable.
DiagnosedModel WithOwnRepeatability(const DiagnosedModel& model, bool is_sigma_stated, const JointOptions& options);

// The rows that were left out, and which of them are all of a shot, two points at least.
void NameLeftOut(const DiagnosedModel& model, const std::vector<int>& outliers, NoiseFinding* noise);

// P that the instrument's noise (as stated, or as rigid markers show it where the stated one is wrong) scatters as much
// as this model leaves.
double LackOfFit(const CalibrationProblem& stated, const DiagnosedModel& model, const NoiseFinding& noise);

}  // namespace sagitta
