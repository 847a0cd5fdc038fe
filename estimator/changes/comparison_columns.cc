#include "estimator/changes/comparison_columns.h"

#include <algorithm>
#include <numeric>

namespace sagitta {
namespace {

bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

bool IsFree(const KnownRobot& known, const std::string& coordinate) {
  return Has(known.uncertainty.estimated, coordinate) || Has(known.uncertainty.held, coordinate);
}

bool IsOfCampaign(CoordinateKind kind) {
  return kind == CoordinateKind::kCompliance || kind == CoordinateKind::kCompensator || kind == CoordinateKind::kEffect;
}

Linearization AllColumns(const CalibrationProblem& problem, const std::vector<int>& rows) {
  std::vector<int> columns(problem.parameters.num_coordinates());
  std::iota(columns.begin(), columns.end(), 0);
  const NoiseRoots metres(rows.size(), Matrix3<double>::Identity());
  return Linearize(problem, problem.parameters, rows, columns, metres, LatentTreatment::kIgnore);
}

Eigen::VectorXd ZeroColumn(const Chain& chain, const Linearization& all, int joint) {
  const auto n = static_cast<long>(chain.num_joints());
  return all.latent * (chain.CoupledJointValues(Eigen::VectorXd::Unit(n, joint)) -
                       chain.CoupledJointValues(Eigen::VectorXd::Zero(n)));
}

Eigen::MatrixXd NamedColumns(const std::vector<std::string>& names, const CalibrationProblem& problem,
                             const Eigen::MatrixXd& jacobian) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(jacobian.rows(), static_cast<long>(names.size()));
  for (size_t i = 0; i < names.size(); ++i) {
    const int coordinate = problem.parameters.FindCoordinate(names[i]);
    if (coordinate >= 0) columns.col(static_cast<long>(i)) = jacobian.col(coordinate);
  }
  return columns;
}

Eigen::MatrixXd SideBySide(const std::vector<Eigen::MatrixXd>& parts, long rows) {
  long width = 0;
  for (const Eigen::MatrixXd& part : parts) width += part.cols();
  Eigen::MatrixXd joined(rows, width);
  width = 0;
  for (const Eigen::MatrixXd& part : parts) joined.middleCols(width, part.cols()) = part, width += part.cols();
  return joined;
}

}  // namespace sagitta
