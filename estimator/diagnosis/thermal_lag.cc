#include "estimator/diagnosis/thermal_lag.h"

#include <algorithm>
#include <map>

#include "estimator/diagnosis/setting_profile.h"
#include "estimator/statistics/distributions.h"
#include "models/effects/catalogue.h"
#include "models/effects/first_order_lag.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr double kLongestLag = 1800.0, kLagSpacing = 60.0;  // s
constexpr double kBeyondOwn = 2.0;                          // times the lag that the effect states, where that is more
constexpr const char* kLagSetting = "lag_s";
constexpr double kBetweenShots = 60.0;  // s, where no time is stated

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

double OwnLag(const EffectSpec& spec) { return spec.NumberSetting(kLagSetting, 0.0); }

EffectSpec WithoutLag(EffectSpec spec) {
  spec.settings.erase(kLagSetting);
  return spec;
}

// From no lag on; empty where that one does not converge. The effect at once in place of the effect at its own lag,
// which no lag of the temperatures undoes.
std::vector<FitAt> FitLags(const DiagnosedModel& final, const EffectSpec& spec) {
  const DiagnosedModel model = WithInstead(final, spec, WithoutLag(spec));
  const double longest = std::max(kLongestLag, kBeyondOwn * OwnLag(spec));
  const double spacing = kLagSpacing * longest / kLongestLag;
  std::vector<FitAt> fits;
  for (double lag = 0.0; lag <= longest; lag += spacing) {
    CalibrationProblem late = *model.problem;
    LagTemperatures(lag, late.mutable_data());
    late.RenewShots();
    QuickRefit refit = RefitQuickly(late, model.estimate.parameters);
    const bool has_converged = IsUsable(refit.estimate.status);
    if (!has_converged && lag == 0.0) break;
    if (has_converged) fits.push_back({lag, WithoutLag(spec), std::move(refit)});
  }
  return fits;
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
  const std::vector<FitAt> fits = FitLags(final, spec);
  if (fits.size() < 2) return std::nullopt;
  const FitAt& best = BestOf(fits);
  const double noise = NoiseOfRow(fits, OwnLag(spec), spec, rows->front());
  const double within = ChiSquareQuantile(0.95, 1.0) * noise * noise;
  ThermalLag lag{best.at, fits.back().at, 0.0, IsTimed(final.problem->data())};
  for (const FitAt& fit : fits) {
    if (fit.chi2() > best.chi2() + within) continue;
    lag.shortest = std::min(lag.shortest, fit.at);
    lag.longest = std::max(lag.longest, fit.at);
  }
  for (ParameterEstimate& row : *rows) Widen(fits, OwnLag(spec), spec, &row);
  return lag;
}

}  // namespace sagitta
