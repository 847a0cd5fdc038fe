// What is known of the noise once it is more than stated sigmas: variance
// components, spreads of groups, outliers. Part of an Estimate.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/geometry.h"
#include "models/quantity.h"
#include "problems/choices.h"

namespace sagitta {

// One standard deviation found by REML.
struct VarianceComponent {
  std::string name;              // "instrument", "rotations", "joints", "prismatic joints", or a joint
  std::vector<int> joints;       // that share it; empty: the instrument
  bool of_rotations = false;     // the instrument's of rotations, rad; that before it is then of points
  bool is_prismatic = false;     // m instead of rad
  bool estimated = false;        // else as stated
  double value = 0.0;            // rad or m; the instrument: factor on the root it scales
  double sigma = 0.0;            // of `value`
  double low = 0.0, high = 0.0;  // 95 %, by the likelihood ratio; low is 0 where the data cannot exclude none
};

// Rows that share one standard deviation.
struct NoiseGroup {
  std::string name;    // "C7/x"
  double sigma = 0.0;  // m, spread of its residuals
  int rows = 0;
  double freedom = 0.0;  // of these rows, what the fit leaves
  std::string of = {};   // "C7"; "" where all share one
  int axis = -1;         // 0 to 2; -1: of all three
};

// A reading that its neighbours and the model do not explain.
struct Outlier {
  int observation = -1;   // the point where the row has one
  double size = 0.0;      // m, distance of the point to where the others say it should be; 0: it is no outlier
  double angle = 0.0;     // rad, the same of the row's rotation
  double whitened = 0.0;  // in standard deviations of the leave-one-out prediction, of the reading that is farther off
  int swapped_with = -1;  // observation of the same shot whose reading it has
};

// Where the noise comes from and what was found of it.
struct NoiseReport {
  // Compiled once (estimate.cc), not in each file that holds one.
  NoiseReport();
  NoiseReport(const NoiseReport&);
  NoiseReport(NoiseReport&&) noexcept;
  NoiseReport& operator=(const NoiseReport&);
  NoiseReport& operator=(NoiseReport&&) noexcept;
  ~NoiseReport();

  std::string source = "stated";  // stated, estimated, repeats, residuals, instrument, variance-components, eq14, equal
  int rounds = 0;                 // of fit -> noise -> fit
  bool converged = true;

  std::vector<VarianceComponent> components;
  bool per_joint = false;            // one repeatability per joint, else one for all
  double gain_per_joint = 0.0;       // deviance one per joint gains over a common one
  double penalty = 0.0;              // what it has to gain
  bool instrument_is_factor = true;  // on stated noise; else m per coordinate
  double instrument_rms = 0.0;       // m, of one coordinate of the calibration rows
  double robot_rms = 0.0;            // m, what the joint deviations move it

  std::vector<NoiseGroup> groups;

  LossKind loss = LossKind::kNone;
  double loss_tuning = 0.0;     // whitened distance where the loss turns
  double robust_scale = 1.0;    // of the whitened residuals, not below 1 where sigmas are stated
  double loss_inflation = 1.0;  // variance of the robust estimate over that of least squares on the rest
  std::vector<Outlier> outliers;
  bool systematic = false;          // they share a cause: not excluded from any figure
  std::vector<std::string> shared;  // what they share, in words

  std::vector<std::string> words;  // for people
};

}  // namespace sagitta
