// What the posterior says of the noise, with intervals.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/evidence/posterior.h"
#include "models/constants.h"

namespace sagitta {

struct NoiseFinding {
  bool is_stated = true;
  bool asks_repeatability = false;  // to be estimated: what is found is no finding
  double probability = 0.0;         // that the noise is other than stated, whatever else is missing
  // Of the instrument's sigma over the stated one, or over the scatter that is assumed where none is stated.
  double scale = 1.0, low = kNotKnown, high = kNotKnown;
  bool scale_differs = false;
  bool is_bound = false;                     // a rest without a name is part of the scatter: an upper bound
  bool repeatability_is_overstated = false;  // the joints deviate less than stated
  bool is_distinguished_from_pose = true;    // poses were visited again: what follows the pose is no repeatability
  double repeatability = 0.0, repeatability_low = 0.0, repeatability_high = 0.0;  // rad; 0: as stated
  double stated_repeatability = 0.0;                                              // rad, mean of the joints
  std::vector<std::string> outliers;                                              // file:line
  int outliers_held_out = 0;                                                      // of them
  bool is_finding = false;

  bool HasUndeclaredRepeatability() const { return repeatability > 0.0 && !asks_repeatability; }
};

// What the evidence is made of. Where nothing states sigma the scatter about the baseline scales the rows; its level
// has no say (Student).
CalibrationProblem WithWorkingSigma(const DiagnosedModel& baseline, bool is_stated);

// The model's problem with the noise of a view, and sigma as the model's residual asks where the stated one is probably
// wrong or none is stated.
CalibrationProblem WithNoiseOf(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& problem);

// What a chi-square of that problem is multiplied by, to be one in the sigmas that the evidence's rows have.
double UnitOfRows(const Evidence& evidence, const WeightedModel& model);

// `final`: the extended model with that noise. `stated`: the problem as it was stated.
NoiseFinding FindNoise(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& stated,
                       const DiagnosedModel& final);

// P that the instrument's noise (as stated, or as rigid markers show it where the stated one is wrong) scatters as much
// as this model leaves.
double LackOfFit(const CalibrationProblem& stated, const DiagnosedModel& model, const NoiseFinding& noise);

}  // namespace sagitta
