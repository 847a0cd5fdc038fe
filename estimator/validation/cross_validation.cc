#include "estimator/validation/cross_validation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>

#include "estimator/calibration/held_rest.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/least_squares/held_influence.h"
#include "estimator/least_squares/identifiability.h"
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
  bool loses = false;       // the fit without it holds more than the whole
};

// What the fit without a fold would hold rests where such a fit lets it rest (held_rest.h): the same weak prior about
// the same place. One step along a direction that is hardly measured any more would go anywhere. left: [J r]'[J r].
// False: nothing is lost.
bool AddRest(const CalibrationProblem& problem, const Estimate& estimate, const std::vector<int>& columns, double noise,
             Eigen::MatrixXd* left) {
  constexpr double kLeastWeight = 1e-6;  // of a column's norm: normal equations do not lose it in rounding
  const ParameterSet& aligned = estimate.aligned.num_coordinates() > 0 ? estimate.aligned : problem.parameters;
  NormalSums sums;
  sums.columns = columns;
  sums.matrix = *left;
  sums.valid = true;
  const auto n = static_cast<Eigen::Index>(columns.size());
  const std::vector<int> lost = FindUnidentifiable(Condense(sums), estimate.parameters, noise).columns;
  for (const int c : lost) {
    const int i = columns[static_cast<size_t>(c)];
    const Coordinate& coordinate = estimate.parameters.coordinates()[i];
    if (coordinate.prior_sigma > 0.0) continue;
    const double weight = std::max(noise / PhysicalRange(coordinate), kLeastWeight * std::sqrt((*left)(c, c)));
    (*left)(c, c) += weight * weight;
    // Single axes of a rotation have no value of their own: they stay where the whole has them.
    if (IsRotation(estimate.parameters.blocks()[coordinate.block].kind)) continue;
    const double off = estimate.parameters.Value(i) - ReferenceOf(problem, aligned, i);
    (*left)(c, n) += weight * weight * off;
    (*left)(n, c) = (*left)(c, n);
  }
  return !lost.empty();
}

// A calibration without the listed rows, where the others see every station and marker. Nothing: it has no result.
std::optional<ParameterSet> CalibrateWithout(const CalibrationProblem& problem, const std::vector<int>& left_out) {
  CalibrationProblem rest = problem;
  for (const int i : left_out) rest.mutable_data()->ExcludeRow(i);
  std::set<int> stations, markers;
  for (const int i : rest.CalibrationObservations()) {
    stations.insert(rest.data().shots[rest.data().observations[i].shot].station);
    markers.insert(rest.data().observations[i].marker);
  }
  for (const int i : left_out) {
    const Observation& row = problem.data().observations[i];
    if (stations.count(problem.data().shots[row.shot].station) + markers.count(row.marker) < 2) return std::nullopt;
  }
  const Estimate estimate = EstimateJointly(rest);
  if (!IsUsable(estimate.status)) return std::nullopt;
  return estimate.parameters;
}

// The fit without one fold, by one Gauss-Newton step: its step, and R with R R' = (J'J)^-1. What only this fold
// measures is left where the whole has it: the step that is least. left: [J r]'[J r] of the others, SI; scale: of a
// unit of each column.
Eigen::MatrixXd Leave(const Eigen::MatrixXd& left, const Eigen::VectorXd& scale, Fold* fold) {
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

using PointRows = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;  // m/SI
using RowsOfPoint = Eigen::Ref<const PointRows, 0, Eigen::OuterStride<>>;

// Calls visit(place among `quoted`, S, rows) for every fitted point: S times its rows are in m. Joints that deviate
// have no part in what a step moves.
void ForEachPoint(
    const CalibrationProblem& problem, const ParameterSet& parameters, const std::vector<int>& columns,
    const FittedStream& fitted, const std::vector<int>& quoted, const NoiseRoots& weighed,
    const std::function<void(size_t place, const Matrix3<double>& root, const RowsOfPoint& rows)>& visit) {
  const auto n = static_cast<Eigen::Index>(columns.size());
  if (!problem.latent.empty()) {
    const auto metres = [](const std::vector<int>& listed) {
      return NoiseRoots(listed.size(), Matrix3<double>::Identity());
    };
    RowStream(problem, quoted, metres, LatentTreatment::kIgnore)
        .ForEach(parameters, columns, [&](const RowPiece& piece) {
          for (int i = 0; i < piece.num_observations(); ++i)
            visit(piece.positions[i], Matrix3<double>::Identity(), piece.rows.block(3 * i, 0, 3, n));
        });
    return;
  }
  const bool are_all = quoted.size() == fitted.observations().size();  // then they are the same
  fitted.ForEach(parameters, columns, [&](const RowPiece& piece) {
    for (int i = 0; i < piece.num_observations(); ++i) {
      const int k = fitted.observations()[piece.positions[i]];
      if (!problem.data().observations[k].is_point()) continue;
      const auto place = static_cast<size_t>(
          are_all ? piece.positions[i] : std::lower_bound(quoted.begin(), quoted.end(), k) - quoted.begin());
      visit(place, weighed[place], piece.rows.block(3 * i, 0, 3, n));
    }
  });
}

// m, where all of these are the same number on every axis; else 0.
double SigmaOfEveryAxis(const NoiseRoots& roots) {
  constexpr double kSame = 1e-12;  // relative
  const double sigma = roots.front()(0, 0);
  const bool all = std::all_of(roots.begin(), roots.end(), [&](const Matrix3<double>& root) {
    return (root - sigma * Matrix3<double>::Identity()).cwiseAbs().maxCoeff() <= kSame * sigma;
  });
  return all ? sigma : 0.0;
}

// What the points of each fold say of predictions, where that follows from what is summed of its rows: all of them
// points that are weighed by one sigma and err by one. False: it does not.
bool PredictFromTotals(const CalibrationProblem& problem, const NoiseRoots& weighed_by, const NoiseRoots& scatter,
                       const std::vector<int>& quoted, const std::vector<int>& points_of_fold,
                       std::vector<Fold>* folds) {
  const bool are_all = quoted.size() == problem.CalibrationObservations().size();
  if (!problem.latent.empty() || quoted.empty() || !are_all) return false;
  const double weighed = SigmaOfEveryAxis(weighed_by);
  const double errs = SigmaOfEveryAxis(scatter);
  if (!(weighed > 0.0 && errs > 0.0)) return false;
  for (size_t f = 0; f < folds->size(); ++f) {
    Fold& fold = (*folds)[f];
    const Eigen::Index n = fold.total.rows() - 1;
    fold.predicted.Add(errs, points_of_fold[f], weighed * weighed * fold.total.topLeftCorner(n, n));
  }
  return true;
}

}  // namespace

std::vector<int> FoldsOf(const CalibrationProblem& problem, std::uint64_t seed) {
  const Measurements& data = problem.data();
  std::vector<bool> fitted(data.configurations.size(), false);
  for (const int i : problem.CalibrationObservations())
    fitted[data.shots[data.observations[i].shot].configuration] = true;
  const std::vector<int> group_of = GroupsOfConfigurations(data);
  // Of the groups that are fitted, in the order of the hashes of their first configurations; hardly any two share the
  // first sixteen letters.
  struct Hashed {
    std::uint64_t first;
    int group;
  };
  std::vector<int> first_of, count_of;  // of each group: its first configuration; how many are fitted
  for (size_t c = 0; c < group_of.size(); ++c) {
    const auto g = static_cast<size_t>(group_of[c]);
    if (g == first_of.size()) first_of.push_back(static_cast<int>(c)), count_of.push_back(0);
    count_of[g] += fitted[c] ? 1 : 0;
  }
  const std::string seed_text = std::to_string(seed) + ":";
  const auto hash_of = [&](int g) { return Sha256(seed_text + data.configurations[first_of[g]].id); };
  std::vector<Hashed> hashed;
  for (size_t g = 0; g < first_of.size(); ++g) {
    if (count_of[g] == 0) continue;
    const std::string hash = hash_of(static_cast<int>(g));
    std::uint64_t first = 0;
    std::from_chars(hash.data(), hash.data() + 16, first, 16);  // small letters: in the order of the texts
    hashed.push_back({first, static_cast<int>(g)});
  }
  std::sort(hashed.begin(), hashed.end(), [&](const Hashed& one, const Hashed& other) {
    if (one.first != other.first || one.group == other.group) return one.first < other.first;
    const std::string hash = hash_of(one.group), hash_of_other = hash_of(other.group);
    return hash != hash_of_other ? hash < hash_of_other : one.group < other.group;
  });
  const int count = std::min(kFolds, static_cast<int>(hashed.size()));
  std::vector<int> fold_of(first_of.size(), -1);
  for (size_t i = 0; i < hashed.size(); ++i) fold_of[hashed[i].group] = static_cast<int>(i) % count;
  std::vector<int> folds(data.configurations.size(), -1);
  for (size_t c = 0; c < folds.size(); ++c) {
    if (fitted[c]) folds[c] = fold_of[group_of[c]];
  }
  return folds;
}

CrossValidation CrossValidate(const CalibrationProblem& problem, const Estimate& estimate, std::uint64_t seed) {
  return CrossValidate(problem, FittedStream(problem), estimate, seed);
}

CrossValidation CrossValidate(const CalibrationProblem& problem, const FittedStream& fitted, const Estimate& estimate,
                              std::uint64_t seed) {
  CrossValidation result;
  const std::vector<int> columns = MovingColumns(estimate);
  const auto n = static_cast<Eigen::Index>(columns.size());
  if (columns.empty()) return result;
  const std::vector<int> fold_of = FoldsOf(problem, seed);
  const int count = 1 + *std::max_element(fold_of.begin(), fold_of.end());
  if (count < 2) return result;
  std::vector<Fold> folds;
  for (int f = 0; f < count; ++f) folds.emplace_back(static_cast<int>(n));
  const std::vector<int>& observations = fitted.observations();
  const auto fold_at = [&](int i) {
    return static_cast<size_t>(fold_of[problem.data().shots[problem.data().observations[i].shot].configuration]);
  };
  const bool valid = fitted.ForEach(estimate.parameters, columns, [&](const RowPiece& piece) {
    for (int k = 0; k < 3 * piece.num_observations(); ++k) {
      folds[fold_at(observations[piece.positions[k / 3]])].rows.Add(&piece.rows(k, 0));
    }
  });
  if (!valid) return result;
  Eigen::MatrixXd sums = SumRows(PriorsOf(estimate.parameters, columns)).matrix;
  for (Fold& fold : folds) sums += fold.total = fold.rows.Total();
  const Eigen::VectorXd scale = sums.diagonal().head(n).cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  std::vector<Eigen::MatrixXd> of_fits;
  for (Fold& fold : folds) {
    Eigen::MatrixXd left = sums - fold.total;
    fold.loses = AddRest(problem, estimate, columns, AppliedNoise(estimate.sigma), &left);
    of_fits.push_back(Leave(left, scale, &fold));
  }

  const std::vector<int> quoted = problem.data().PointsAmong(observations);
  std::vector<int> points_of_fold(folds.size(), 0);
  for (const int i : quoted) ++points_of_fold[fold_at(i)];
  const NoiseRoots scatter = ScatterOf(estimate, quoted), weighed = FitRoots(problem, quoted, kFallbackSigma);
  const bool are_predicted = PredictFromTotals(problem, weighed, scatter, quoted, points_of_fold, &folds);
  Eigen::Matrix3Xd errors(3, static_cast<Eigen::Index>(quoted.size()));
  ForEachPoint(problem, estimate.parameters, columns, fitted, quoted, weighed,
               [&](size_t place, const Matrix3<double>& root, const RowsOfPoint& rows) {
                 const int i = quoted[place];
                 Fold& fold = folds[fold_at(i)];
                 const Vector3<double> moved = root * (rows * fold.step);
                 errors.col(static_cast<Eigen::Index>(place)) =
                     problem.data().observations[i].point_in_station - estimate.predicted.col(i) - moved;
                 if (!are_predicted) fold.predicted.Add(scatter[place], root * rows);
               });
  // What is held in addition moves what was held before: no step from the whole finds that. A fold without which
  // something is not measured is calibrated without.
  for (int f = 0; f < count; ++f) {
    if (!folds[static_cast<size_t>(f)].loses) continue;
    std::vector<int> left_out;
    for (const int i : observations) {
      if (fold_at(i) == static_cast<size_t>(f)) left_out.push_back(i);
    }
    const std::optional<ParameterSet> rest = CalibrateWithout(problem, left_out);
    if (!rest) continue;
    const std::vector<int> own = problem.data().PointsAmong(left_out);
    const Eigen::Matrix3Xd points_without = PredictPoints(problem, *rest, own);
    for (size_t k = 0; k < own.size(); ++k) {
      const auto place = std::lower_bound(quoted.begin(), quoted.end(), own[k]) - quoted.begin();
      errors.col(place) =
          problem.data().observations[own[k]].point_in_station - points_without.col(static_cast<Eigen::Index>(k));
    }
  }
  PredictedSquares predicted;
  for (int f = 0; f < count; ++f) {
    const PredictedSquares own = folds[f].predicted.Squares(AppliedNoise(estimate.sigma) * of_fits[f]);
    predicted.trace += own.trace;
    predicted.trace_of_square += own.trace_of_square;
  }
  result.folds = count;
  result.unseen = MeasureUnseen(problem, quoted, errors);
  ComparePrediction(predicted, estimate, &result.unseen);
  return result;
}

}  // namespace sagitta
