#include "estimator/noise/rotation_noise.h"

#include <algorithm>
#include <cmath>

#include "estimator/noise/residual_noise.h"
#include "estimator/noise/robot_scatter.h"
#include "estimator/statistics/distributions.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

constexpr int kLeastDof = 30;  // a standard deviation from fewer is known worse than to an eighth

bool IsLeftOpen(const CalibrationProblem& problem, const Estimate& estimate) {
  const Experiment& experiment = problem.experiment();
  return IsUsable(estimate.status) && estimate.dof >= kLeastDof && problem.latent.empty() &&
         experiment.method.weights == Weights::kSigma && experiment.method.loss == LossKind::kNone;
}

// Degrees of freedom by its share of the rows: f s^2 / sigma^2 is chi-square with f.
VarianceComponent ComponentOfRotations(const NoiseGroup& group, const Estimate& estimate) {
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

// Root mean square of S^-1 r, of the coordinates that the fit leaves.
double WhitenedSpreadOfPoints(const CalibrationProblem& problem, const Estimate& estimate) {
  double sum = 0.0, rows = 0.0;
  for (const int i : problem.data().PointsAmong(problem.CalibrationObservations())) {
    const Vector3<double> residual = problem.data().observations[i].point_in_station - estimate.predicted.col(i);
    sum += (problem.SqrtCovariance(i).inverse() * residual).squaredNorm();
    rows += 3.0;
  }
  return std::sqrt(sum / (rows * estimate.dof / estimate.rows));
}

}  // namespace

std::optional<TwoNoises> FindTwoNoises(const CalibrationProblem& problem, const Estimate& estimate) {
  using From = NoiseSpec::From;
  const From from = problem.experiment().noise.from;
  if (from != From::kDefault && from != From::kSigma && from != From::kRows) return std::nullopt;
  TwoNoises noises;
  const std::vector<NoiseGroup> found = SpreadOfEach(problem, estimate, &noises.roots);
  if (found.empty()) return std::nullopt;
  for (const NoiseGroup& group : found) noises.components.push_back(ComponentOfRotations(group, estimate));
  return noises;
}

std::optional<RotationScatter> FindRotationScatter(const CalibrationProblem& problem, const Estimate& estimate) {
  if (problem.experiment().noise.from != NoiseSpec::From::kDefault) return std::nullopt;
  const SigmaReport& sigma = estimate.sigma;
  if (!sigma.scaled || sigma.a_posteriori * sigma.a_posteriori < kInstrumentIsNotTheNoise) return std::nullopt;
  RotationScatter found;
  const std::vector<NoiseGroup> spread = SpreadOfEach(problem, estimate, &found.roots);
  if (spread.empty()) return std::nullopt;
  found.spread = spread[1].sigma;
  const double unit = WhitenedSpreadOfPoints(problem, estimate);
  for (size_t i = 0; i < found.roots.size(); ++i) {
    const Matrix3<double> root = problem.SqrtCovariance(static_cast<int>(i));
    found.roots[i] = root;
    if (problem.data().observations[i].is_point()) continue;
    const Matrix3<double> scatter = found.spread * found.spread * Matrix3<double>::Identity();
    found.roots[i] = LowerRoot(root * root.transpose() + scatter) / unit;
  }
  return found;
}

const VarianceComponent* RotationComponent(const NoiseReport& report) {
  // Of components by REML the first alone has no joints.
  const bool has_two = report.components.size() == 2 && report.components[1].joints.empty();
  return has_two ? &report.components[1] : nullptr;
}

}  // namespace sagitta
