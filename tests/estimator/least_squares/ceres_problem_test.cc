#include "estimator/least_squares/ceres_problem.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/linearization.h"
#include "tests/support/in_memory.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::ceres_problem_test {
namespace {

using test::Kr270Design;
using test::Kr270Problem;
using test::Kr270Truth;

// A foreign cost: somebody measured the distance between two tool markers.
struct MarkerDistance {
  double distance;
  double sigma;
  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    const Vector3<T> gap = Eigen::Map<const Vector3<T>>(a) - Eigen::Map<const Vector3<T>>(b);
    residual[0] = (gap.norm() - distance) / sigma;
    return true;
  }
};

TEST(AddToProblem, ForeignCostSharesOurBlocks) {
  const Kr270Truth truth;
  const CalibrationProblem problem = Kr270Problem(Kr270Design(), truth, 21);
  const Estimate alone = EstimateJointly(problem);
  ParameterSet parameters = alone.aligned;
  ceres::Problem ceres_problem;
  AddToProblem(problem, CalibrationResiduals(problem), &parameters, &ceres_problem);
  const double distance = (truth.tools[0] - truth.tools[2]).norm();
  double* a = parameters.marker(0).values.data();
  double* b = parameters.marker(2).values.data();
  ceres_problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<MarkerDistance, 1, 3, 3>(new MarkerDistance{distance, 1e-8}), nullptr, a, b);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 1e-15;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  ASSERT_TRUE(summary.IsSolutionUsable());
  // The foreign measurement is met, at the price of our residuals.
  EXPECT_NEAR((parameters.MarkerPoint(0) - parameters.MarkerPoint(2)).norm(), distance, 1e-7);
  EXPECT_GT(std::abs((alone.parameters.MarkerPoint(0) - alone.parameters.MarkerPoint(2)).norm() - distance), 1e-6);
  EXPECT_GE(summary.final_cost, alone.cost);
}

// What Ceres sees is the same Jacobian as the Linearization that judges it.
TEST(AddToProblem, CeresAndLinearizationSeeTheSameJacobian) {
  for (const double size : {0.0, 1e-8, 0.3}) {
    CalibrationProblem problem = Kr270Problem(Kr270Design(), Kr270Truth(), 22);
    std::srand(9);
    ParameterSet parameters = problem.parameters;
    parameters.Plus(size * Eigen::VectorXd::Random(parameters.num_coordinates()));
    const ResidualSelection selection = CalibrationResiduals(problem);
    const Linearization linearization =
        Linearize(problem, parameters, selection.observations, parameters.EstimatedCoordinates(), selection.noise);
    ceres::Problem ceres_problem;
    AddToProblem(problem, selection, &parameters, &ceres_problem);
    ceres::Problem::EvaluateOptions options;
    for (ParameterBlock block : parameters.blocks()) {
      ParameterBlock& own = block.kind == BlockKind::kMarker            ? parameters.marker(block.owner)
                            : block.kind == BlockKind::kModelParameter  ? parameters.model_parameter(block.owner)
                            : block.kind == BlockKind::kStationRotation ? parameters.station_rotation(block.owner)
                                                                        : parameters.station_translation(block.owner);
      options.parameter_blocks.push_back(own.values.data());
    }
    std::vector<double> residuals;
    ceres::CRSMatrix sparse;
    ceres_problem.Evaluate(options, nullptr, &residuals, nullptr, &sparse);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
    for (int r = 0; r < sparse.num_rows; ++r) {
      for (int k = sparse.rows[r]; k < sparse.rows[r + 1]; ++k) jacobian(r, sparse.cols[k]) = sparse.values[k];
    }
    ASSERT_EQ(jacobian.cols(), linearization.jacobian.cols());
    EXPECT_LT((jacobian - linearization.jacobian).norm(), 1e-12 * jacobian.norm());
    EXPECT_LT((Eigen::Map<Eigen::VectorXd>(residuals.data(), residuals.size()) - linearization.residual).norm(),
              1e-12 * linearization.residual.norm() + 1e-9);
  }
}

// Pulls the sum of all parameters of the model away from where it is.
struct PullsEverything {
  int count;
  double away;  // SI
  template <typename T>
  bool operator()(T const* const* blocks, T* residual) const {
    residual[0] = T(-away);
    for (int i = 0; i < count; ++i) residual[0] += blocks[i][0];
    residual[0] *= T(1e4);
    return true;
  }
};

// The redundant errors of a DH arm, and what is fixed, are read by no cost of ours: a foreign cost that reads them does
// not free them.
TEST(AddToProblem, ForeignCostsFreeNothing) {
  Experiment experiment;
  experiment.estimate.fixed = {"geometry/A2.a", "marker/M2/z"};
  experiment.markers["M2"].point = Vector3<double>(-0.03, 0.06, 0.12);
  const Robot arm = test::ArmInMemory();
  const CalibrationProblem problem = MakeCalibrationProblem(arm, test::ReadingsInMemory(arm), experiment);
  ParameterSet parameters = EstimateJointly(problem).parameters;
  const ParameterSet before = parameters;
  ceres::Problem ceres_problem;
  AddToProblem(problem, CalibrationResiduals(problem), &parameters, &ceres_problem);
  auto* cost = new ceres::DynamicAutoDiffCostFunction<PullsEverything>(
      new PullsEverything{parameters.num_model_parameters(), 0.1});
  std::vector<double*> blocks;
  for (int i = 0; i < parameters.num_model_parameters(); ++i) {
    blocks.push_back(parameters.model_parameter(i).values.data());
    cost->AddParameterBlock(1);
  }
  cost->SetNumResiduals(1);
  ceres_problem.AddResidualBlock(cost, nullptr, blocks);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  ASSERT_TRUE(summary.IsSolutionUsable());
  int held = 0;
  double moved = 0.0;
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    const bool is_estimated = parameters.coordinates()[i].estimated();
    held += is_estimated ? 0 : 1;
    const double by = std::abs(parameters.Value(i) - before.Value(i));
    if (is_estimated) {
      moved = std::max(moved, by);
    } else {
      EXPECT_EQ(by, 0.0) << parameters.coordinates()[i].name;
    }
  }
  EXPECT_GE(held, 12);
  EXPECT_GT(moved, 1e-4);
}

// The rows of one set in two calls are those in one: a prior, the joints' deviations and the tie of a spring count
// once. 3 rows per observation, one per prior, one per deviation of a joint.
TEST(AddToProblem, PriorsCountOnceHoweverOftenItIsCalled) {
  Experiment experiment;
  experiment.repeatability.angle.common = 2e-5;
  experiment.priors["geometry/A2.a"] = {0.0, 0.003};
  experiment.priors["marker/M1/z"] = {100.0, 0.1};
  const Robot arm = test::ArmInMemory();
  const CalibrationProblem problem = MakeCalibrationProblem(arm, test::ReadingsInMemory(arm), experiment);
  const ResidualSelection whole = CalibrationResiduals(problem);
  ResidualSelection parts[2];
  for (size_t k = 0; k < whole.observations.size(); ++k) {
    ResidualSelection& part = parts[problem.data().observations[whole.observations[k]].marker == 0 ? 0 : 1];
    part.observations.push_back(whole.observations[k]);
    part.noise.push_back(whole.noise[k]);
  }
  ParameterSet parameters = problem.parameters;
  LatentBlocks latents, others;
  ceres::Problem ceres_problem;
  for (const ResidualSelection& part : parts) AddToProblem(problem, part, &parameters, &ceres_problem, &latents);
  const int rows = 3 * static_cast<int>(whole.observations.size());
  EXPECT_EQ(ceres_problem.NumResiduals(), rows + 2 + 6 * problem.latent.num_visits);
  EXPECT_THROW(AddToProblem(problem, parts[0], &parameters, &ceres_problem, &others), std::invalid_argument);
  EXPECT_THROW(AddToProblem(problem, parts[0], &parameters, &ceres_problem), std::invalid_argument);
  // Another robot of the same kind has priors of its own.
  ParameterSet second = problem.parameters;
  AddToProblem(problem, whole, &second, &ceres_problem, &others);
  EXPECT_EQ(ceres_problem.NumResiduals(), 2 * (rows + 2 + 6 * problem.latent.num_visits));
  for (const double* block : {parameters.marker(0).values.data(), second.marker(0).values.data()}) {
    ASSERT_TRUE(ceres_problem.HasParameterBlock(block));
  }
}

// Independent of every derivative of ours: differences of the residual along
// tangent steps.
TEST(Linearization, JacobianMatchesCentralDifferences) {
  CalibrationProblem problem = Kr270Problem(Kr270Design(), Kr270Truth(), 23);
  std::srand(3);
  ParameterSet parameters = problem.parameters;
  parameters.Plus(0.2 * Eigen::VectorXd::Random(parameters.num_coordinates()));
  const ResidualSelection selection = CalibrationResiduals(problem);
  const Linearization at =
      Linearize(problem, parameters, selection.observations, parameters.EstimatedCoordinates(), selection.noise);
  const auto residual = [&](int coordinate, double step) {
    ParameterSet moved = parameters;
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters.num_coordinates());
    delta[coordinate] = step;
    moved.Plus(delta);
    return Linearize(problem, moved, selection.observations, {}, selection.noise).residual;
  };
  for (int c = 0; c < at.num_columns(); ++c) {
    const double h = 1e-3;  // fourth-order differences
    const int i = at.columns[c];
    const Eigen::VectorXd difference =
        (8.0 * (residual(i, h) - residual(i, -h)) - (residual(i, 2 * h) - residual(i, -2 * h))) / (12.0 * h);
    EXPECT_LT((difference - at.jacobian.col(c)).norm(), 1e-9 * at.jacobian.col(c).norm())
        << parameters.coordinates()[i].name;
  }
}

}  // namespace
}  // namespace sagitta::ceres_problem_test
