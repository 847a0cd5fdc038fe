#include "estimator/diagnosis/thermal_lag.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/statistics/distributions.h"
#include "models/effects/catalogue.h"
#include "models/effects/first_order_lag.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr double kLongestLag = 1800.0, kLagSpacing = 60.0;  // s
constexpr double kBetweenShots = 60.0;                      // s, where no time is stated

// The model refitted with the arm this late.
struct LaggedFit {
  double lag = 0.0;
  QuickRefit refit;

  double chi2() const { return refit.estimate.chi2; }
};

bool IsDrivenByTemperature(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  return definition != nullptr && definition->driven_by == EffectDriver::kTemperature;
}

bool IsTimed(const Measurements& data) {
  return std::all_of(data.shots.begin(), data.shots.end(), [](const Shot& shot) { return shot.has_time; });
}

// s, one per shot.
std::vector<double> ClockOf(const Measurements& data) {
  const bool is_timed = IsTimed(data);
  std::vector<double> clock;
  for (const Shot& shot : data.shots) {
    clock.push_back(is_timed ? shot.time : kBetweenShots * static_cast<double>(clock.size()));
  }
  return clock;
}

// From no lag on; empty where that one does not converge.
std::vector<LaggedFit> FitLags(const DiagnosedModel& final) {
  std::vector<LaggedFit> fits;
  for (double lag = 0.0; lag <= kLongestLag; lag += kLagSpacing) {
    CalibrationProblem late = *final.problem;
    LagTemperatures(lag, late.mutable_data());
    late.RenewShots();
    QuickRefit refit = RefitQuickly(late, final.estimate.parameters);
    const bool has_converged = IsUsable(refit.estimate.status);
    if (!has_converged && lag == 0.0) break;
    if (has_converged) fits.push_back({lag, std::move(refit)});
  }
  return fits;
}

double LeastChiSquare(const std::vector<LaggedFit>& fits) {
  const auto less = [](const LaggedFit& a, const LaggedFit& b) { return a.chi2() < b.chi2(); };
  return std::min_element(fits.begin(), fits.end(), less)->chi2();
}

// Of the noise that the row's interval goes by, in that of the refits; 0 where they do not determine the row.
double ScaleOfFits(const std::vector<LaggedFit>& fits, const ParameterEstimate& row) {
  const int c = fits[0].refit.estimate.parameters.FindCoordinate(row.name);
  const double sigma = c < 0 ? 0.0 : fits[0].refit.sigmas[c];
  return sigma > 0.0 ? row.sigma / sigma : 0.0;
}

// The profile likelihood of one parameter: all values v with, for some lag,
//   chi2(lag) + (v - v(lag))^2 / sigma(lag)^2 <= least + q^2,
// joined with the interval at no lag, of which q is.
void Widen(const std::vector<LaggedFit>& fits, double least, ParameterEstimate* row) {
  const double noise = ScaleOfFits(fits, *row);
  if (!(noise > 0.0)) return;
  const int c = fits[0].refit.estimate.parameters.FindCoordinate(row->name);
  const double q = 0.5 * (row->ci95.high - row->ci95.low) / row->sigma;
  for (const LaggedFit& fit : fits) {
    const double left = q * q - (fit.chi2() - least) / (noise * noise);
    if (left < 0.0) continue;
    const double half = std::sqrt(left) * noise * fit.refit.sigmas[c], value = fit.refit.estimate.parameters.Value(c);
    row->ci95 = {std::min(row->ci95.low, value - half), std::max(row->ci95.high, value + half)};
  }
  row->sigma = 0.5 * (row->ci95.high - row->ci95.low) / q;
}

}  // namespace

void LagTemperatures(double lag, Measurements* data) {
  if (!(lag > 0.0)) return;
  const std::vector<double> clock = ClockOf(*data);
  std::map<int, std::vector<size_t>> series;
  for (size_t s = 0; s < data->shots.size(); ++s) series[data->shots[s].station].push_back(s);
  for (auto& [station, shots] : series) {
    std::stable_sort(shots.begin(), shots.end(), [&](size_t a, size_t b) { return clock[a] < clock[b]; });
    std::vector<double> time, air;
    for (const size_t s : shots) {
      time.push_back(clock[s]);
      air.push_back(data->shots[s].temperature);
    }
    const std::vector<double> arm = LaggedBehind(time, air, lag);
    for (size_t i = 0; i < shots.size(); ++i) data->shots[shots[i]].temperature = arm[i];
  }
}

std::optional<ThermalLag> AllowForLag(const DiagnosedModel& final, const EffectSpec& spec,
                                      std::vector<ParameterEstimate>* rows) {
  if (rows->empty() || !IsDrivenByTemperature(final.problem->robot(), spec)) return std::nullopt;
  const std::vector<LaggedFit> fits = FitLags(final);
  if (fits.size() < 2) return std::nullopt;
  const double least = LeastChiSquare(fits), noise = ScaleOfFits(fits, rows->front());
  const double within = ChiSquareQuantile(0.95, 1.0) * noise * noise;
  ThermalLag lag{0.0, kLongestLag, 0.0, IsTimed(final.problem->data())};
  for (const LaggedFit& fit : fits) {
    if (fit.chi2() == least) lag.best = fit.lag;
    if (fit.chi2() > least + within) continue;
    lag.shortest = std::min(lag.shortest, fit.lag);
    lag.longest = std::max(lag.longest, fit.lag);
  }
  for (ParameterEstimate& row : *rows) Widen(fits, least, &row);
  return lag;
}

}  // namespace sagitta
