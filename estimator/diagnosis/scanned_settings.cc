#include "estimator/diagnosis/scanned_settings.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/refit_order.h"
#include "estimator/diagnosis/setting_values.h"
#include "estimator/statistics/distributions.h"
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

constexpr const char* kLagSetting = "lag_s";
// s. A wall of steel of d = 5 mm follows still air, h = 10 W/(m^2 K), by rho c d / h = 7850 470 0.005 / 10 = 1800 s.
constexpr double kLongestLag = 1800.0;
constexpr double kBeyondOwn = 2.0;      // times the lag that the effect states, where that is more
constexpr double kBetweenShots = 60.0;  // s, assumed where no time is stated: a pose a minute
constexpr int kScannedLags = 30;        // a minute apart, as shots are

// The model refitted at one value of the number.
struct FitAt {
  double at = 0.0;  // the number, SI or the setting's own unit
  EffectSpec spec;  // what the effect is called in this fit
  QuickRefit refit;

  double chi2() const { return refit.estimate.chi2; }
};

// The one with the least chi-square. fits: not empty.
const FitAt& BestOf(const std::vector<FitAt>& fits) {
  return *std::min_element(fits.begin(), fits.end(),
                           [](const FitAt& a, const FitAt& b) { return a.chi2() < b.chi2(); });
}

// The model with `changed` in place of an effect that it has, at the same values, not yet refitted. Both have the same
// parameters.
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
    parameters.coordinate(own).effect_prior = old.effect_prior;
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

// Of a fit, the coordinate of a row that `spec` has in the final model.
int CoordinateOf(const FitAt& fit, const EffectSpec& spec, const ParameterEstimate& row) {
  return fit.refit.estimate.parameters.FindCoordinate(fit.spec.Path() + row.name.substr(spec.Path().size()));
}

// Of the noise that a row's interval goes by, in that of the refit at `own`; 0 where that does not determine the row.
double NoiseOfRow(const std::vector<FitAt>& fits, double own, const EffectSpec& spec, const ParameterEstimate& row) {
  const FitAt& near = *std::min_element(fits.begin(), fits.end(), [own](const FitAt& a, const FitAt& b) {
    return std::abs(a.at - own) < std::abs(b.at - own);
  });
  const int c = CoordinateOf(near, spec, row);
  const double sigma = c < 0 ? 0.0 : near.refit.sigmas[c];
  return sigma > 0.0 ? row.sigma / sigma : 0.0;
}

// own: the number of that row's fit, of which the noise is.
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

// The model refitted at each value; without those where it does not converge.
std::vector<FitAt> FitSettings(const DiagnosedModel& model, const EffectSpec& spec, const std::string& setting,
                               const std::vector<double>& values) {
  std::vector<FitAt> fits;
  for (const double value : values) {
    const EffectSpec changed = At(spec, setting, value);
    const bool is_own = value == spec.NumberSetting(setting, 0.0);
    const DiagnosedModel other = WithInstead(model, spec, is_own ? spec : changed);
    QuickRefit refit = RefitQuickly(*other.problem, other.estimate.parameters);
    if (IsUsable(refit.estimate.status)) fits.push_back({value, is_own ? spec : changed, std::move(refit)});
  }
  return fits;
}

// Where the parabola through the best fit and its neighbours, in the logarithm of the number, is least.
double LeastOf(const std::vector<FitAt>& fits) {
  const size_t best = static_cast<size_t>(&BestOf(fits) - fits.data());
  if (best == 0 || best + 1 == fits.size()) return fits[best].at;
  const double left = std::log(fits[best - 1].at / fits[best].at), right = std::log(fits[best + 1].at / fits[best].at);
  const double a = (fits[best - 1].chi2() - fits[best].chi2()) / left;
  const double b = (fits[best + 1].chi2() - fits[best].chi2()) / right;
  const double curvature = (b - a) / (right - left);  // a = slope + curvature left, b = slope + curvature right
  if (!(curvature > 0.0)) return fits[best].at;
  return fits[best].at * std::exp(-0.5 * (a - curvature * left) / curvature);
}

bool IsTimed(const Measurements& data) {
  return std::all_of(data.shots.begin(), data.shots.end(), [](const Shot& shot) { return shot.has_time; });
}

// With the clock that lags count by: where the shots state no time, they are assumed to be in their order. If that is
// wrong, the data contradict all but short lags, and little is widened.
DiagnosedModel WithClock(DiagnosedModel model) {
  if (IsTimed(model.problem->data())) return model;
  model.problem = std::make_shared<CalibrationProblem>(*model.problem);
  std::vector<Shot>& shots = model.problem->mutable_data()->shots;
  for (size_t s = 0; s < shots.size(); ++s) {
    shots[s].has_time = true;
    shots[s].time = kBetweenShots * static_cast<double>(s);
  }
  model.problem->RenewShots();
  return model;
}

// From none on.
std::vector<double> LagsFor(double own) {
  const double longest = std::max(kLongestLag, kBeyondOwn * own);
  std::vector<double> lags;
  for (int k = 0; k <= kScannedLags; ++k) lags.push_back(longest * k / kScannedLags);
  return lags;
}

// Where the root of chi-square's excess over the least, which is straight near the best number, passes that of
// `allowed` between two neighbours, of which one has less and one more.
double CrossingOf(const FitAt& less, const FitAt& more, double least, double allowed) {
  const double inner = std::sqrt(less.chi2() - least), outer = std::sqrt(more.chi2() - least);
  return less.at + (more.at - less.at) * (std::sqrt(allowed) - inner) / (outer - inner);
}

// fits: ascending. noise: as of NoiseOfRow, greater than 0.
PossibleNumbers PossibleOf(const std::vector<FitAt>& fits, const std::string& setting, double noise) {
  const size_t best = static_cast<size_t>(&BestOf(fits) - fits.data());
  const double least = fits[best].chi2(), allowed = ChiSquareQuantile(0.95, 1.0) * noise * noise;
  const auto is_possible = [=](const FitAt& fit) { return fit.chi2() <= least + allowed; };
  const size_t first = static_cast<size_t>(std::find_if(fits.begin(), fits.end(), is_possible) - fits.begin());
  const size_t end = static_cast<size_t>(fits.rend() - std::find_if(fits.rbegin(), fits.rend(), is_possible));
  PossibleNumbers numbers;
  numbers.setting = setting;
  numbers.best = fits[best].at;
  numbers.is_open_below = first == 0;
  numbers.is_open_above = end == fits.size();
  numbers.least = first == 0 ? fits[0].at : CrossingOf(fits[first], fits[first - 1], least, allowed);
  numbers.most = end == fits.size() ? fits[end - 1].at : CrossingOf(fits[end - 1], fits[end], least, allowed);
  return numbers;
}

// Of the first row whose scatter the rows determine; 0 where there is none.
double NoiseOfRows(const std::vector<FitAt>& fits, double own, const EffectSpec& spec,
                   const std::vector<ParameterEstimate>& rows) {
  for (const ParameterEstimate& row : rows) {
    if (const double noise = NoiseOfRow(fits, own, spec, row); noise > 0.0) return noise;
  }
  return 0.0;
}

// Whether this use goes with a temperature that it may lag behind.
bool MayLag(const EffectDefinition& definition, const EffectSpec& spec) {
  const bool has_lag = std::any_of(definition.settings.begin(), definition.settings.end(),
                                   [](const SettingDefinition& setting) { return setting.name == kLagSetting; });
  return has_lag && definition.DrivenBy(spec) == EffectDriver::kTemperature;
}

}  // namespace

double TuneSettings(const Evidence& evidence, const JointOptions& joint, RefittedSet* refitted) {
  if (!refitted->IsUsable()) return 0.0;
  double gain = 0.0;
  for (size_t k = 0; k < refitted->effects.size(); ++k) {
    const EffectSpec spec = refitted->effects[k].candidate.spec;
    const SettingDefinition* setting = ScannedDefinition(evidence.robot(), spec);
    if (setting == nullptr) continue;
    const double own = spec.NumberSetting(setting->name, 0.0);
    const std::vector<FitAt> fits = FitSettings(refitted->with_effects, spec, setting->name, ScanOf(*setting, own));
    if (fits.empty()) continue;
    RefittedSet tuned = *refitted;
    ChangeTo(At(spec, setting->name, LeastOf(fits)), &tuned.effects[k].candidate);
    tuned.with_effects = Extend(tuned.lacking, CandidatesOf(tuned.effects), joint);
    if (!tuned.IsUsable()) continue;
    const double better = LogOfFull(evidence, tuned) - LogOfFull(evidence, *refitted);
    VLOG(1) << "diagnosis: " << tuned.effects[k].candidate.spec.Path() << " in place of " << spec.Path() << " adds "
            << better << " to the log likelihood";
    if (better < kInDoubt) continue;
    gain += better;
    *refitted = std::move(tuned);
  }
  return gain;
}

std::optional<PossibleNumbers> AllowForSetting(const DiagnosedModel& final, const EffectSpec& spec,
                                               std::vector<ParameterEstimate>* rows) {
  const Robot& robot = final.problem->robot();
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  const bool is_lag = definition != nullptr && MayLag(*definition, spec);
  const SettingDefinition* scanned = is_lag ? nullptr : ScannedDefinition(robot, spec);
  if (rows->empty() || (!is_lag && scanned == nullptr)) return std::nullopt;
  const std::string setting = is_lag ? kLagSetting : scanned->name;
  const double own = spec.NumberSetting(setting, 0.0);
  const std::vector<FitAt> fits = is_lag ? FitSettings(WithClock(final), spec, setting, LagsFor(own))
                                         : FitSettings(final, spec, setting, ScanOf(*scanned, own));
  const double noise = fits.empty() ? 0.0 : NoiseOfRows(fits, own, spec, *rows);
  for (ParameterEstimate& row : *rows) Widen(fits, own, spec, &row);
  if (fits.size() < 2 || !(noise > 0.0)) return std::nullopt;
  PossibleNumbers numbers = PossibleOf(fits, setting, noise);
  numbers.is_thermal_lag = is_lag;
  numbers.is_timed = IsTimed(final.problem->data());
  return numbers;
}

}  // namespace sagitta
