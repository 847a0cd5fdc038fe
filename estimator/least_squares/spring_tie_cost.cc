#include "estimator/least_squares/spring_tie_cost.h"

#include <ceres/dynamic_autodiff_cost_function.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>

#include "estimator/report/least_squares_words.h"

namespace sagitta {
namespace {

constexpr int kStride = 4;                // derivatives per automatic pass
constexpr double kOnTheAxis = 0.01;       // of L in the file: closer to the axis the ends have no direction
constexpr double kPlausible = 0.2;        // of the length in the robot file: levers are some 0.2 m, markers miss by mm
constexpr double kSameCovariance = 0.05;  // of its norm: standard deviations that change by 2.5 %

// Blocks: lever marker, anchor marker, then the free geometric errors between, then the free ones of L, a_x, a_y.
struct SpringTieFunctor {
  SpringAnchors anchors;
  std::vector<double> values;    // of the transforms between, free errors left out
  std::vector<int> free_errors;  // index into `values`, one per block
  std::vector<int> rows;         // which of L, a_x, a_y, one per block
  Eigen::MatrixXd whitening;

  template <typename T>
  bool operator()(T const* const* blocks, T* residuals) const {
    std::vector<T> between(values.begin(), values.end());
    for (size_t e = 0; e < free_errors.size(); ++e) between[free_errors[e]] += blocks[2 + e][0];
    const Vector3<T> lever = Eigen::Map<const Vector3<T>>(blocks[0]), anchor = Eigen::Map<const Vector3<T>>(blocks[1]);
    const Vector3<T> measured = SpringGeometry(anchors, between.data(), lever, anchor);
    for (size_t i = 0; i < rows.size(); ++i) {
      residuals[i] = T(0.0);
      for (size_t k = 0; k <= i; ++k) {
        residuals[i] += T(whitening(i, k)) * (measured[rows[k]] - blocks[2 + free_errors.size() + k][0]);
      }
    }
    return true;
  }
};

using SpringTieFunction = ceres::DynamicAutoDiffCostFunction<SpringTieFunctor, kStride>;

struct SpringTieCost {
  std::unique_ptr<SpringTieFunction> function;
  std::vector<const ParameterBlock*> blocks;
};

// `estimated(c)`: whether coordinate c is. No function where none of L, a_x, a_y is.
template <typename IsEstimated>
SpringTieCost MakeCost(const ParameterSet& parameters, const IsEstimated& estimated) {
  SpringTieCost cost;
  if (!parameters.spring_tie()) return cost;
  const SpringTie& tie = *parameters.spring_tie();
  auto functor = std::make_unique<SpringTieFunctor>();
  functor->anchors = tie.anchors;
  cost.blocks = {&parameters.marker(tie.lever_marker), &parameters.marker(tie.anchor_marker)};
  for (size_t e = 0; e < tie.errors.size(); ++e) {
    functor->values.push_back(tie.anchors.between.transforms[e].nominal);
    if (tie.errors[e] < 0) continue;
    const ParameterBlock& block = parameters.model_parameter(tie.errors[e]);
    if (estimated(block.first_coordinate)) {
      functor->free_errors.push_back(static_cast<int>(e));
      cost.blocks.push_back(&block);
    } else {
      functor->values.back() += block.values[0];
    }
  }
  for (int i = 0; i < 3; ++i) {
    const ParameterBlock& block = parameters.model_parameter(tie.geometry[i]);
    if (!estimated(block.first_coordinate)) continue;
    functor->rows.push_back(i);
    cost.blocks.push_back(&block);
  }
  if (functor->rows.empty()) return cost;
  const int size = static_cast<int>(functor->rows.size());
  // W = F^-1 with F F' = C, lower triangular: residual i mixes misfits 0 .. i.
  const Eigen::MatrixXd covariance = tie.covariance(functor->rows, functor->rows);
  functor->whitening = covariance.llt().matrixL().solve(Eigen::MatrixXd::Identity(size, size));
  cost.function = std::make_unique<SpringTieFunction>(functor.release());
  for (const ParameterBlock* block : cost.blocks)
    cost.function->AddParameterBlock(static_cast<int>(block->values.size()));
  cost.function->SetNumResiduals(size);
  return cost;
}

}  // namespace

void AppendSpringTie(const ParameterSet& parameters, Linearization* linearization) {
  std::vector<int> column_of(parameters.num_coordinates(), -1);
  for (int c = 0; c < linearization->num_columns(); ++c) column_of[linearization->columns[c]] = c;
  const SpringTieCost cost =
      MakeCost(parameters, [&](int c) { return column_of[c] >= 0 || parameters.coordinates()[c].estimated(); });
  if (!cost.function) return;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int first = linearization->num_rows(), added = cost.function->num_residuals();
  std::vector<RowMajor> jacobians;
  std::vector<const double*> values;
  for (const ParameterBlock* block : cost.blocks) {
    jacobians.emplace_back(added, block->tangent_size);
    values.push_back(block->values.data());
  }
  std::vector<double*> derivatives;
  for (RowMajor& jacobian : jacobians) derivatives.push_back(jacobian.data());
  linearization->residual.conservativeResize(first + added);
  linearization->jacobian.conservativeResize(first + added, Eigen::NoChange);
  linearization->jacobian.bottomRows(added).setZero();
  cost.function->Evaluate(values.data(), linearization->residual.data() + first, derivatives.data());
  for (size_t b = 0; b < cost.blocks.size(); ++b) {
    for (int i = 0; i < cost.blocks[b]->tangent_size; ++i) {
      const int column = column_of[cost.blocks[b]->first_coordinate + i];
      if (column >= 0) linearization->jacobian.bottomRows(added).col(column) = jacobians[b].col(i);
    }
  }
}

namespace {

// Of these blocks, from an earlier call.
bool HasTie(const std::vector<double*>& blocks, const ceres::Problem& problem) {
  std::vector<ceres::ResidualBlockId> residuals;
  problem.GetResidualBlocks(&residuals);
  return std::any_of(residuals.begin(), residuals.end(), [&](ceres::ResidualBlockId id) {
    if (dynamic_cast<const SpringTieFunction*>(problem.GetCostFunctionForResidualBlock(id)) == nullptr) return false;
    std::vector<double*> own;
    problem.GetParameterBlocksForResidualBlock(id, &own);
    return own == blocks;
  });
}

}  // namespace

void AddSpringTie(const ParameterSet* parameters, ceres::Problem* ceres_problem) {
  SpringTieCost cost =
      MakeCost(*parameters, [&](int coordinate) { return parameters->coordinates()[coordinate].estimated(); });
  if (!cost.function) return;
  std::vector<double*> blocks;
  for (const ParameterBlock* block : cost.blocks) blocks.push_back(const_cast<double*>(block->values.data()));
  if (HasTie(blocks, *ceres_problem)) return;
  ceres_problem->AddResidualBlock(cost.function.release(), nullptr, blocks);
}

namespace {

Eigen::Vector3d GeometryOfMarkers(const ParameterSet& parameters) {
  const SpringTie& tie = *parameters.spring_tie();
  std::vector<double> between;
  for (size_t e = 0; e < tie.errors.size(); ++e) {
    between.push_back(tie.anchors.between.transforms[e].nominal);
    if (tie.errors[e] >= 0) between.back() += parameters.model_parameter(tie.errors[e]).values[0];
  }
  return SpringGeometry(tie.anchors, between.data(), parameters.MarkerPoint(tie.lever_marker),
                        parameters.MarkerPoint(tie.anchor_marker));
}

}  // namespace

Eigen::Vector3d SpringTieMisfit(const ParameterSet& parameters) {
  Eigen::Vector3d misfit = GeometryOfMarkers(parameters);
  for (int i = 0; i < 3; ++i) {
    misfit[i] -= parameters.model_parameter(parameters.spring_tie()->geometry[i]).values[0];
  }
  return misfit;
}

void DropImplausibleTie(ParameterSet* parameters) {
  if (!parameters->spring_tie() || !parameters->spring_tie()->is_assumed) return;
  const SpringTie& tie = *parameters->spring_tie();
  const Eigen::Vector3d off = GeometryOfMarkers(*parameters) - tie.stated;
  const bool lever_fits = std::abs(off[0]) <= kPlausible * tie.stated[0];
  const bool anchor_fits = off.tail<2>().norm() <= kPlausible * tie.stated.tail<2>().norm();
  if (!lever_fits || !anchor_fits) parameters->DropSpringTie();
}

bool WeighSpringTie(ParameterSet* parameters) {
  if (!parameters->spring_tie()) return false;
  SpringTie tie = *parameters->spring_tie();
  const Eigen::Vector3d placed = GeometryOfMarkers(*parameters);
  if (!placed.allFinite() || placed[0] < kOnTheAxis * tie.stated[0]) return false;
  const Eigen::Matrix3d here = CovarianceOfEnds(placed, tie);
  if ((here - tie.covariance).norm() <= kSameCovariance * here.norm()) return false;
  tie.covariance = here;
  parameters->SetSpringTie(tie);
  return true;
}

std::string TieInWords(const CalibrationProblem& problem, const ParameterSet& estimated) {
  if (!problem.parameters.spring_tie()) return "";
  const SpringTie& tie = *problem.parameters.spring_tie();
  bool any = false;
  for (const int parameter : tie.geometry)
    any |= estimated.coordinates()[estimated.model_parameter(parameter).first_coordinate].free;
  if (!any) return "";
  const std::string& lever = problem.data().markers[tie.lever_marker];
  const std::string& anchor = problem.data().markers[tie.anchor_marker];
  if (!estimated.spring_tie()) return MarkersAreNotTheEnds(lever, anchor);
  return tie.sigma_is_stated ? "" : MarkersAreAssumedEnds(lever, anchor);
}

}  // namespace sagitta
