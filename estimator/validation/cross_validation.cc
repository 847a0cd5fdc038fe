#include "estimator/validation/cross_validation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/normal_equations.h"
#include "estimator/least_squares/row_sums.h"
#include "problems/io/files.h"
#include "problems/split.h"

namespace sagitta {
namespace {

// Coordinates that rest on their bound do not move with the data.
std::vector<int> MovingColumns(const Estimate& estimate) {
  std::vector<int> columns;
  for (const int i : estimate.estimated) {
    if (estimate.parameters.Value(i) > estimate.parameters.coordinates()[i].lower) columns.push_back(i);
  }
  return columns;
}

// What is summed of the observations of one fold.
struct Fold {
  explicit Fold(int columns) : rows(columns + 1), predicted(columns) {}
  SumOfRows rows;           // [J r] as fitted, without priors
  PredictedSums predicted;  // of its points
  Eigen::MatrixXd total;    // of `rows`
  Eigen::VectorXd step;     // of the fit without it, SI
};

// The fit without one fold, by one Gauss-Newton step: its step, and R with R R' = (J'J)^-1. What only this fold
// measures is left where the whole has it: the step that is least. sums: [J r]'[J r] of all, SI; scale: of a unit of
// each column.
Eigen::MatrixXd Leave(const Eigen::MatrixXd& sums, const Eigen::VectorXd& scale, Fold* fold) {
  const Eigen::MatrixXd left = sums - fold->total;
  const auto n = scale.size();
  const Eigen::MatrixXd normal = scale.asDiagonal() * left.topLeftCorner(n, n) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal);
  const double least = 1e-12 * eigen.eigenvalues().tail(1)[0];
  const Eigen::VectorXd inverse =
      eigen.eigenvalues().unaryExpr([least](double value) { return value > least ? 1.0 / value : 0.0; });
  const Eigen::MatrixXd root = scale.asDiagonal() * eigen.eigenvectors() * inverse.cwiseSqrt().asDiagonal();
  fold->step = -(root * (root.transpose() * left.col(n).head(n)));
  return root;
}

double NoiseOf(const SigmaReport& sigma) {
  if (!sigma.stated) return sigma.estimated / kFallbackSigma;
  return sigma.scaled ? sigma.a_posteriori : 1.0;
}

}  // namespace

std::vector<int> FoldsOf(const CalibrationProblem& problem, std::uint64_t seed) {
  const Measurements& data = problem.data();
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
  const std::vector<int> columns = MovingColumns(estimate);
  const auto n = static_cast<Eigen::Index>(columns.size());
  if (columns.empty()) return result;
  const std::vector<int> fold_of = FoldsOf(problem, seed);
  const int count = 1 + *std::max_element(fold_of.begin(), fold_of.end());
  if (count < 2) return result;
  std::vector<Fold> folds;
  for (int f = 0; f < count; ++f) folds.emplace_back(static_cast<int>(n));
  const std::vector<int> observations = problem.CalibrationObservations();
  const auto fold_at = [&](int i) -> Fold& {
    return folds[fold_of[problem.data().shots[problem.data().observations[i].shot].configuration]];
  };
  const auto roots = [&](const std::vector<int>& listed) { return FitRoots(problem, listed, kFallbackSigma); };
  const RowStream fitted(problem, observations, roots, LatentTreatment::kMarginalise);
  const bool valid = fitted.ForEach(estimate.parameters, columns, [&](const RowPiece& piece) {
    for (int k = 0; k < 3 * piece.num_observations(); ++k) {
      fold_at(observations[piece.positions[k / 3]]).rows.Add(&piece.rows(k, 0));
    }
  });
  if (!valid) return result;
  Eigen::MatrixXd sums = SumRows(PriorsOf(estimate.parameters, columns)).matrix;
  for (Fold& fold : folds) sums += fold.total = fold.rows.Total();
  const Eigen::VectorXd scale = sums.diagonal().head(n).cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  std::vector<Eigen::MatrixXd> of_fits;
  for (Fold& fold : folds) of_fits.push_back(Leave(sums, scale, &fold));

  const std::vector<int> quoted = problem.data().PointsAmong(observations);
  Eigen::Matrix3Xd errors(3, static_cast<Eigen::Index>(quoted.size()));
  // Observation by observation, in m: joints that deviate have no part in what a step moves.
  const auto metres = [](const std::vector<int>& listed) {
    return NoiseRoots(listed.size(), Matrix3<double>::Identity());
  };
  const RowStream points(problem, quoted, metres, LatentTreatment::kIgnore);
  points.ForEach(estimate.parameters, columns, [&](const RowPiece& piece) {
    std::vector<int> listed;
    for (const int k : piece.positions) listed.push_back(quoted[k]);
    const NoiseRoots scatter = ScatterOf(estimate, listed);
    for (int i = 0; i < piece.num_observations(); ++i) {
      const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> own = piece.rows.block(3 * i, 0, 3, n);
      Fold& fold = fold_at(listed[i]);
      errors.col(piece.positions[i]) =
          problem.data().observations[listed[i]].point_in_station - estimate.predicted.col(listed[i]) - own * fold.step;
      fold.predicted.Add(scatter[i], own);
    }
  });
  PredictedSquares predicted;
  for (int f = 0; f < count; ++f) {
    const PredictedSquares own = folds[f].predicted.Squares(NoiseOf(estimate.sigma) * of_fits[f]);
    predicted.trace += own.trace;
    predicted.trace_of_square += own.trace_of_square;
  }
  result.folds = count;
  result.unseen = MeasureUnseen(problem, quoted, errors);
  ComparePrediction(predicted, estimate, &result.unseen);
  return result;
}

}  // namespace sagitta
