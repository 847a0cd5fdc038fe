#include "estimator/diagnosis/setting_profile.h"

#include <algorithm>
#include <cmath>

namespace sagitta {
namespace {

// Of a fit, the coordinate of a row that `spec` has in the final model.
int CoordinateOf(const FitAt& fit, const EffectSpec& spec, const ParameterEstimate& row) {
  return fit.refit.estimate.parameters.FindCoordinate(fit.spec.Path() + row.name.substr(spec.Path().size()));
}

}  // namespace

const FitAt& BestOf(const std::vector<FitAt>& fits) {
  return *std::min_element(fits.begin(), fits.end(),
                           [](const FitAt& a, const FitAt& b) { return a.chi2() < b.chi2(); });
}

DiagnosedModel WithInstead(const DiagnosedModel& model, const EffectSpec& spec, const EffectSpec& changed) {
  if (changed.Path() == spec.Path()) return model;
  CalibrationProblem problem = *model.problem;
  problem.parameters.CopyByName(model.estimate.parameters);
  problem = problem.WithEffects({changed});
  ParameterSet& parameters = problem.parameters;
  Eigen::VectorXd moves = Eigen::VectorXd::Zero(parameters.num_coordinates());
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    Coordinate& old = parameters.coordinate(i);
    if (!IsParameterOf(spec, old.name)) continue;
    const int own = parameters.FindCoordinate(changed.Path() + old.name.substr(spec.Path().size()));
    parameters.coordinate(own).free = old.free;
    parameters.coordinate(own).prior_sigma = old.prior_sigma;
    moves[own] = parameters.Value(i);
    moves[i] = -parameters.Value(i);
    old.free = false;
  }
  parameters.Plus(moves);
  DiagnosedModel swapped = model;
  swapped.estimate.parameters = parameters;
  swapped.problem = std::make_shared<CalibrationProblem>(std::move(problem));
  return swapped;
}

double NoiseOfRow(const std::vector<FitAt>& fits, double own, const EffectSpec& spec, const ParameterEstimate& row) {
  const FitAt& near = *std::min_element(fits.begin(), fits.end(), [own](const FitAt& a, const FitAt& b) {
    return std::abs(a.at - own) < std::abs(b.at - own);
  });
  const int c = CoordinateOf(near, spec, row);
  const double sigma = c < 0 ? 0.0 : near.refit.sigmas[c];
  return sigma > 0.0 ? row.sigma / sigma : 0.0;
}

void Widen(const std::vector<FitAt>& fits, double own, const EffectSpec& spec, ParameterEstimate* row) {
  const double noise = NoiseOfRow(fits, own, spec, *row);
  if (!(noise > 0.0)) return;
  const double least = BestOf(fits).chi2();
  const double q = 0.5 * (row->ci95.high - row->ci95.low) / row->sigma;
  for (const FitAt& fit : fits) {
    const double left = q * q - (fit.chi2() - least) / (noise * noise);
    if (left < 0.0) continue;
    const int c = CoordinateOf(fit, spec, *row);
    const double half = std::sqrt(left) * noise * fit.refit.sigmas[c], value = fit.refit.estimate.parameters.Value(c);
    row->ci95 = {std::min(row->ci95.low, value - half), std::max(row->ci95.high, value + half)};
  }
  row->sigma = 0.5 * (row->ci95.high - row->ci95.low) / q;
}

}  // namespace sagitta
