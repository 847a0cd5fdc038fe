#include "estimator/least_squares/condensed_cost.h"

#include <ceres/cost_function.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/least_squares/constrained_blocks.h"
#include "estimator/least_squares/rotation_manifold.h"

namespace sagitta {
namespace {

using RowMajorBlock = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

bool IsEstimated(const ParameterSet& parameters, const ParameterBlock& block) {
  for (int i = 0; i < block.tangent_size; ++i) {
    if (parameters.coordinates()[block.first_coordinate + i].estimated()) return true;
  }
  return false;
}

ParameterBlock& BlockOf(int b, ParameterSet* parameters) {
  return const_cast<ParameterBlock&>(parameters->blocks()[b]);
}

class CondensedCost : public ceres::CostFunction {
 public:
  CondensedCost(const NormalEquations& equations, const ParameterSet& parameters)
      : equations_(equations), start_(parameters), columns_(parameters.EstimatedCoordinates()) {
    for (int b = 0; b < static_cast<int>(parameters.blocks().size()); ++b) {
      if (!IsEstimated(parameters, parameters.blocks()[b])) continue;
      blocks_.push_back(b);
      mutable_parameter_block_sizes()->push_back(static_cast<int>(parameters.blocks()[b].values.size()));
    }
    set_num_residuals(static_cast<int>(columns_.size()) + 1);
  }

  const std::vector<int>& blocks() const { return blocks_; }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    ParameterSet here = start_;
    for (size_t b = 0; b < blocks_.size(); ++b) {
      std::vector<double>& values = BlockOf(blocks_[b], &here).values;
      std::copy(parameters[b], parameters[b] + values.size(), values.begin());
    }
    const int n = static_cast<int>(columns_.size());
    Eigen::Map<Eigen::VectorXd> residual(residuals, n + 1);
    if (jacobians == nullptr) {
      // With the columns, which Ceres asks for next unless the step was a bad one.
      const NormalSums sums = equations_.Sum(here, columns_, {}, /*with_priors=*/false);
      // Ceres compares |residual|^2 alone: one row holds its root.
      residual.setZero();
      if (sums.valid) residual[n] = std::sqrt(sums.squared_residual() + SquaredPriors(here));
      return sums.valid;
    }
    const Linearization rows = Condense(equations_.Sum(here, columns_));
    if (!rows.valid) return false;
    residual = rows.residual;
    std::vector<int> column_of(here.num_coordinates(), -1);
    for (int c = 0; c < n; ++c) column_of[columns_[c]] = c;
    for (size_t b = 0; b < blocks_.size(); ++b) {
      if (jacobians[b] == nullptr) continue;
      const ParameterBlock& block = here.blocks()[blocks_[b]];
      Eigen::MatrixXd tangent = Eigen::MatrixXd::Zero(n + 1, block.tangent_size);
      for (int i = 0; i < block.tangent_size; ++i) {
        const int c = column_of[block.first_coordinate + i];
        if (c >= 0) tangent.col(i) = rows.jacobian.col(c);
      }
      RowMajorBlock out(jacobians[b], n + 1, static_cast<int>(block.values.size()));
      if (IsRotation(block.kind)) {
        // Ambient = tangent * pseudo-inverse of PlusJacobian (orthogonal columns of norm 1/2).
        out = tangent * (4.0 * QuaternionPlusJacobian(block.values.data()).transpose());
      } else {
        out = tangent;
      }
    }
    return true;
  }

 private:
  // The cost alone has the same as the cost with its derivatives.
  double SquaredPriors(const ParameterSet& here) const {
    Linearization priors;
    priors.columns = columns_;
    priors.jacobian.resize(0, static_cast<Eigen::Index>(columns_.size()));
    AppendPriors(here, &priors);
    return priors.residual.squaredNorm();
  }

  const NormalEquations& equations_;
  const ParameterSet start_;
  const std::vector<int> columns_;
  std::vector<int> blocks_;
};

}  // namespace

void AddCondensed(const NormalEquations& equations, ParameterSet* parameters, ceres::Problem* ceres_problem) {
  auto cost = std::make_unique<CondensedCost>(equations, *parameters);
  std::vector<double*> values;
  for (const int b : cost->blocks()) values.push_back(BlockOf(b, parameters).values.data());
  if (values.empty()) return;
  ceres_problem->AddResidualBlock(cost.release(), nullptr, values);
  ConstrainBlocks(*parameters, ceres_problem);
}

}  // namespace sagitta
