#include "estimator/noise/rotation_noise.h"

#include <algorithm>
#include <cmath>

#include "estimator/least_squares/linearization.h"
#include "estimator/noise/residual_noise.h"
#include "estimator/noise/robot_scatter.h"
#include "estimator/noise/variance_components.h"
#include "estimator/statistics/distributions.h"
#include "models/matrix_functions.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

constexpr int kLeastDof = 30;  // a standard deviation from fewer is known worse than to an eighth
// Of rotations alone: Student's t with less has neither mean nor, beyond any quantile, an interval.
constexpr double kLeastOfRotations = 1.0;
constexpr int kScaleSteps = 200;         // a guard: kSettledScale ends them
constexpr double kSettledScale = 1e-12;  // relative, of a square

bool HasRotations(const CalibrationProblem& problem) {
  const std::vector<int> all = problem.CalibrationObservations();
  return problem.data().PointsAmong(all).size() < all.size();
}

bool IsLeftOpen(const CalibrationProblem& problem, const Estimate& estimate) {
  const Experiment& experiment = problem.experiment();
  return ShowsSpread(estimate) && experiment.method.weights == Weights::kSigma &&
         experiment.method.loss == LossKind::kNone;
}

// f s^2 / sigma^2 is chi-square with f.
void SetInterval(double f, VarianceComponent* component) {
  const double least = std::max(kLeastOfRotations, f);
  component->sigma = component->value / std::sqrt(2.0 * least);
  component->low = component->value * std::sqrt(least / ChiSquareQuantile(kUpperOf95, least));
  component->high = component->value * std::sqrt(least / ChiSquareQuantile(0.025, least));
}

// Points, then rotations, with the roots that they make; empty where one of them is not shown.
std::vector<NoiseGroup> SpreadOfEach(const CalibrationProblem& problem, const Estimate& estimate, NoiseRoots* roots) {
  if (!HasRotations(problem)) return {};
  RowGroups groups{{}, {"points", "rotations"}};
  for (const Observation& observation : problem.data().observations) {
    groups.group.insert(groups.group.end(), 3, observation.is_point() ? 0 : 1);
  }
  std::vector<NoiseGroup> found;
  *roots = SpreadOfResiduals(problem, estimate, groups, &found);
  if (found.size() < 2 || found[1].freedom < kLeastOfRotations) return {};
  if (std::min(found[0].sigma, found[1].sigma) <= kResidualFloor) return {};
  return found;
}

// Root mean square of S^-1 r, of the coordinates that the fit leaves of these points: freedom.
double WhitenedSpreadOfPoints(const CalibrationProblem& stated, const std::vector<int>& points,
                              const Estimate& estimate, double freedom) {
  double sum = 0.0;
  for (const int i : points) {
    const Vector3<double> residual = stated.data().observations[i].point_in_station - estimate.predicted.col(i);
    sum += (stated.SqrtCovariance(i).inverse() * residual).squaredNorm();
  }
  return std::sqrt(sum / freedom);
}

// What rotations scatter by, and points over the noise at hand.
struct SpreadOfKinds {
  double rotations = 0.0, freedom = 0.0;  // rad, and its degrees
  double points = 1.0;
};

// Each joint by itself, as the problem has it.
std::vector<DeviationGroup> StatedDeviations(const LatentModel& latent) {
  std::vector<DeviationGroup> groups;
  for (int i = 0; i < latent.size(); ++i) {
    groups.push_back({{latent.joints[i]}, latent.sigmas[i] * latent.sigmas[i], false});
  }
  return groups;
}

// Two components, of points and of rotations, next to what the joints do. All rotations have one root, a multiple of 1.
std::optional<SpreadOfKinds> SpreadGivenDeviations(const CalibrationProblem& weighed, const Estimate& estimate) {
  const std::vector<int> rows = weighed.CalibrationObservations();
  const auto turned =
      std::find_if(rows.begin(), rows.end(), [&](int i) { return !weighed.data().observations[i].is_point(); });
  if (turned == rows.end()) return std::nullopt;
  const RestrictedLikelihood reml(weighed, estimate.parameters, true);
  const RemlFit fit = reml.Maximise(true, StatedDeviations(weighed.latent));
  const double of_points = fit.variances[0], of_rotations = fit.variances[1], variance = fit.covariance(1, 1);
  if (!fit.converged || !(variance > 0.0) || !(of_points > 0.0)) return std::nullopt;
  const double freedom = 2.0 * of_rotations * of_rotations / variance;  // var(s^2) = 2 sigma^4 / f
  const double spread = std::sqrt(of_rotations) * weighed.SqrtCovariance(*turned)(0, 0);
  if (freedom < kLeastOfRotations || spread <= kResidualFloor) return std::nullopt;
  return SpreadOfKinds{spread, freedom, std::sqrt(of_points)};
}

std::optional<SpreadOfKinds> FindSpreads(const CalibrationProblem& stated, const CalibrationProblem& weighed,
                                         const Estimate& estimate) {
  if (!weighed.latent.empty()) return SpreadGivenDeviations(weighed, estimate);
  NoiseRoots roots;
  const std::vector<NoiseGroup> found = SpreadOfEach(weighed, estimate, &roots);
  if (found.empty()) return std::nullopt;
  const std::vector<int> points = weighed.data().PointsAmong(weighed.CalibrationObservations());
  return SpreadOfKinds{found[1].sigma, found[1].freedom,
                       WhitenedSpreadOfPoints(stated, points, estimate, found[0].freedom)};
}

// 1 - h of each reading that is fitted, the mean over its axes.
std::vector<double> FreedomOfReadings(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const std::vector<int> rows = problem.CalibrationObservations();
  const std::vector<int> columns = parameters.EstimatedCoordinates();
  Linearization here = Linearize(problem, parameters, rows, columns, FitRoots(problem, rows, kFallbackSigma));
  AppendPriors(parameters, &here);
  std::vector<double> freedom(rows.size(), 1.0);
  if (columns.empty()) return freedom;
  const Eigen::MatrixXd covariance = SolveLinearization(here).covariance;
  for (size_t k = 0; k < rows.size(); ++k) {
    const Eigen::MatrixXd own = here.jacobian.middleRows<3>(3 * static_cast<Eigen::Index>(k));
    freedom[k] = std::max(kLeastFreedom, 1.0 - (own * covariance).cwiseProduct(own).sum() / 3.0);
  }
  return freedom;
}

// s^2 of proposal 2, of squares of distances; 0: they are zero.
double HuberSquare(const std::vector<double>& squares) {
  const double limit = kHuberTuning * kHuberTuning;
  // E min(X, c) of X = chi2_3: 3 P(chi2_5 < c) + c P(chi2_3 > c).
  const double clean = 3.0 * (1.0 - ChiSquareSurvival(limit, 5.0)) + limit * ChiSquareSurvival(limit, 3.0);
  double square = Median(squares) / ChiSquareQuantile(0.5, 3.0);
  for (int step = 0; step < kScaleSteps && square > 0.0; ++step) {
    double sum = 0.0;
    for (const double own : squares) sum += std::min(own / square, limit);
    const double factor = sum / (clean * static_cast<double>(squares.size()));
    square *= factor;
    if (std::abs(factor - 1.0) < kSettledScale) break;
  }
  return square;
}

}  // namespace

bool NoRotationIsStated(const CalibrationProblem& problem) {
  const std::vector<Observation>& rows = problem.data().observations;
  if (!HasRotations(problem)) return false;
  if (problem.repeat_scatter && problem.repeat_scatter->rotation_sigma.minCoeff() > 0.0) return false;
  return std::none_of(rows.begin(), rows.end(),
                      [](const Observation& row) { return !row.is_point() && row.rotation().sigma.minCoeff() > 0.0; });
}

bool RotationsAreOpen(const CalibrationProblem& problem) {
  return (problem.repeat_scatter || !problem.sigma_is_stated()) && NoRotationIsStated(problem);
}

bool ShowsSpread(const Estimate& estimate) { return IsUsable(estimate.status) && estimate.dof >= kLeastDof; }

bool RotationsAreDetermined(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const std::vector<int> all = problem.CalibrationObservations();
  const auto rotations = all.size() - problem.data().PointsAmong(all).size();
  size_t targets = 0;
  for (const bool oriented : problem.data().OrientedMarkers()) targets += oriented ? 1 : 0;
  const auto left = 3 * static_cast<int>(all.size()) - static_cast<int>(parameters.EstimatedCoordinates().size());
  return rotations > targets && left >= kLeastDof;
}

std::optional<TwoNoises> FindTwoNoises(const CalibrationProblem& problem, const Estimate& estimate) {
  if (!problem.latent.empty() || !IsLeftOpen(problem, estimate)) return std::nullopt;
  return TwoSpreads(problem, estimate);
}

std::optional<TwoNoises> TwoSpreads(const CalibrationProblem& problem, const Estimate& estimate) {
  TwoNoises noises;
  const std::vector<NoiseGroup> found = SpreadOfEach(problem, estimate, &noises.roots);
  if (found.empty()) return std::nullopt;
  for (const NoiseGroup& group : found) {
    VarianceComponent component;
    component.name = group.name;
    component.of_rotations = !noises.components.empty();
    component.estimated = true;
    component.value = group.sigma;
    SetInterval(group.freedom, &component);
    noises.components.push_back(component);
  }
  return noises;
}

FreedomOfTwo FindFreedom(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const RestrictedLikelihood reml(problem, parameters, true);
  const RemlFit fit = reml.Maximise(true, {});
  // var(s^2) = 2 sigma^4 / f.
  const auto freedom = [&fit](int i) {
    return fit.covariance(i, i) > 0.0 ? 2.0 * fit.variances[i] * fit.variances[i] / fit.covariance(i, i) : 0.0;
  };
  return {freedom(0), freedom(1), reml.Satterthwaite(fit, {})};
}

void SetIntervals(const FreedomOfTwo& freedom, std::vector<VarianceComponent>* components) {
  SetInterval(freedom.points, &(*components)[0]);
  SetInterval(freedom.rotations, &(*components)[1]);
}

double RobustRatio(const CalibrationProblem& problem, const ParameterSet& parameters, const PointCheck& check) {
  const std::vector<double> freedom = FreedomOfReadings(problem, parameters);
  std::vector<double> squares[2];
  for (size_t k = 0; k < check.observations.size(); ++k) {
    const bool is_point = problem.data().observations[check.observations[k]].is_point();
    squares[is_point ? 0 : 1].push_back(check.distance[k] * check.distance[k] / freedom[k]);
  }
  if (squares[0].empty() || squares[1].empty()) return 1.0;
  const double points = HuberSquare(squares[0]), rotations = HuberSquare(squares[1]);
  return points > 0.0 && rotations > 0.0 ? std::sqrt(rotations / points) : 1.0;
}

bool RotationsScatterOtherwise(const CalibrationProblem& problem, const Estimate& estimate) {
  if (!IsLeftOpen(problem, estimate)) return false;
  if (problem.repeat_scatter) return RotationsAreOpen(problem);
  const SigmaReport& sigma = estimate.sigma;
  return problem.latent.empty() && problem.experiment().noise.from == NoiseSpec::From::kDefault && sigma.scaled &&
         sigma.a_posteriori * sigma.a_posteriori >= kInstrumentIsNotTheNoise;
}

std::optional<RotationScatter> FindRotationScatter(const CalibrationProblem& stated, const CalibrationProblem& weighed,
                                                   const Estimate& estimate, bool by_points) {
  const std::optional<SpreadOfKinds> spread = FindSpreads(stated, weighed, estimate);
  if (!spread) return std::nullopt;
  RotationScatter found{spread->rotations, spread->freedom, by_points ? spread->points : 1.0, {}};
  const bool is_stated = !NoRotationIsStated(stated);
  for (size_t i = 0; i < stated.data().observations.size(); ++i) {
    const Matrix3<double> root = stated.SqrtCovariance(static_cast<int>(i));
    found.roots.push_back(root);
    if (stated.data().observations[i].is_point()) continue;
    Matrix3<double> covariance = found.spread * found.spread * Matrix3<double>::Identity();
    if (is_stated) covariance += root * root.transpose();
    found.roots[i] = LowerRoot(covariance) / found.unit;
  }
  return found;
}

void KeepRotationNoise(const RotationScatter& scatter, CalibrationProblem* problem) {
  problem->resolved_noise = scatter.roots;
  if (!problem->repeat_scatter) {
    problem->rotation_noise = scatter.spread / scatter.unit;
    return;
  }
  RepeatScatter& repeats = *problem->repeat_scatter;
  repeats.rotation_sigma.setConstant(scatter.spread / scatter.unit);
  repeats.rotation_dof = scatter.freedom;
  repeats.rotation_is_estimated = true;
}

const VarianceComponent* RotationComponent(const NoiseReport& report) {
  const auto found = std::find_if(report.components.begin(), report.components.end(),
                                  [](const VarianceComponent& component) { return component.of_rotations; });
  return found == report.components.end() ? nullptr : &*found;
}

bool HasTwoNoises(const NoiseReport& report) {
  return report.components.size() == 2 && RotationComponent(report) != nullptr;
}

}  // namespace sagitta
