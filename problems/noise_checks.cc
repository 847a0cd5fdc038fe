#include "problems/noise_checks.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "problems/input_error.h"
#include "problems/problem_checks.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using From = NoiseSpec::From;

// The noise differs between rows or axes: equal weights are not those of the noise.
bool RowsDiffer(const CalibrationProblem& problem) {
  const From from = problem.experiment().noise.from;
  if (from == From::kInstrument || from == From::kRepeats) return true;
  double low = std::numeric_limits<double>::infinity(), high = 0.0;
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    const Vector3<double> sigma = problem.SqrtCovariance(static_cast<int>(i)).diagonal();
    low = std::min(low, sigma.minCoeff());
    high = std::max(high, sigma.maxCoeff());
  }
  return high > low * (1.0 + 1e-9);  // beyond rounding
}

void CheckInstrument(const CalibrationProblem& problem) {
  const NoiseSpec& noise = problem.experiment().noise;
  if (noise.from != From::kInstrument) return;
  if (noise.range + noise.range_per_m > 0.0 && noise.angle + noise.angle_per_m > 0.0) return;
  FailProblem(problem, "noise.instrument",
              "an instrument that is exact along or across its line of sight is not believed",
              "state range_um or range_um_per_m, and angle_um or angle_um_per_m");
}

// Spread of residuals holds everything that scatters: nothing else can be separated from it.
void CheckResiduals(const CalibrationProblem& problem) {
  const Experiment& experiment = problem.experiment();
  if (experiment.noise.from != From::kResiduals) return;
  if (!experiment.repeatability.IsZero()) {
    FailProblem(problem, "noise.from", "the residuals contain the repeatability already, which is asked for as well",
                "use {from: variance-components}, or leave repeatability out");
  }
  if (experiment.method.loss != LossKind::kNone) {
    FailProblem(problem, "loss", "a loss needs noise that outliers do not widen; that of residuals they do",
                "state noise: {sigma_mm: …}, or use loss: none");
  }
}

// Weights other than the noise's: the noise has to be known per row, and be all that scatters.
void CheckWeights(const CalibrationProblem& problem) {
  const Experiment& experiment = problem.experiment();
  const From from = experiment.noise.from;
  const std::vector<bool> oriented = problem.data().OrientedMarkers();
  const bool has_poses = std::find(oriented.begin(), oriented.end(), true) != oriented.end();
  if (has_poses && (experiment.method.weights != Weights::kSigma || from == From::kResiduals)) {
    FailProblem(problem, experiment.method.weights != Weights::kSigma ? "weights" : "noise.from",
                "these weights are of points, the data have rotations of poses too: the two compare by standard "
                "deviations only",
                "use weights: sigma, with sigma columns or noise: {sigma_mm: …}");
  }
  if (experiment.method.weights == Weights::kSigma || from == From::kResiduals || from == From::kVarianceComponents) {
    if (experiment.method.weights == Weights::kEq14 && from == From::kVarianceComponents) {
      FailProblem(problem, "weights", "eq. (14) weighs standard deviations of rows, per axis", "use weights: sigma");
    }
    return;
  }
  const bool is_eq14 = experiment.method.weights == Weights::kEq14;
  const char* kHint = "use weights: sigma";
  if (is_eq14 && (from == From::kInstrument || from == From::kRepeats)) {
    FailProblem(problem, "weights", "eq. (14) weighs standard deviations of rows, per axis", kHint);
  }
  if (is_eq14 && !problem.sigma_is_stated()) {
    FailProblem(problem, "weights", "eq. (14) needs standard deviations, and nothing states them",
                "add sigma columns, or noise: {from: residuals}");
  }
  if (!is_eq14 && !RowsDiffer(problem)) return;  // the noise's own weights, or sigma is estimated
  const std::string which = is_eq14 ? "eq. (14)" : "eq. (8) for equal weights";
  if (!experiment.repeatability.IsZero()) FailProblem(problem, "weights", which + " knows no repeatability", kHint);
  if (experiment.method.loss != LossKind::kNone)
    FailProblem(problem, "weights", which + " does not go with a loss", kHint);
  if (experiment.method.covariance == CovarianceKind::kProfile) {
    FailProblem(problem, "covariance",
                "a profile likelihood weighs by the noise, the fit by weights: " + WordOf(experiment.method.weights),
                "use covariance: model, sandwich or bootstrap");
  }
}

void CheckRows(const CalibrationProblem& problem) {
  if (problem.experiment().noise.from != From::kRows || problem.sigma_is_stated()) return;
  FailProblem(problem, "noise.from", "no row states a standard deviation",
              "add the columns sigma_x_mm, sigma_y_mm, sigma_z_mm, or state noise: {sigma_mm: …}");
}

// In the unit that the file has.
std::string KeyOfRepeatability(const Experiment& experiment) {
  const std::string stem = "repeatability_";
  std::vector<std::string> units(std::begin(RepeatabilitySpec::kAngleUnits), std::end(RepeatabilitySpec::kAngleUnits));
  units.insert(units.end(), std::begin(RepeatabilitySpec::kLengthUnits), std::end(RepeatabilitySpec::kLengthUnits));
  const auto stated = std::find_if(units.begin(), units.end(),
                                   [&](const auto& unit) { return experiment.lines.count(stem + unit) > 0; });
  return stem + (stated == units.end() ? units.front() : *stated);
}

}  // namespace

void CheckNoise(CalibrationProblem* problem) {
  const Experiment& experiment = problem->experiment();
  if (experiment.noise.from == From::kVarianceComponents && experiment.repeatability.IsZero()) {
    RepeatabilitySpec& repeatability = problem->mutable_experiment()->repeatability;
    repeatability.angle.estimate = repeatability.length.estimate = true;
  }
  CheckInstrument(*problem);
  CheckRows(*problem);
  CheckResiduals(*problem);
  CheckWeights(*problem);
}

void ResolveRepeats(CalibrationProblem* problem) {
  if (problem->experiment().noise.from != From::kRepeats) return;
  problem->repeat_scatter = PooledRepeats(problem->data());
  if (!problem->repeat_scatter) {
    FailProblem(*problem, "noise.from", "no marker was shot twice at one visit under one load: there are no repeats",
                "measure repeats (column repeat), or state noise: {sigma_mm: …}");
  }
  const Vector3<double> sigma = problem->repeat_scatter->sigma;
  if (sigma.minCoeff() <= 0.0) {
    FailProblem(*problem, "noise.from", "repeated shots are equal to the last digit: they show no noise",
                "measure again instead of copying rows, or state noise: {sigma_mm: …}");
  }
  const Vector3<double>& turned = problem->repeat_scatter->rotation_sigma;
  NoiseRoots roots;
  for (const Observation& observation : problem->data().observations) {
    if (observation.is_point()) {
      roots.push_back(sigma.asDiagonal());
    } else if (turned.minCoeff() > 0.0) {
      roots.push_back(turned.asDiagonal());
    } else {
      const bool states = observation.rotation().sigma.minCoeff() > 0.0;
      const Vector3<double> unstated = Vector3<double>::Constant(kUnstatedRotationSigma);
      roots.push_back((states ? observation.rotation().sigma : unstated).asDiagonal());
    }
  }
  problem->resolved_noise = roots;
  problem->noise_origin = NoiseOrigin::kRepeats;
}

void SayRotationSigmas(CalibrationProblem* problem) {
  const bool is_stated = problem->sigma_is_stated();
  const std::optional<RepeatScatter>& repeats = problem->repeat_scatter;
  if (is_stated && repeats && repeats->rotation_sigma.minCoeff() > 0.0) return;
  int unstated = 0, stated = 0;
  for (const Observation& observation : problem->data().observations) {
    if (observation.is_point()) continue;
    ++(observation.rotation().sigma.minCoeff() > 0.0 ? stated : unstated);
    if (is_stated || stated == 0) continue;
    throw InputError(problem->data().WhereOf(observation, "sigma_x_mm"),
                     "the rotations state standard deviations, the points none: nothing says how the two compare",
                     "add sigma_x_mm, sigma_y_mm, sigma_z_mm, or state noise: {sigma_mm: …}");
  }
  if (unstated == 0) return;
  const bool is_open = repeats && stated == 0;  // too few repeats of rotations
  problem->mutable_data()->warnings.push_back(
      std::to_string(unstated) + " poses state no standard deviation of their rotation: " +
      (is_stated && !is_open ? "calibrate assumes 1 mrad, that of 1 mm over 1 m, diagnose estimates it"
                             : "it is estimated where the readings determine it") +
      "; add the column sigma_rot_urad");
}

void CheckSigmas(const CalibrationProblem& problem) {
  if (!problem.sigma_is_stated()) {
    if (problem.latent.empty() || problem.experiment().noise.from == From::kVarianceComponents) return;
    FailProblem(problem, KeyOfRepeatability(problem.experiment()),
                "the repeatability is stated but the instrument's noise is not",
                "state noise: {sigma_mm: …}, sigma columns, --sigma_mm, or noise: {from: variance-components}");
  }
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    if (IsStated(problem.SqrtCovariance(static_cast<int>(i)))) continue;
    const Observation& observation = problem.data().observations[i];
    throw InputError(problem.data().WhereOf(observation, "sigma_x_mm"),
                     "other rows state standard deviations, this one has none",
                     "add the columns, state noise: {sigma_mm: …}, or give --sigma_mm");
  }
}

void SayReplacedSigmas(CalibrationProblem* problem) {
  const NoiseSpec& noise = problem->experiment().noise;
  const bool is_replaced =
      noise.from == From::kInstrument || noise.from == From::kRepeats || noise.from == From::kResiduals;
  if (!is_replaced) return;
  const Measurements& data = problem->data();
  const auto states = [](const Observation& row) { return row.is_point() && row.sigma.minCoeff() > 0.0; };
  const auto stated = std::count_if(data.observations.begin(), data.observations.end(), states);
  if (stated == 0) return;
  const auto first = std::find_if(data.observations.begin(), data.observations.end(), states);
  problem->mutable_data()->warnings.push_back(
      "noise: of the experiment is that of every row: the standard deviations that " + std::to_string(stated) +
      " rows state are not used (the first: " + data.SourceOf(*first) + ")");
}

namespace {

constexpr size_t kFewestRounded = 4;  // rows: 12 coordinates that are round by chance once in 10^12 files

// The largest power of ten, m, that all coordinates are multiples of; 0: they have digits below a micrometre.
double DecimalStep(const std::vector<Vector3<double>>& points) {
  constexpr double kDigits = 1e-6;  // of a step: what a number that was read from a file is off by
  for (const double step : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    const bool is_rounded = std::all_of(points.begin(), points.end(), [step](const Vector3<double>& point) {
      const Eigen::Array3d steps = point.array() / step;
      return (steps - steps.round()).abs().maxCoeff() <= kDigits;
    });
    if (is_rounded) return step;
  }
  return 0.0;
}

}  // namespace

void SayRounding(CalibrationProblem* problem) {
  const Measurements& data = problem->data();
  if (problem->experiment().noise.from == From::kRepeats) return;
  std::vector<std::string> warnings;
  for (size_t station = 0; station < data.stations.size(); ++station) {
    std::vector<Vector3<double>> points;
    double variance = 0.0;  // m^2, mean of the axes
    for (size_t i = 0; i < data.observations.size(); ++i) {
      const Observation& row = data.observations[i];
      const bool is_read = row.is_point() && row.point_in_station.allFinite() && !row.point_in_station.isZero(0.0);
      if (!is_read || data.shots[row.shot].station != static_cast<int>(station)) continue;
      points.push_back(row.point_in_station);
      variance += problem->SqrtCovariance(static_cast<int>(i)).squaredNorm() / 3.0;
    }
    if (points.size() < kFewestRounded || variance == 0.0) continue;
    const double sigma = std::sqrt(variance / static_cast<double>(points.size()));
    const double step = DecimalStep(points), of_rounding = step / std::sqrt(12.0);
    if (of_rounding <= sigma) continue;
    const std::string least = InMillimetres(of_rounding);
    warnings.push_back("the readings of station " + data.stations[station] + " are rounded to " +
                       Significant(1e3 * step, 1) + " mm: that alone has a standard deviation of " + least +
                       " (step / sqrt(12)), the stated one is " + InMillimetres(sigma) +
                       "; export more digits, or state at least " + least);
  }
  for (std::string& warning : warnings) problem->mutable_data()->warnings.push_back(std::move(warning));
}

}  // namespace sagitta
