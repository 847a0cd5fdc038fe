#include "estimator/diagnosis/thermal_lag.h"

#include <algorithm>

#include "estimator/diagnosis/setting_profile.h"
#include "estimator/statistics/distributions.h"
#include "models/effects/catalogue.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kLongestLag = 1800.0, kLagSpacing = 60.0;  // s
constexpr double kBeyondOwn = 2.0;                          // times the lag that the effect states, where that is more
constexpr const char* kLagSetting = "lag_s";
constexpr int kDigitsOfLag = 4;         // of a lag in s
constexpr double kBetweenShots = 60.0;  // s, where no time is stated

bool IsDrivenByTemperature(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  return definition != nullptr && definition->driven_by == EffectDriver::kTemperature;
}

bool IsTimed(const Measurements& data) {
  return std::all_of(data.shots.begin(), data.shots.end(), [](const Shot& shot) { return shot.has_time; });
}

// With the clock that the lags count by.
CalibrationProblem WithClock(const CalibrationProblem& problem) {
  CalibrationProblem timed = problem;
  std::vector<Shot>& shots = timed.mutable_data()->shots;
  for (size_t s = 0; s < shots.size(); ++s) {
    shots[s].has_time = true;
    shots[s].time = kBetweenShots * static_cast<double>(s);
  }
  timed.RenewShots();
  return timed;
}

double OwnLag(const EffectSpec& spec) { return spec.NumberSetting(kLagSetting, 0.0); }

EffectSpec WithLag(EffectSpec spec, double lag) {
  spec.settings.erase(kLagSetting);
  if (lag > 0.0) spec.settings[kLagSetting] = Significant(lag, kDigitsOfLag);
  return spec;
}

// From no lag on; empty where that one does not converge.
std::vector<FitAt> FitLags(const DiagnosedModel& final, const EffectSpec& spec) {
  DiagnosedModel model = final;
  if (!IsTimed(final.problem->data())) model.problem = std::make_shared<CalibrationProblem>(WithClock(*final.problem));
  const double longest = std::max(kLongestLag, kBeyondOwn * OwnLag(spec));
  const double spacing = kLagSpacing * longest / kLongestLag;
  std::vector<FitAt> fits;
  for (double lag = 0.0; lag <= longest; lag += spacing) {
    const EffectSpec late = WithLag(spec, lag);
    const DiagnosedModel other = WithInstead(model, spec, late);
    QuickRefit refit = RefitQuickly(*other.problem, other.estimate.parameters);
    const bool has_converged = IsUsable(refit.estimate.status);
    if (!has_converged && lag == 0.0) break;
    if (has_converged) fits.push_back({lag, late, std::move(refit)});
  }
  return fits;
}

}  // namespace

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
