#include "estimator/least_squares/loss_function.h"

#include <limits>

namespace sagitta {

double LossTuning(LossKind loss) {
  if (loss == LossKind::kHuber) return kHuberTuning;
  return loss == LossKind::kCauchy ? kCauchyTuning : std::numeric_limits<double>::infinity();
}

ceres::LossFunction* MakeLossFunction(LossKind loss) {
  if (loss == LossKind::kHuber) return new ceres::HuberLoss(kHuberTuning);
  return loss == LossKind::kCauchy ? new ceres::CauchyLoss(kCauchyTuning) : nullptr;
}

}  // namespace sagitta
