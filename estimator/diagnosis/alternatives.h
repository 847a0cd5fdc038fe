// What else would explain a step: overlap is the share of the step's chi-square
// reduction that a rival reproduces, |P_rival c|^2 / |c|^2 with c the step's
// contribution to the whitened rows, projected off everything believed.
#pragma once

#include <vector>

#include "estimator/diagnosis/step_bench.h"

namespace sagitta {

struct Alternative {
  EffectSpec spec;
  double overlap = 0.0;
  bool tied = false;  // within the tie of the step's penalised reduction
};

// Sorted by overlap: those with an overlap of 0.8 or more, of the change points of one effect the best; and all tied
// ones that reproduce at least kOverlapOfRivals of the step: others explain something else equally well.
// neutral_residual: StepBench::NeutralResidual of the step.
std::vector<Alternative> FindAlternatives(const StepBench& bench, const ChosenStep& step,
                                          const Eigen::VectorXd& neutral_residual, double tie);

}  // namespace sagitta
