#include "estimator/calibration/effect_priors.h"

#include <algorithm>
#include <cmath>

namespace sagitta {
namespace {

constexpr double kMovesPrior = 0.05;  // of its width: moves what it holds by less than a tenth of its deviation

}  // namespace

bool AnyEffectPrior(const ParameterSet& parameters) {
  const std::vector<Coordinate>& all = parameters.coordinates();
  return std::any_of(all.begin(), all.end(),
                     [](const Coordinate& coordinate) { return coordinate.free && coordinate.effect_prior > 0.0; });
}

bool ScaleEffectPriors(double scale, ParameterSet* parameters) {
  bool moved = false;
  for (int i = 0; i < parameters->num_coordinates(); ++i) {
    Coordinate& coordinate = parameters->coordinate(i);
    if (!(coordinate.effect_prior > 0.0)) continue;
    const double sigma = coordinate.effect_prior / scale;
    moved = moved || std::abs(sigma / coordinate.prior_sigma - 1.0) > kMovesPrior;
    coordinate.prior_sigma = sigma;
  }
  return moved;
}

}  // namespace sagitta
