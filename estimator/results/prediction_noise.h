// The noise that predict and validate need of an estimate: what one more measurement, and one more arrival, will
// show. Whatever the noise model was, it is written as something that gives a covariance at any point.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"
#include "problems/io/json_reader.h"

namespace sagitta {

struct PredictionNoise {
  double scale = 1.0;    // of stated sigmas and repeatability
  double scatter = 0.0;  // m, of every coordinate in addition to what is stated (noise/robot_scatter.h)
  // Groups of readings that scatter otherwise than stated, with kind and name as of WordOf and NameOf
  // (problems/reading_group.h).
  struct Group {
    std::string kind, name;
    double factor = 1.0;
  };
  std::vector<Group> groups;
  double instrument_factor = 1.0;  // of the instrument alone, rows' sigmas included: by which it is not as stated
  // m, where neither row, instrument nor one sigma says it: spread of repeats, of residuals
  std::optional<Vector3<double>> sigma_axis;
  // The same of the readings of one station or of one marker, by its name.
  std::optional<ResidualGroup> spread_by;
  std::map<std::string, Vector3<double>> spread;
  double freedom = 0.0;  // degrees of freedom that it was estimated with; 0: it was stated
  // rad, of each axis of rotations that state none; zero: as everywhere (problems/noise_model.h).
  Vector3<double> sigma_rotation = Vector3<double>::Zero();
};

// {"sigma_mm", "sigma_axis_mm", "spread", "sigma_rot_urad", "sigma_rot_axis_urad", "instrument", "instrument_factor",
// "groups", "scale", "scatter_mm", "repeatability_urad", "repeatability_um"}; `scale` is 1 where there is a scatter.
nlohmann::ordered_json PredictionNoiseToJson(const CalibrationProblem& problem, const Estimate& estimate);

// The inverse; sigma, instrument and repeatability go to `experiment`. Throws InputError.
PredictionNoise ReadPredictionNoise(const JsonValue& json, Experiment* experiment);

// Roots of each observation's covariance seen at `points` (m, station frame), before `scale`; zero: not known.
NoiseRoots PredictionRoots(const CalibrationProblem& problem, const PredictionNoise& noise,
                           const Eigen::Matrix3Xd& points);

}  // namespace sagitta
