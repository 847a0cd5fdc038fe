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
constexpr double kBeyondOwn = 2.0;                          // times the lag that the effect states, where that is more
constexpr const char* kLagSetting = "lag_s";
constexpr double kBetweenShots = 60.0;  // s, where no time is stated

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

double OwnLag(const EffectSpec& spec) { return spec.NumberSetting(kLagSetting, 0.0); }

EffectSpec WithoutLag(EffectSpec spec) {
  spec.settings.erase(kLagSetting);
  return spec;
}

// The model with the effect at once in place of the effect at its own lag, which no lag of the temperatures undoes.
DiagnosedModel AtOnce(const DiagnosedModel& final, const EffectSpec& spec) {
  if (!(OwnLag(spec) > 0.0)) return final;
  CalibrationProblem problem = *final.problem;
  problem.parameters.CopyByName(final.estimate.parameters);
  problem = problem.WithEffects({WithoutLag(spec)});
  Eigen::VectorXd moves = Eigen::VectorXd::Zero(problem.parameters.num_coordinates());
  for (int i = 0; i < problem.parameters.num_coordinates(); ++i) {
    Coordinate& late = problem.parameters.coordinate(i);
    if (!IsParameterOf(spec, late.name)) continue;
    const std::string name = WithoutLag(spec).Path() + late.name.substr(spec.Path().size());
    const int at_once = problem.parameters.FindCoordinate(name);
    problem.parameters.coordinate(at_once).free = late.free;
    moves[at_once] = problem.parameters.Value(i);
    moves[i] = -problem.parameters.Value(i);
    late.free = false;
  }
  problem.parameters.Plus(moves);
  DiagnosedModel model = final;
  model.estimate.parameters = problem.parameters;
  model.problem = std::make_shared<CalibrationProblem>(std::move(problem));
  return model;
}

// From no lag on; empty where that one does not converge.
std::vector<LaggedFit> FitLags(const DiagnosedModel& final, const EffectSpec& spec) {
  const DiagnosedModel model = AtOnce(final, spec);
  const double longest = std::max(kLongestLag, kBeyondOwn * OwnLag(spec));
  const double spacing = kLagSpacing * longest / kLongestLag;
  std::vector<LaggedFit> fits;
  for (double lag = 0.0; lag <= longest; lag += spacing) {
    CalibrationProblem late = *model.problem;
    LagTemperatures(lag, late.mutable_data());
    late.RenewShots();
    QuickRefit refit = RefitQuickly(late, model.estimate.parameters);
    const bool has_converged = IsUsable(refit.estimate.status);
    if (!has_converged && lag == 0.0) break;
    if (has_converged) fits.push_back({lag, std::move(refit)});
  }
  return fits;
}

// The fit with the least of this value.
template <typename Value>
const LaggedFit& Least(const std::vector<LaggedFit>& fits, const Value& of) {
  return *std::min_element(fits.begin(), fits.end(),
                           [&of](const LaggedFit& a, const LaggedFit& b) { return of(a) < of(b); });
}

// Of the fits, the coordinate of a row of the effect.
int CoordinateOf(const std::vector<LaggedFit>& fits, const EffectSpec& spec, const ParameterEstimate& row) {
  const std::string name = WithoutLag(spec).Path() + row.name.substr(spec.Path().size());
  return fits[0].refit.estimate.parameters.FindCoordinate(name);
}

// Of the noise that the row's interval goes by, in that of the refit at the effect's own lag; 0 where that does not
// determine the row.
double ScaleOfFits(const std::vector<LaggedFit>& fits, const EffectSpec& spec, const ParameterEstimate& row) {
  const int c = CoordinateOf(fits, spec, row);
  const LaggedFit& own = Least(fits, [&spec](const LaggedFit& fit) { return std::abs(fit.lag - OwnLag(spec)); });
  const double sigma = c < 0 ? 0.0 : own.refit.sigmas[c];
  return sigma > 0.0 ? row.sigma / sigma : 0.0;
}

// The profile likelihood of one parameter: all values v with, for some lag,
//   chi2(lag) + (v - v(lag))^2 / sigma(lag)^2 <= least + q^2,
// joined with the interval at the effect's own lag, of which q is.
void Widen(const std::vector<LaggedFit>& fits, const EffectSpec& spec, double least, ParameterEstimate* row) {
  const double noise = ScaleOfFits(fits, spec, *row);
  if (!(noise > 0.0)) return;
  const int c = CoordinateOf(fits, spec, *row);
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
  const std::vector<LaggedFit> fits = FitLags(final, spec);
  if (fits.size() < 2) return std::nullopt;
  const LaggedFit& best = Least(fits, [](const LaggedFit& fit) { return fit.chi2(); });
  const double noise = ScaleOfFits(fits, spec, rows->front());
  const double within = ChiSquareQuantile(0.95, 1.0) * noise * noise;
  ThermalLag lag{best.lag, fits.back().lag, 0.0, IsTimed(final.problem->data())};
  for (const LaggedFit& fit : fits) {
    if (fit.chi2() > best.chi2() + within) continue;
    lag.shortest = std::min(lag.shortest, fit.lag);
    lag.longest = std::max(lag.longest, fit.lag);
  }
  for (ParameterEstimate& row : *rows) Widen(fits, spec, best.chi2(), &row);
  return lag;
}

}  // namespace sagitta
