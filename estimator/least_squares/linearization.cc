#include "estimator/least_squares/linearization.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimator/least_squares/normal_algebra.h"
#include "estimator/least_squares/row_batches.h"
#include "estimator/least_squares/row_sums.h"
#include "estimator/least_squares/spring_tie_cost.h"
#include "models/matrix_functions.h"
#include "problems/interruption.h"

namespace sagitta {
namespace {

constexpr size_t kFewestOfBatch = 12;  // observations; for fewer it costs more to say what their shots have in common

// Which column of the linearization a coordinate has; -1: none.
std::vector<int> ColumnOfCoordinate(const ParameterSet& parameters, const std::vector<int>& columns) {
  std::vector<int> column_of(parameters.num_coordinates(), -1);
  for (size_t c = 0; c < columns.size(); ++c) column_of[columns[c]] = c;
  return column_of;
}

struct ActiveParameters {
  std::vector<int> model_parameters;
  std::vector<int> columns;
};

ActiveParameters FindActive(const ParameterSet& parameters, const std::vector<int>& column_of) {
  ActiveParameters active;
  for (int i = 0; i < parameters.num_model_parameters(); ++i) {
    const int column = column_of[parameters.model_parameter(i).first_coordinate];
    if (column < 0) continue;
    active.model_parameters.push_back(i);
    active.columns.push_back(column);
  }
  return active;
}

// Calls visit(k, prediction) for each listed observation, one kinematic pass
// per run of observations of the same shot. False: an equilibrium diverged.
template <typename Visit>
bool ForEachPrediction(const CalibrationProblem& problem, const ParameterSet& parameters,
                       const std::vector<int>& observations, const std::vector<int>& active, bool with_latents,
                       const Visit& visit) {
  const std::vector<double> no_deviation(problem.robot().num_joints(), 0.0);
  const std::vector<double> theta = parameters.ModelValues();
  std::vector<MarkerInFrame> markers;
  std::vector<PointPrediction> predictions;
  for (size_t first = 0; first < observations.size();) {
    CheckInterruption();
    const int shot_index = problem.data().observations[observations[first]].shot;
    const Shot& shot = problem.data().shots[shot_index];
    markers.clear();
    size_t last = first;
    for (; last < observations.size() && problem.data().observations[observations[last]].shot == shot_index; ++last) {
      const Observation& observation = problem.data().observations[observations[last]];
      markers.push_back(
          parameters.MarkerOn(problem.marker_frames()[observation.marker], observation.marker, observation.kind));
    }
    const bool found = problem.model().Predict(problem.shot_inputs()[shot_index], theta.data(), active,
                                               parameters.BaseInStation(shot.station), markers, &predictions,
                                               with_latents ? no_deviation.data() : nullptr);
    if (!found) return false;
    for (size_t k = first; k < last; ++k) visit(k, predictions[k - first]);
    first = last;
  }
  return true;
}

// Rows of one visit, whitened together: C = I + L L', rows <- chol(C)^-1 rows.
// Equal to estimating the deviations with their prior and projecting them out.
void Marginalise(const CalibrationProblem& problem, Linearization* linearization) {
  for (const auto& [visit, rows] : RowsByVisit(problem, linearization->observations)) {
    const Eigen::MatrixXd l = linearization->latent(rows, Eigen::all);
    const Eigen::MatrixXd c = Eigen::MatrixXd::Identity(l.rows(), l.rows()) + l * l.transpose();
    const Eigen::LLT<Eigen::MatrixXd> root(c);
    Eigen::MatrixXd own(l.rows(), linearization->num_columns() + 1);
    own << linearization->jacobian(rows, Eigen::all), linearization->residual(rows);
    root.matrixL().solveInPlace(own);
    linearization->residual(rows) = own.rightCols<1>();
    linearization->jacobian(rows, Eigen::all) = own.leftCols(linearization->num_columns());
  }
}

// NaN from the first shot on whose equilibrium diverges.
Eigen::Matrix3Xd PointsByModel(const CalibrationProblem& problem, const ParameterSet& parameters,
                               const std::vector<int>& observations) {
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Constant(3, observations.size(), std::nan(""));
  ForEachPrediction(problem, parameters, observations, {}, false,
                    [&](size_t k, const PointPrediction& prediction) { points.col(k) = prediction.point; });
  return points;
}

// One lane's unit of a batch into its rows, column by column as these lie in memory.
void Unpack(const BatchColumns& columns, RowBatches::Unit unit, const double* lane, Linearization* result) {
  const std::size_t next_row = static_cast<size_t>(columns.columns) * kBatchLanes;
  const auto copy = [&](size_t m, int column, double* to) {
    const double* const from = lane + 3 * m * next_row + static_cast<size_t>(column) * kBatchLanes;
    for (size_t axis = 0; axis < 3; ++axis) to[axis] = from[axis * next_row];
  };
  for (int c = 0; c < columns.columns; ++c) {
    for (size_t m = 0; m < unit.size(); ++m) {
      const int column = columns.Of(static_cast<int>(3 * m), c);
      if (column >= 0) copy(m, c, &result->jacobian(3 * unit[m], column));
    }
  }
  for (size_t m = 0; m < unit.size(); ++m) {
    copy(m, columns.residual, &result->residual[3 * unit[m]]);
    for (int i = 0; i < columns.latents; ++i) copy(m, columns.latent + i, &result->latent(3 * unit[m], i));
  }
}

// Where the columns are far from depending on each other, by their products: (J'J)^-1 loses the square of the
// condition, 6 of 16 digits at most. One refinement by the rows gives the step what they have.
bool SolveByProducts(const Linearization& rows, LinearSolution* solution) {
  constexpr double kFarFromDependent = 1e-6;  // squared singular values
  const Eigen::VectorXd unit = rows.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd scaled = rows.jacobian * unit.asDiagonal();
  const Eigen::MatrixXd products = SelfProduct(scaled);
  const auto [least, largest] = EndsOfSpectrum(products);
  if (!(least > kFarFromDependent * largest)) return false;
  const Eigen::MatrixXd root = InverseRoot(products);
  if (root.size() == 0) return false;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(scaled.cols()), left = rows.residual;
  for (int i = 0; i < 2; ++i) {
    step -= root * (root.transpose() * (scaled.transpose() * left));
    left = rows.residual + scaled * step;
  }
  solution->condition = std::sqrt(largest / least);
  solution->residual_norm_squared = left.squaredNorm();
  solution->step = unit.cwiseProduct(step);
  solution->covariance_root = unit.asDiagonal() * root;
  solution->covariance = unit.asDiagonal() * SquareOfRoot(root) * unit.asDiagonal();
  return true;
}

// Largest over least singular value of R, each as the largest of a product: that of R and that of R^-1, which keep its
// digits. Infinite where R has no inverse.
double ConditionOf(const Eigen::MatrixXd& r, const Eigen::MatrixXd& inverse) {
  if (!inverse.allFinite()) return std::numeric_limits<double>::infinity();
  const double condition =
      std::sqrt(EndsOfSpectrum(SelfProduct(r)).second) * std::sqrt(EndsOfSpectrum(SelfProduct(inverse)).second);
  return std::isfinite(condition) ? condition : std::numeric_limits<double>::infinity();
}

}  // namespace

std::map<int, std::vector<int>> RowsByVisit(const CalibrationProblem& problem, const std::vector<int>& observations) {
  std::map<int, std::vector<int>> rows;
  for (size_t k = 0; k < observations.size(); ++k) {
    const int visit = problem.latent.visit_of_shot[problem.data().observations[observations[k]].shot];
    for (int axis = 0; axis < 3; ++axis) rows[visit].push_back(static_cast<int>(3 * k) + axis);
  }
  return rows;
}

NoiseRoots ObservationNoise(const CalibrationProblem& problem, const std::vector<int>& observations, double fallback) {
  NoiseRoots noise;
  noise.reserve(observations.size());
  for (const int i : observations) {
    noise.push_back(problem.SqrtCovariance(i));
    if (!IsStated(noise.back())) noise.back() = fallback * Matrix3<double>::Identity();
  }
  return noise;
}

NoiseRoots NoiseOfAll(const CalibrationProblem& problem, double fallback) {
  std::vector<int> all(problem.data().observations.size());
  std::iota(all.begin(), all.end(), 0);
  return ObservationNoise(problem, all, fallback);
}

NoiseRoots FitRoots(const CalibrationProblem& problem, const std::vector<int>& observations, double fallback) {
  if (problem.weight_roots.empty()) return ObservationNoise(problem, observations, fallback);
  NoiseRoots roots;
  roots.reserve(observations.size());
  for (const int i : observations) roots.push_back(problem.weight_roots[i]);
  return roots;
}

Linearization LinearizeByModel(const CalibrationProblem& problem, const ParameterSet& parameters,
                               const std::vector<int>& observations, const std::vector<int>& columns,
                               const NoiseRoots& noise, LatentTreatment treatment) {
  const LatentModel& latent = problem.latent;
  Linearization result;
  result.columns = columns;
  result.observations = observations;
  result.residual.setConstant(3 * observations.size(), std::nan(""));  // where no equilibrium is found
  result.jacobian.setZero(3 * observations.size(), columns.size());
  result.latent.setZero(3 * observations.size(), latent.size());
  const std::vector<int> column_of = ColumnOfCoordinate(parameters, columns);
  const ActiveParameters active = FindActive(parameters, column_of);
  result.valid = ForEachPrediction(
      problem, parameters, observations, active.model_parameters, !latent.empty(),
      [&](size_t k, const PointPrediction& prediction) {
        const Observation& observation = problem.data().observations[observations[k]];
        const Shot& shot = problem.data().shots[observation.shot];
        // r = S^-1 m(p), m = predicted - measured;  d r = S^-1 (dm/dp) (dp/dx) dx. dm/dp is 1 for a point, for a
        // rotation the inverse left Jacobian of the rotation vector m (models/reading.h).
        const Matrix3<double> root_inverse = noise[k].inverse();
        const Vector3<double> misfit = -MeasuredMinusPredicted(observation.reading(), prediction.point);
        result.residual.segment<3>(3 * k) = root_inverse * misfit;
        Matrix3<double> whitener = root_inverse;  // of what was not measured (NaN): the prediction's own derivative
        if (misfit.allFinite()) whitener *= MisfitByPrediction(observation.kind, misfit);
        const Eigen::Index first_row = columns.empty() ? 0 : 3 * static_cast<Eigen::Index>(k);
        auto rows = result.jacobian.middleRows(first_row, columns.empty() ? 0 : 3);
        const auto write = [&](int first_coordinate, const auto& derivative) {
          for (int i = 0; i < 3; ++i) {
            const int column = column_of[first_coordinate + i];
            if (column >= 0) rows.col(column) = whitener * derivative.col(i);
          }
        };
        write(parameters.station_translation(shot.station).first_coordinate, prediction.d_translation);
        write(parameters.station_rotation(shot.station).first_coordinate, prediction.d_rotation);
        write(parameters.read_block(observation.marker, observation.kind).first_coordinate, prediction.d_marker);
        for (size_t i = 0; i < active.columns.size(); ++i) {
          rows.col(active.columns[i]) = whitener * prediction.d_theta.col(i);
        }
        for (int i = 0; i < latent.size(); ++i) {
          // L: what one standard deviation of the joint moves.
          result.latent.block<3, 1>(3 * k, i) =
              latent.sigmas[i] * (whitener * prediction.d_latent.col(latent.joints[i]));
        }
      });
  if (treatment == LatentTreatment::kMarginalise && !latent.empty()) Marginalise(problem, &result);
  return result;
}

Eigen::Matrix3Xd ResidualsOf(const Measurements& data, const std::vector<int>& observations,
                             const Eigen::Matrix3Xd& predicted) {
  Eigen::Matrix3Xd residuals(3, observations.size());
  for (size_t k = 0; k < observations.size(); ++k) {
    residuals.col(k) = MeasuredMinusPredicted(data.observations[observations[k]].reading(), predicted.col(k));
  }
  return residuals;
}

Linearization Linearize(const CalibrationProblem& problem, const ParameterSet& parameters,
                        const std::vector<int>& observations, const std::vector<int>& columns, const NoiseRoots& noise,
                        LatentTreatment treatment) {
  if (observations.size() < kFewestOfBatch) {
    return LinearizeByModel(problem, parameters, observations, columns, noise, treatment);
  }
  Linearization result = Linearize(RowBatches(problem, observations, noise, treatment), parameters, columns);
  if (!result.valid) return LinearizeByModel(problem, parameters, observations, columns, noise, treatment);
  return result;
}

Linearization Linearize(const RowBatches& batches, const ParameterSet& parameters, const std::vector<int>& columns) {
  const RowBatches::Request request(batches, parameters, columns);
  const std::vector<int>& observations = batches.observations();
  Linearization result;
  result.columns = columns;
  result.observations = observations;
  result.residual.setZero(3 * observations.size());
  result.jacobian.setZero(3 * observations.size(), columns.size());
  result.latent.setZero(3 * observations.size(), batches.num_latents());
  BatchScratch scratch;
  BatchBuffer buffer;
  for (int g = 0; g < batches.num_groups(); ++g) {
    double* const rows =
        buffer.Reserve(static_cast<size_t>(batches.rows_of_unit(g)) * request.columns(g).columns * kBatchLanes);
    for (int b = 0; b < batches.num_batches(g); ++b) {
      CheckInterruption();
      result.valid = result.valid && batches.Evaluate(request, g, b, &scratch, rows);
      if (!result.valid) {
        result.residual.setConstant(std::nan(""));
        return result;
      }
      for (int lane = 0; lane < kBatchLanes; ++lane) {
        Unpack(request.columns(g), batches.UnitOf(g, b, lane), rows + lane, &result);
      }
    }
  }
  return result;
}

void AppendPriors(const ParameterSet& parameters, Linearization* linearization) {
  std::vector<int> held_softly;  // columns
  for (int c = 0; c < linearization->num_columns(); ++c) {
    if (parameters.coordinates()[linearization->columns[c]].has_prior()) held_softly.push_back(c);
  }
  const int rows = linearization->num_rows();
  const int priors = static_cast<int>(held_softly.size());
  linearization->residual.conservativeResize(rows + priors);
  linearization->jacobian.conservativeResize(rows + priors, Eigen::NoChange);
  // Without columns there is no memory to point into.
  if (priors > 0) linearization->jacobian.bottomRows(priors).setZero();
  for (int k = 0; k < priors; ++k) {
    const int c = held_softly[k];
    const Coordinate& coordinate = parameters.coordinates()[linearization->columns[c]];
    linearization->jacobian(rows + k, c) = 1.0 / coordinate.prior_sigma;
    linearization->residual[rows + k] = PriorResidual(coordinate, parameters.Value(linearization->columns[c]));
  }
  AppendSpringTie(parameters, linearization);
}

Eigen::Matrix3Xd PredictPoints(const CalibrationProblem& problem, const ParameterSet& parameters,
                               const std::vector<int>& observations) {
  constexpr size_t kAtOnce = 4096;  // observations, each of a shot that may continue: a shot is not what batches share
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Constant(3, observations.size(), std::nan(""));
  BatchScratch scratch;
  BatchBuffer buffer;
  for (size_t first = 0; first < observations.size(); first += kAtOnce) {
    CheckInterruption();
    const size_t last = std::min(observations.size(), first + kAtOnce);
    const std::vector<int> own(observations.begin() + static_cast<long>(first),
                               observations.begin() + static_cast<long>(last));
    const NoiseRoots metres(own.size(), Matrix3<double>::Identity());
    const RowBatches batches(problem, own, metres, LatentTreatment::kIgnore, RowsAgainst::kOrigin);
    const RowBatches::Request request(batches, parameters, {});
    for (int g = 0; g < batches.num_groups(); ++g) {
      const BatchColumns& columns = request.columns(g);
      double* const rows = buffer.Reserve(static_cast<size_t>(batches.rows_of_unit(g)) * columns.columns * kBatchLanes);
      for (int b = 0; b < batches.num_batches(g); ++b) {
        if (!batches.Evaluate(request, g, b, &scratch, rows)) return PointsByModel(problem, parameters, observations);
        for (int lane = 0; lane < kBatchLanes; ++lane) {
          const RowBatches::Unit unit = batches.UnitOf(g, b, lane);
          for (size_t k = 0; k < 3 * unit.size(); ++k) {
            points(static_cast<Eigen::Index>(k % 3), static_cast<Eigen::Index>(first) + unit[k / 3]) =
                rows[(k * columns.columns + columns.residual) * kBatchLanes + lane];
          }
        }
      }
    }
  }
  return points;
}

LinearSolution SolveLinearization(const Linearization& linearization) {
  LinearSolution solution;
  const int n = linearization.num_columns();
  if (n == 0) {  // everything is held
    solution.step.resize(0);
    solution.covariance.resize(0, 0);
    solution.covariance_root.resize(0, 0);
    solution.residual_norm_squared = linearization.residual.squaredNorm();
    return solution;
  }
  if (linearization.num_rows() < n) {  // fewer equations than unknowns
    solution.full_rank = false;
    solution.condition = std::numeric_limits<double>::infinity();
    return solution;
  }
  if (AreMany(linearization)) return SolveLinearization(Condense(SumRows(linearization)));
  if (SolveByProducts(linearization, &solution)) return solution;
  // J = Q R S, S the norms of the columns: the rank of R does not depend on units. d = -S^-1 R^-1 (Q'r)_1..n, W = S^-1
  // R^-1, and what no step explains is |(Q'r)_n+1..|^2.
  Eigen::VectorXd scale = linearization.jacobian.colwise().norm().cwiseMax(1e-300);
  const Eigen::MatrixXd scaled = linearization.jacobian * scale.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(scaled);
  const Eigen::MatrixXd r = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
  const Eigen::MatrixXd inverse = r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(n, n));
  solution.condition = ConditionOf(r, inverse);
  solution.full_rank = solution.condition < 1e12;  // of columns of unit norm: beyond, less than 4 of 16 digits are left
  const Eigen::VectorXd rotated = TransposedQ(qr, linearization.residual);
  solution.residual_norm_squared = rotated.tail(linearization.num_rows() - n).squaredNorm();
  if (!solution.full_rank) return solution;
  const Eigen::MatrixXd unscaled = scale.cwiseInverse().asDiagonal() * inverse;
  solution.step = -unscaled * rotated.head(n);
  solution.covariance_root = unscaled;
  solution.covariance = unscaled * unscaled.transpose();
  return solution;
}

}  // namespace sagitta
