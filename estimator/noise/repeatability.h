// Instrument scale and repeatability of the joints together, by REML: one
// repeatability for all joints of a kind, or one for each where the data carry it.
//
// One per joint is chosen where its deviance is lower than the common one's by more than
//   (components more) ln(rows - parameters)
// the price of the Bayesian information criterion: on a few dozen arrivals, separate values that do not earn it are
// noise in the weights.
#pragma once

#include "estimator/estimate/estimate.h"
#include "estimator/noise/variance_components.h"

namespace sagitta {

// The experiment asks for the repeatability, the instrument's scale, or both.
bool EstimatesComponents(const Experiment& experiment);

struct RepeatabilityChoice {
  bool estimate_instrument = false;
  std::vector<DeviationGroup> groups;
  bool per_joint = false;
  double gain = 0.0;  // deviance, one per joint against common
  double penalty = 0.0;
  double instrument = 1.0;       // factor on the roots
  bool rotations_apart = false;  // rotations have one of their own, estimated
  double rotation = 1.0;         // it; else that of the instrument
  LatentModel latent;            // with the deviations found
  Eigen::VectorXd interval_dof;  // Student, of each estimated coordinate; set by FinishComponents
};

// REML at `parameters`; `problem` holds the roots that the instrument factor scales. Returns the largest relative
// change of a standard deviation since `choice` was last set. The choice between common and per joint is
// made in the first rounds only, so that it cannot alternate.
double FindComponents(const CalibrationProblem& problem, const ParameterSet& parameters, bool sigma_is_stated,
                      int round, RepeatabilityChoice* choice);

// Value and interval in another unit.
void ScaleComponent(double factor, VarianceComponent* component);

// Intervals and sizes at the optimum; `problem` is whitened by what was found.
void FinishComponents(const CalibrationProblem& problem, const ParameterSet& parameters, RepeatabilityChoice* choice,
                      NoiseReport* report);

}  // namespace sagitta
