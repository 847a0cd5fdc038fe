#include "estimator/noise/residual_noise.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/estimate/parameter_table.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {
namespace {

constexpr double kLeastKept = 0.05;  // of the information of a row whose weight follows its own residual

}  // namespace

double Eq14Weight(double sigma0, double lambda, double sigma) {
  return sigma0 == 0.0 ? 1.0 / sigma : sigma0 / (sigma0 + lambda * sigma);
}

Eigen::VectorXd GroupSigmas(const std::vector<int>& groups, const Eigen::VectorXd& residuals,
                            const Eigen::VectorXd& freedom, double floor) {
  const int num_groups = 1 + *std::max_element(groups.begin(), groups.end());
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(num_groups), counts = squares;
  for (int i = 0; i < residuals.size(); ++i) {
    squares[groups[i]] += residuals[i] * residuals[i];
    counts[groups[i]] += freedom[i];
  }
  Eigen::VectorXd sigma(residuals.size());
  for (int i = 0; i < sigma.size(); ++i) sigma[i] = std::sqrt(squares[groups[i]] / counts[groups[i]]);
  return sigma.cwiseMax(floor);
}

RowGroups GroupRows(const Measurements& data, ResidualGroup by) {
  RowGroups groups;
  std::map<std::string, int> index;
  for (const Observation& observation : data.observations) {
    const Shot& shot = data.shots[observation.shot];
    std::string name;
    if (by == ResidualGroup::kConfigAxis) name = data.configurations[shot.configuration].id;
    if (by == ResidualGroup::kMarkerAxis) name = data.markers[observation.marker];
    if (by == ResidualGroup::kStationAxis) name = data.stations[shot.station];
    if (by == ResidualGroup::kResidual) name = data.SourceOf(observation);
    if (by == ResidualGroup::kResidual && observation.file < 0) {  // words may fit several rows
      name += "/" + std::to_string(groups.group.size() / 3 + 1);
    }
    for (int axis = 0; axis < 3; ++axis) {
      const std::string full = (by == ResidualGroup::kAxis ? "" : name + "/") + "xyz"[axis];
      const auto [entry, is_new] = index.emplace(full, static_cast<int>(index.size()));
      groups.group.push_back(entry->second);
      if (!is_new) continue;
      groups.names.push_back(full);
      groups.of.push_back(name);
      groups.axes.push_back(axis);
    }
  }
  return groups;
}

NoiseRoots SpreadOfResiduals(const CalibrationProblem& problem, const Estimate& estimate, const RowGroups& groups,
                             std::vector<NoiseGroup>* report) {
  const std::vector<int> rows = problem.CalibrationObservations();
  const NoiseRoots noise = FitRoots(problem, rows, kFallbackSigma);
  const std::vector<int> columns = estimate.parameters.EstimatedCoordinates();
  Linearization here = Linearize(problem, estimate.parameters, rows, columns, noise);
  const int n = here.num_rows();
  AppendPriors(estimate.parameters, &here);
  const LinearSolution solution = SolveLinearization(here);
  std::vector<int> group(n), axis(n);
  Eigen::VectorXd residual(n), freedom(n);
  for (int k = 0; k < n / 3; ++k) {
    const Vector3<double> meters = noise[k] * here.residual.segment<3>(3 * k);
    for (int a = 0; a < 3; ++a) {
      const int i = 3 * k + a;
      // h_ii = j_i (J'J)^-1 j_i': of the variance of a row the fit leaves 1 - h_ii.
      const double leverage =
          columns.empty() ? 0.0 : here.jacobian.row(i).dot(solution.covariance * here.jacobian.row(i).transpose());
      residual[i] = meters[a];
      freedom[i] = std::max(kLeastFreedom, 1.0 - leverage);
      group[i] = groups.group[3 * rows[k] + a];
      axis[i] = a;
    }
  }
  const Eigen::VectorXd sigma = GroupSigmas(group, residual, freedom, kResidualFloor);
  const Eigen::VectorXd of_axis = GroupSigmas(axis, residual, freedom, kResidualFloor);
  std::vector<double> of_group(groups.names.size(), 0.0), left(groups.names.size(), 0.0);
  std::vector<int> counts(groups.names.size(), 0);
  for (int i = 0; i < n; ++i) {
    of_group[group[i]] = sigma[i];
    left[group[i]] += freedom[i];
    ++counts[group[i]];
  }
  NoiseRoots roots;
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    Vector3<double> own;
    for (int a = 0; a < 3; ++a) {
      const double found = of_group[groups.group[3 * i + a]];
      own[a] = found > 0.0 ? found : of_axis[a];
    }
    roots.push_back(own.asDiagonal());
  }
  report->clear();
  for (size_t g = 0; g < groups.names.size(); ++g) {
    if (counts[g] == 0) continue;
    report->push_back({groups.names[g], of_group[g], counts[g], left[g]});
    if (!groups.axes.empty()) report->back().of = groups.of[g], report->back().axis = groups.axes[g];
  }
  return roots;
}

NoiseRoots Eq14Roots(const NoiseRoots& spread, double sigma0, double lambda) {
  const double unit = sigma0 == 0.0 ? 1.0 : sigma0;
  NoiseRoots roots;
  for (const Matrix3<double>& root : spread) {
    Vector3<double> sigma;
    for (int a = 0; a < 3; ++a) sigma[a] = unit / Eq14Weight(sigma0, lambda, root(a, a));
    roots.push_back(sigma.asDiagonal());
  }
  return roots;
}

Eigen::MatrixXd FollowedByWeights(const CalibrationProblem& problem, const Estimate& estimate, const RowGroups& groups,
                                  const std::vector<NoiseGroup>& found) {
  const std::vector<int> rows = problem.CalibrationObservations();
  Linearization here =
      Linearize(problem, estimate.parameters, rows, estimate.estimated, FitRoots(problem, rows, kFallbackSigma));
  std::map<std::string, double> freedom;
  for (const NoiseGroup& group : found) freedom[group.name] = group.freedom;
  const NoiseSpec& noise = problem.experiment().noise;
  Linearization moved = here;
  for (int i = 0; i < here.num_rows(); ++i) {
    const int row = rows[i / 3], axis = i % 3;
    const double spread = problem.resolved_noise[row](axis, axis), weighed = problem.weight_roots[row](axis, axis);
    const double elasticity = noise.sigma0 == 0.0 ? 1.0 : noise.lambda * spread / weighed;
    const double nu = freedom.at(groups.names[groups.group[3 * row + axis]]);
    moved.jacobian.row(i) *= std::sqrt(std::max(kLeastKept, 1.0 - 2.0 * elasticity / nu));
  }
  AppendPriors(estimate.parameters, &here);
  AppendPriors(estimate.parameters, &moved);
  return SolveLinearization(moved).covariance * (here.jacobian.transpose() * here.jacobian);
}

void ReplaceCovariance(const CalibrationProblem& problem, const Eigen::MatrixXd& covariance, const Eigen::VectorXd& dof,
                       Estimate* estimate) {
  estimate->covariance = covariance;
  estimate->interval_dof = dof;
  FillTable(problem, estimate);
}

}  // namespace sagitta
