#include "estimator/intervals/prediction.h"

#include <algorithm>
#include <map>
#include <utility>

#include "estimator/least_squares/row_sums.h"
#include "models/row_block.h"
#include "problems/interruption.h"

namespace sagitta {
namespace {

// Columns of the named coordinates; zero where the problem has no such coordinate.
Eigen::MatrixXd PredictedColumns(const std::vector<std::string>& names, const ParameterSet& parameters,
                                 const Linearization& linearization) {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(linearization.num_rows(), names.size());
  for (size_t i = 0; i < names.size(); ++i) {
    const int coordinate = parameters.FindCoordinate(names[i]);
    for (int c = 0; coordinate >= 0 && c < linearization.num_columns(); ++c) {
      if (linearization.columns[c] == coordinate) jacobian.col(i) = linearization.jacobian.col(c);
    }
  }
  return jacobian;
}

// What the points of the listed observations depend on, m/SI.
struct PredictedRows {
  Eigen::MatrixXd estimated, held, latent;
};

PredictedRows PredictedRowsOf(const CalibrationProblem& problem, const ParameterUncertainty& uncertainty,
                              const std::vector<int>& observations) {
  std::vector<int> columns;
  for (const std::vector<std::string>* names : {&uncertainty.estimated, &uncertainty.held}) {
    for (const std::string& name : *names) {
      const int coordinate = problem.parameters.FindCoordinate(name);
      if (coordinate >= 0) columns.push_back(coordinate);
    }
  }
  const NoiseRoots metres(observations.size(), Matrix3<double>::Identity());
  const Linearization all =
      Linearize(problem, problem.parameters, observations, columns, metres, LatentTreatment::kIgnore);
  PredictedRows rows;
  rows.estimated = PredictedColumns(uncertainty.estimated, problem.parameters, all);
  rows.held = PredictedColumns(uncertainty.held, problem.parameters, all) + rows.estimated * uncertainty.slopes;
  rows.latent = all.latent;
  return rows;
}

std::vector<PredictionCovariance> CovariancesOf(const PredictedRows& rows, const ParameterUncertainty& uncertainty,
                                                size_t observations, double noise_scale) {
  std::vector<PredictionCovariance> result(observations);
  for (size_t k = 0; k < observations; ++k) {
    CheckInterruption();
    const Eigen::MatrixXd j = RowBlock(rows.estimated, 3 * k, 3);
    const Eigen::MatrixXd h = RowBlock(rows.held, 3 * k, 3);
    const Eigen::MatrixXd l = RowBlock(rows.latent, 3 * k, 3);
    // J C J', K S K' and L L' of the header, m^2.
    result[k].parameters = j * uncertainty.covariance * j.transpose();
    result[k].held = h * uncertainty.second_moment * h.transpose();
    result[k].arm = noise_scale * noise_scale * (l * l.transpose());
  }
  return result;
}

// tr V = tr A'A + sum tr B, tr V^2 = |A'A|^2 + sum over arrivals of 2 tr A'B A + |B|^2.
PredictionTraces TracesOf(const CalibrationProblem& problem, const PredictedRows& rows,
                          const ParameterUncertainty& uncertainty, const std::vector<int>& observations,
                          double noise_scale, const NoiseRoots& instrument) {
  std::map<std::pair<int, std::string>, std::vector<size_t>> arrivals;
  for (size_t k = 0; k < observations.size(); ++k) {
    const Observation& row = problem.data().observations[observations[k]];
    const Shot& shot = problem.data().shots[row.shot];
    if (row.is_point()) arrivals[{shot.configuration, shot.visit}].push_back(k);
  }
  const Eigen::MatrixXd of_estimated = RootOf(uncertainty.covariance), of_held = RootOf(uncertainty.second_moment);
  const Eigen::Index p = of_estimated.cols() + of_held.cols();
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(p, p);
  PredictionTraces traces;
  for (const auto& [arrival, own] : arrivals) {
    const auto n = static_cast<Eigen::Index>(3 * own.size());
    Eigen::MatrixXd a(n, p), l(n, rows.latent.cols()), b = Eigen::MatrixXd::Zero(n, n);
    for (size_t i = 0; i < own.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      a.middleRows(at, 3) << RowBlock(rows.estimated, 3 * own[i], 3) * of_estimated,
          RowBlock(rows.held, 3 * own[i], 3) * of_held;
      l.middleRows(at, 3) = noise_scale * RowBlock(rows.latent, 3 * own[i], 3);
      b.block(at, at, 3, 3) = instrument[own[i]] * instrument[own[i]].transpose();
    }
    b += l * l.transpose();
    products += a.transpose() * a;
    traces.trace += b.trace();
    traces.trace_of_square += b.squaredNorm() + 2.0 * (b * a).cwiseProduct(a).sum();
  }
  traces.trace += products.trace();
  traces.trace_of_square += products.squaredNorm();
  return traces;
}

}  // namespace

Matrix3<double> AddedByRest(const Matrix3<double>& covariance, double rest) {
  return std::max(0.0, rest * rest - covariance.trace()) / 3.0 * Matrix3<double>::Identity();
}

ParameterUncertainty UncertaintyOf(const Estimate& estimate) {
  ParameterUncertainty uncertainty;
  const std::vector<Coordinate>& coordinates = estimate.parameters.coordinates();
  for (const int i : estimate.estimated) uncertainty.estimated.push_back(coordinates[i].name);
  for (const int i : estimate.held.coordinates) uncertainty.held.push_back(coordinates[i].name);
  uncertainty.covariance = estimate.covariance;
  uncertainty.slopes = estimate.held.slopes;
  uncertainty.second_moment = estimate.held.second_moment;
  return uncertainty;
}

std::vector<PredictionCovariance> PredictionCovariances(const CalibrationProblem& problem,
                                                        const ParameterUncertainty& uncertainty,
                                                        const std::vector<int>& observations, double noise_scale) {
  return CovariancesOf(PredictedRowsOf(problem, uncertainty, observations), uncertainty, observations.size(),
                       noise_scale);
}

std::vector<PredictionCovariance> PredictionCovariances(const CalibrationProblem& problem,
                                                        const ParameterUncertainty& uncertainty,
                                                        const std::vector<int>& observations, double noise_scale,
                                                        const NoiseRoots& instrument, PredictionTraces* traces) {
  const PredictedRows rows = PredictedRowsOf(problem, uncertainty, observations);
  *traces = TracesOf(problem, rows, uncertainty, observations, noise_scale, instrument);
  return CovariancesOf(rows, uncertainty, observations.size(), noise_scale);
}

}  // namespace sagitta
