// Validation under load, and which of three changes between the papers' "previous
// work" and "this work" does what: they change all at once.
#pragma once

#include <string>
#include <vector>

#include "tools/reproduce/data.h"

namespace sagitta {

struct ElasticPrediction {
  std::vector<Eigen::Matrix3Xd> residuals;  // m, one block per configuration
  std::vector<double> predicted;            // m, per coordinate: noise and covariance of the compliances
  double rms = 0.0, predicted_rms = 0.0;    // m, over all
  int coordinates = 0;
};
// OLS on the 15 published configurations. `model_is_complete`: joint 1 is rigid and
// deflections are of first order, so that the covariance knows of all errors.
ElasticPrediction PredictValidation(const ElasticRun& run, bool model_is_complete, unsigned long long seed);

struct AblationCase {
  bool optimal = false;      // the 15 published configurations; else random ones
  bool markers = false;      // marker coordinates; else full poses, 0.3 m/rad
  bool compensator = false;  // k21 ... k25; else one k2
  ResidualSize before, after;
  Vector3<double> before_max_axis, after_max_axis;  // m
};
// Errors are those of the compensation alone, without the noise of validation, over
// many random configurations. Previous work (none of the three) first, this work (all) last.
std::vector<AblationCase> RunAblation(Reproduction& reproduction);  // NOLINT: fills its caches

void AddAblation(const std::vector<AblationCase>& cases, ReproducedTable* table);

}  // namespace sagitta
