// Decoys: generic regressors outside the catalogue. Where one of them explains
// the gap better than catalogue effects do, the cause is not in the catalogue.
//
//   smooth    joint j deviates by a smooth function of joint k (Gaussian bumps)
//   product   joint j deviates by products and sums of two joints' angles
//   wave      a station moves as a wave in time
//
// Scored by marginal likelihood with one prior variance each: for projected
// columns U S V', z = U' r, over tau on a grid
//
//   2 ln ML = sum z_i^2 t_i / (1 + t_i) - sum ln(1 + t_i),  t_i = (tau s_i)^2
//
// minus ln(n) for tau and 2 ln(number of decoys): comparable to a penalised
// chi-square reduction.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/selection.h"

namespace sagitta {

struct Decoy {
  std::string kind;        // smooth, periodic, time
  std::string depends_on;  // joint, or station
  std::string acts_on;
  std::string words;
  double penalised = -1e300;
  Eigen::MatrixXd columns;  // whitened, at the model it was scored on
};

// The best decoy on the model's residual.
Decoy BestDecoy(const DiagnosedModel& model);

}  // namespace sagitta
