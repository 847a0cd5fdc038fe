// The one problem type: robot, observations, noise, and what is unknown.
// Every method takes it; nothing in it says how to solve.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/forward_model.h"
#include "models/robot.h"
#include "problems/experiment.h"
#include "problems/latent_model.h"
#include "problems/measurements.h"
#include "problems/noise_model.h"
#include "problems/parameter_set.h"

namespace sagitta {

struct CalibrationProblem {
  // Complete: places of markers, what acts in each shot and stated repeatability follow from the three; unknowns are at
  // their nominal values. Throws InputError. MakeCalibrationProblem also checks the data and takes start values and
  // what is free from the experiment.
  CalibrationProblem(Robot robot, Measurements data, Experiment experiment);

  Robot robot;
  Measurements data;
  Experiment experiment;
  ForwardModel model;                         // of `robot`
  std::vector<int> marker_frames;             // chain frame of each marker of `data`
  std::vector<ShotInput> shot_inputs;         // joint values and wrenches of each shot of `data`
  LatentModel latent;                         // joint deviations per visit; empty where repeatability is 0
  ParameterSet parameters;                    // start values; free and fixed as the experiment says
  std::vector<std::string> redundant_errors;  // default free set: what stays nominal

  // Noise that is found, not stated (from repeats, or by the estimator): one root
  // per observation, in place of what is stated. Empty: as stated.
  NoiseRoots resolved_noise;
  // Roots the fit weighs with in place of the noise's (estimator/noise/weighting.h): the
  // noise then says what the estimate is worth, not how it is made. Empty: the noise's.
  NoiseRoots weight_roots;
  std::optional<RepeatScatter> repeat_scatter;  // where the noise is from repeats

  // Root of the noise covariance of an observation, m or rad (problems/noise_model.h);
  // zero where nothing states one: then all rows share one sigma that is estimated.
  Matrix3<double> NoiseRoot(int observation) const;
  bool sigma_is_stated() const;

  // The same problem with more effects in the robot; their parameters are free
  // and start at the specs' values (none: neutral), all others keep values and
  // flags. A `gravity_compensator` (values L, a_x, a_y, s0, Kc) goes to its home;
  // its L is held: the scale gauge.
  CalibrationProblem WithEffects(const std::vector<EffectSpec>& specs) const;

  // Observations that are fitted, and those of held-out configurations, by index; none that is excluded.
  std::vector<int> CalibrationObservations() const;
  std::vector<int> ValidationObservations() const;
};

// Reads nothing: puts robot, data and experiment together, marks the split and
// checks what only all three show (joint counts, unknown names, fewer equations
// than unknowns, a station or marker that only validation rows have, a load
// without a point or a force). Throws InputError.
CalibrationProblem MakeCalibrationProblem(Robot robot, Measurements data, Experiment experiment);

}  // namespace sagitta
