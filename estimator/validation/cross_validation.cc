#include "estimator/validation/cross_validation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>

#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/row_sums.h"
#include "problems/io/files.h"
#include "problems/split.h"

namespace sagitta {
namespace {

// Everything that a fold is taken out of, columns scaled to unit norm.
struct Fit {
  std::vector<int> observations;
  Linearization rows;     // as fitted, without priors
  NoiseRoots roots;       // of the observations
  Eigen::MatrixXd apart;  // J, one observation apart from the other, where joints deviate: else that of `rows`
  Eigen::VectorXd scale;  // SI of one unit of each column
  Eigen::MatrixXd sums;   // [J r]'[J r], priors included, SI
  double noise = 1.0;     // of the whitened residuals
  bool valid = false;
};

// Coordinates that rest on their bound do not move with the data.
std::vector<int> MovingColumns(const Estimate& estimate) {
  std::vector<int> columns;
  for (const int i : estimate.estimated) {
    if (estimate.parameters.Value(i) > estimate.parameters.coordinates()[i].lower) columns.push_back(i);
  }
  return columns;
}

Fit FitOf(const CalibrationProblem& problem, const Estimate& estimate) {
  Fit fit;
  fit.observations = problem.CalibrationObservations();
  const std::vector<int> columns = MovingColumns(estimate);
  if (columns.empty()) return fit;
  fit.roots = FitRoots(problem, fit.observations, kFallbackSigma);
  const auto linearize = [&](LatentTreatment treatment) {
    return Linearize(problem, estimate.parameters, fit.observations, columns, fit.roots, treatment);
  };
  fit.rows = linearize(LatentTreatment::kMarginalise);
  if (!fit.rows.valid) return fit;
  if (!problem.latent.empty()) fit.apart = linearize(LatentTreatment::kIgnore).jacobian;
  Linearization priors;
  priors.columns = columns;
  priors.jacobian.resize(0, columns.size());
  AppendPriors(estimate.parameters, &priors);
  fit.sums = SumRows(fit.rows).matrix + SumRows(priors).matrix;
  fit.scale = fit.sums.diagonal().head(fit.rows.num_columns()).cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  const SigmaReport& sigma = estimate.sigma;
  fit.noise = !sigma.stated ? sigma.estimated / kFallbackSigma : sigma.scaled ? sigma.a_posteriori : 1.0;
  fit.valid = true;
  return fit;
}

}  // namespace

std::vector<int> FoldsOf(const CalibrationProblem& problem, std::uint64_t seed) {
  const Measurements& data = problem.data;
  std::vector<bool> fitted(data.configurations.size(), false);
  for (const int i : problem.CalibrationObservations())
    fitted[data.shots[data.observations[i].shot].configuration] = true;
  std::vector<std::pair<std::string, std::vector<int>>> groups;
  for (const std::vector<int>& group : GroupsOfEqualJointValues(data)) {
    std::vector<int> own;
    for (const int c : group) {
      if (fitted[c]) own.push_back(c);
    }
    if (own.empty()) continue;
    groups.emplace_back(Sha256(std::to_string(seed) + ":" + data.configurations[group.front()].id), own);
  }
  std::sort(groups.begin(), groups.end());
  std::vector<int> folds(data.configurations.size(), -1);
  const int count = std::min(kFolds, static_cast<int>(groups.size()));
  for (size_t g = 0; g < groups.size(); ++g) {
    for (const int c : groups[g].second) folds[c] = static_cast<int>(g) % count;
  }
  return folds;
}

CrossValidation CrossValidate(const CalibrationProblem& problem, const Estimate& estimate, std::uint64_t seed) {
  CrossValidation result;
  const Fit fit = FitOf(problem, estimate);
  if (!fit.valid) return result;
  const std::vector<int> fold_of = FoldsOf(problem, seed);
  const int folds = 1 + *std::max_element(fold_of.begin(), fold_of.end());
  if (folds < 2) return result;
  const std::vector<int> quoted = problem.data.PointsAmong(fit.observations);
  Eigen::Matrix3Xd errors(3, static_cast<Eigen::Index>(quoted.size()));
  std::map<int, Eigen::Index> column_of;  // of each quoted point
  for (size_t k = 0; k < quoted.size(); ++k) column_of[quoted[k]] = static_cast<Eigen::Index>(k);
  PredictedSquares predicted;
  for (int f = 0; f < folds; ++f) {
    std::vector<int> rows, points, point_rows;  // all that leaves the fit; of it what is quoted
    for (size_t k = 0; k < fit.observations.size(); ++k) {
      const int i = fit.observations[k];
      if (fold_of[problem.data.shots[problem.data.observations[i].shot].configuration] != f) continue;
      const bool is_point = problem.data.observations[i].is_point();
      if (is_point) points.push_back(i);
      for (int axis = 0; axis < 3; ++axis) {
        rows.push_back(3 * static_cast<int>(k) + axis);
        if (is_point) point_rows.push_back(rows.back());
      }
    }
    RowSums own_sums(fit.rows);
    for (const int row : rows) own_sums.Add(row);
    const Eigen::MatrixXd left = fit.sums - own_sums.Total();
    const auto n = fit.scale.size();
    const Eigen::MatrixXd normal = fit.scale.asDiagonal() * left.topLeftCorner(n, n) * fit.scale.asDiagonal();
    const Eigen::VectorXd gradient = fit.scale.cwiseProduct(left.col(n).head(n));
    // What only this fold measures is left where the whole has it: the step that is least.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal);
    const double least = 1e-12 * eigen.eigenvalues().tail(1)[0];
    const Eigen::VectorXd inverse =
        eigen.eigenvalues().unaryExpr([least](double value) { return value > least ? 1.0 / value : 0.0; });
    const Eigen::MatrixXd root = fit.scale.asDiagonal() * eigen.eigenvectors() * inverse.cwiseSqrt().asDiagonal();
    Eigen::MatrixXd own = (problem.latent.empty() ? fit.rows.jacobian : fit.apart)(point_rows, Eigen::all);  // in m
    for (size_t m = 0; m < points.size(); ++m) {
      auto rows_of_point = own.middleRows<3>(3 * static_cast<Eigen::Index>(m));
      rows_of_point = (fit.roots[point_rows[3 * m] / 3] * rows_of_point).eval();
    }
    // Of the predicted points, m.
    const Eigen::VectorXd moved = own * (-(root * (root.transpose() * gradient.cwiseQuotient(fit.scale)))).eval();
    for (size_t m = 0; m < points.size(); ++m) {
      const int i = points[m];
      errors.col(column_of[i]) = problem.data.observations[i].point_in_station - estimate.predicted.col(i) -
                                 moved.segment<3>(3 * static_cast<Eigen::Index>(m));
    }
    predicted.Add(ScatterOf(estimate, points), own, fit.noise * root);
  }
  result.folds = folds;
  result.unseen = MeasureUnseen(problem, quoted, errors);
  ComparePrediction(predicted, estimate, &result.unseen);
  return result;
}

}  // namespace sagitta
