// Decoys: generic regressors outside the catalogue. Where one of them explains
// the gap better than catalogue effects do, the cause is not in the catalogue.
//
//   smooth    joint j deviates by a smooth function of joint k or of time
//   bump      by one bump in the angle of joint k          (one column, scanned)
//   step      by one step in the angle of joint k          (one column, scanned)
//   periodic  by a harmonic of another joint's angle       (two columns, scanned)
//   product   by products and sums of two joints' angles
//   wave      a station moves as a wave in time
//
// Families of many columns C_perp = U S V' (projected off what is believed), z =
// U' r, are scored by marginal likelihood with one prior variance tau^2,
//
//   2 ln ML = max over tau of sum z_i^2 t_i / (1 + t_i) - ln(1 + t_i),  t_i = (tau s_i)^2
//
// minus ln(n) for tau; scanned ones like a catalogue effect, reduction - p ln(n) -
// 2 ln(settings). Both lose 2 ln(number of families): comparable to a penalised
// chi-square reduction.
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

// The best decoy on the model's residual.
Decoy BestDecoy(const DiagnosedModel& model);

}  // namespace sagitta
