#include "estimator/noise/rotation_noise.h"

#include <algorithm>
#include <cmath>

#include "estimator/noise/residual_noise.h"
#include "estimator/noise/robot_scatter.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

constexpr int kLeastDof = 30;  // a standard deviation from fewer is known worse than to an eighth

bool IsLeftOpen(const CalibrationProblem& problem, const Estimate& estimate) {
  const Experiment& experiment = problem.experiment();
  return IsUsable(estimate.status) && estimate.dof >= kLeastDof && problem.latent.empty() &&
         experiment.noise.from == NoiseSpec::From::kDefault && experiment.method.weights == Weights::kSigma &&
         experiment.method.loss == LossKind::kNone;
}

// Degrees of freedom by its share of the rows: f s^2 / sigma^2 is chi-square with f.
VarianceComponent ComponentOf(const NoiseGroup& group, const Estimate& estimate) {
  const double f = std::max(1.0, static_cast<double>(group.rows) * estimate.dof / estimate.rows);
  VarianceComponent component;
  component.name = group.name;
  component.estimated = true;
  component.value = group.sigma;
  component.sigma = group.sigma / std::sqrt(2.0 * f);
  component.low = group.sigma * std::sqrt(f / ChiSquareQuantile(0.975, f));
  component.high = group.sigma * std::sqrt(f / ChiSquareQuantile(0.025, f));
  return component;
}

// Points, then rotations, with the roots that they make; empty where that is not to be asked.
std::vector<NoiseGroup> SpreadOfEach(const CalibrationProblem& problem, const Estimate& estimate, NoiseRoots* roots) {
  if (!IsLeftOpen(problem, estimate)) return {};
  RowGroups groups{{}, {"points", "rotations"}};
  for (const Observation& observation : problem.data().observations) {
    groups.group.insert(groups.group.end(), 3, observation.is_point() ? 0 : 1);
  }
  if (*std::max_element(groups.group.begin(), groups.group.end()) == 0) return {};
  std::vector<NoiseGroup> found;
  *roots = SpreadOfResiduals(problem, estimate, groups, &found);
  if (found.size() < 2) return {};  // all rotations are held out
  if (std::min(found[0].sigma, found[1].sigma) <= kResidualFloor) return {};
  return found;
}

}  // namespace

std::optional<TwoNoises> FindTwoNoises(const CalibrationProblem& problem, const Estimate& estimate) {
  TwoNoises noises;
  const std::vector<NoiseGroup> found = SpreadOfEach(problem, estimate, &noises.roots);
  if (found.empty()) return std::nullopt;
  for (const NoiseGroup& group : found) noises.components.push_back(ComponentOf(group, estimate));
  return noises;
}

std::optional<RotationFactor> FindRotationFactor(const CalibrationProblem& problem, const Estimate& estimate) {
  const SigmaReport& sigma = estimate.sigma;
  if (!sigma.scaled || sigma.a_posteriori * sigma.a_posteriori < kInstrumentIsNotTheNoise) return std::nullopt;
  RotationFactor found;
  const std::vector<NoiseGroup> spread = SpreadOfEach(problem, estimate, &found.roots);
  if (spread.empty()) return std::nullopt;
  double stated[2] = {0.0, 0.0}, rows[2] = {0.0, 0.0};  // sums of squares of points and of rotations
  for (const int i : problem.CalibrationObservations()) {
    const int kind = problem.data().observations[i].is_point() ? 0 : 1;
    stated[kind] += problem.SqrtCovariance(i).squaredNorm();
    rows[kind] += 3.0;
  }
  const double of_points = spread[0].sigma / std::sqrt(stated[0] / rows[0]);
  found.factor = spread[1].sigma / std::sqrt(stated[1] / rows[1]) / of_points;
  for (size_t i = 0; i < found.roots.size(); ++i) {
    const bool is_point = problem.data().observations[i].is_point();
    found.roots[i] = (is_point ? 1.0 : found.factor) * problem.SqrtCovariance(static_cast<int>(i));
  }
  return found;
}

const VarianceComponent* RotationComponent(const NoiseReport& report) {
  // Of components by REML the first alone has no joints.
  const bool has_two = report.components.size() == 2 && report.components[1].joints.empty();
  return has_two ? &report.components[1] : nullptr;
}

}  // namespace sagitta
