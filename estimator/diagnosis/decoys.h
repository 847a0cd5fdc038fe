// Decoys: generic regressors outside the catalogue. Where one of them explains
// the gap better than catalogue effects do, the cause is not in the catalogue.
//
//   smooth    joint j deviates by a smooth function of joint k or of time
//   bump      by one bump in its own angle                 (one column, scanned)
//   step      by one step in its own angle                 (one column, scanned)
//   periodic  by a harmonic of another joint's angle       (two columns, scanned)
//   product   by products and sums of two joints' angles
//   wave      a station moves as a wave in time
//
// Families of many columns are scored by marginal likelihood
// (ProjectedResidual::MarginalGain), few columns like a catalogue effect,
// reduction - p ln(n); both lose 2 ln(settings scanned): comparable to the
// penalised chi-square reduction of FORMATS section 6.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/selection.h"

namespace sagitta {

struct Decoy {
  std::string kind;                     // smooth, periodic, step, time, other
  std::vector<std::string> depends_on;  // joints, or a station
  std::string acts_on;
  std::string words;
  double penalised = -1e300;
  Eigen::MatrixXd columns;  // whitened, at the model it was scored on
};

// The best decoy on the model's residual, beside others that are believed.
Decoy BestDecoy(const DiagnosedModel& model, const std::vector<Decoy>& believed = {});

// All that a decoy's kind can do at this model: any smooth function of what it
// depends on, on what it acts on, and its own columns.
Eigen::MatrixXd ColumnsOfKind(const DiagnosedModel& model, const Decoy& decoy);

}  // namespace sagitta
