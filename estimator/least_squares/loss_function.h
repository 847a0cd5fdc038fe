// Robust losses of the whitened distance of one reading, for rounds of least squares (noise/robust.h) and for Ceres.
#pragma once

#include <ceres/loss_function.h>

#include "problems/experiment.h"

namespace sagitta {

// k of noise/robust.h, in standard deviations.
constexpr double kHuberTuning = 2.1;
constexpr double kCauchyTuning = 2.67;
// That of a loss; infinite without one.
double LossTuning(LossKind loss);

// rho with rho' the weights of noise/robust.h; null without a loss. The ceres::Problem that it is added to owns it.
ceres::LossFunction* MakeLossFunction(LossKind loss);

}  // namespace sagitta
