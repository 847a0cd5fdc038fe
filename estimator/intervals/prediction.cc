#include "estimator/intervals/prediction.h"

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

}  // namespace

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
  const Eigen::MatrixXd estimated = PredictedColumns(uncertainty.estimated, problem.parameters, all);
  const Eigen::MatrixXd held =
      PredictedColumns(uncertainty.held, problem.parameters, all) + estimated * uncertainty.slopes;
  std::vector<PredictionCovariance> result(observations.size());
  for (size_t k = 0; k < observations.size(); ++k) {
    CheckInterruption();
    const Eigen::MatrixXd j = RowBlock(estimated, 3 * k, 3);
    const Eigen::MatrixXd h = RowBlock(held, 3 * k, 3);
    const Eigen::MatrixXd l = RowBlock(all.latent, 3 * k, 3);
    // J C J', K S K' and L L' of the header, m^2.
    result[k].parameters = j * uncertainty.covariance * j.transpose();
    result[k].held = h * uncertainty.second_moment * h.transpose();
    result[k].arm = noise_scale * noise_scale * (l * l.transpose());
  }
  return result;
}

}  // namespace sagitta
