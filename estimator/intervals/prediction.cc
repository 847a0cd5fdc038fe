#include "estimator/intervals/prediction.h"

#include <algorithm>
#include <map>
#include <utility>

#include "estimator/intervals/predicted_sums.h"
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

// Of the points among the listed observations; rows of A by its header.
PredictedSquares SquaresOf(const CalibrationProblem& problem, const PredictedRows& rows,
                           const ParameterUncertainty& uncertainty, const std::vector<int>& observations,
                           double noise_scale, const NoiseRoots& instrument) {
  const std::vector<int> arrival_of = ArrivalsOf(problem, observations);
  std::map<int, std::vector<int>> arrivals;
  for (size_t k = 0; k < observations.size(); ++k) {
    const bool is_point = problem.data().observations[observations[k]].is_point();
    if (is_point) arrivals[arrival_of[k]].push_back(static_cast<int>(k));
  }
  const Eigen::MatrixXd of_estimated = RootOf(uncertainty.covariance), of_held = RootOf(uncertainty.second_moment);
  const Eigen::Index p = of_estimated.cols() + of_held.cols();
  PredictedSums sums(static_cast<int>(p));
  for (const auto& [arrival, own] : arrivals) {
    std::vector<int> listed;
    NoiseRoots noise;
    for (const int k : own) {
      listed.insert(listed.end(), {3 * k, 3 * k + 1, 3 * k + 2});
      noise.push_back(instrument[static_cast<size_t>(k)]);
    }
    RowMajorMatrix a(listed.size(), p);
    a << rows.estimated(listed, Eigen::all) * of_estimated, rows.held(listed, Eigen::all) * of_held;
    sums.AddArrival(noise, a, noise_scale * rows.latent(listed, Eigen::all));
  }
  return sums.Squares(Eigen::MatrixXd::Identity(p, p));
}

}  // namespace

std::vector<std::string> ParameterUncertainty::Names() const {
  std::vector<std::string> names = estimated;
  names.insert(names.end(), held.begin(), held.end());
  return names;
}

Matrix3<double> AddedByRest(const Matrix3<double>& covariance, double rest) {
  return std::max(0.0, rest * rest - covariance.trace()) / 3.0 * Matrix3<double>::Identity();
}

std::vector<PredictionCovariance> PredictionCovariances(const CalibrationProblem& problem,
                                                        const ParameterUncertainty& uncertainty,
                                                        const std::vector<int>& observations, double noise_scale,
                                                        const NoiseRoots& instrument, PredictedSquares* together) {
  const PredictedRows rows = PredictedRowsOf(problem, uncertainty, observations);
  *together = SquaresOf(problem, rows, uncertainty, observations, noise_scale, instrument);
  std::vector<PredictionCovariance> result(observations.size());
  for (size_t k = 0; k < observations.size(); ++k) {
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

}  // namespace sagitta
