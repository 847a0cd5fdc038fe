// The one pass over the rows against the model, observation by observation, on problems of every kind: rows, sums,
// estimates; and that the number of threads does not show in any digit.
#include "estimator/least_squares/normal_equations.h"

#include <ceres/crs_matrix.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include "estimator/alignment/starting_values.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/cluster_sandwich.h"
#include "estimator/least_squares/condensed_cost.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/kr270_poses.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/random_numbers.h"
#include "tests/support/random_vector.h"
#include "tests/support/stated_torques.h"

namespace sagitta::normal_equations_test {
namespace {

CalibrationProblem Rigid(int configurations) {
  test::Kr270Design design;
  design.configurations = configurations;
  return test::Kr270Problem(design, test::Kr270Truth(), 11);
}

// Two stations, loads and pulls, a spring, markers on links.
CalibrationProblem Loaded(const std::function<void(test::LoadedTruth*, Experiment*)>& change) {
  test::LoadedTruth truth = test::Everything();
  Experiment wanted;
  change(&truth, &wanted);
  test::LoadedDesign design = test::WithPulls();
  design.configurations = 24;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), design.sigma, 5, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.experiment.repeatability = wanted.repeatability;
  setup.experiment.priors = wanted.priors;
  return MakeCalibrationProblem(setup.robot, data, setup.experiment);
}

// Terms of every law: of slots, stations, the arm's size, deflections, wrenches.
CalibrationProblem WithEffects() {
  const CalibrationProblem loaded = Loaded([](auto*, auto*) {});
  return loaded.WithEffects({{"joint_harmonic", "A3", {{"order", "1"}}, {}},
                             {"joint_harmonic", "A5", {{"order", "2"}}, {}},
                             {"station_scale", "S1", {}, {}},
                             {"transverse_compliance", "A4", {}, {}},
                             {"load_com", "V250", {}, {}}});
}

// Readings along lines of sight are the model's own; those of the other station go in batches.
CalibrationProblem WithSights() {
  const CalibrationProblem loaded = Loaded([](auto*, auto*) {});
  return loaded.WithEffects({{"station_range_offset", "S1", {}, {}}});
}

// Points of three markers, then poses of a target.
CalibrationProblem Poses(int configurations) {
  test::Kr270Design design;
  design.configurations = configurations;
  const test::Kr270Truth truth = test::TurnedTruth();
  const test::TargetTruth target;
  Measurements data = test::PoseRows(design);
  NormalNumbers normal(7);
  for (Observation& row : data.observations) {
    if (!row.is_point()) continue;
    const Pose<double> exact =
        test::ExactPose(truth, target, data.ConfigurationOf(row).q, data.shots[row.shot].station);
    Observation& rotation = data.observations[row.partner];
    const Vector3<double> off = test::RandomVector(normal), turn = test::RandomVector(normal);
    row.point_in_station = rotation.point_in_station = exact.translation + 1e-4 * off;
    rotation.mutable_rotation()->in_station = RotationFromVector<double>(1e-3 * turn) * exact.rotation;
  }
  return test::Kr270ProblemOf(data, Experiment());
}

// Torques stated on every joint of every shot.
CalibrationProblem MeasuredTorques() {
  Measurements data = test::DesignWithTorques();
  test::MeasureKr270(test::Kr270Truth(), test::Kr270Design().sigma, 9, &data);
  Experiment experiment;
  experiment.torques_measured = true;
  return test::Kr270ProblemOf(data, experiment);
}

// Weights as a robust loss leaves them: every row has a root of its own.
CalibrationProblem Weighted() {
  CalibrationProblem problem = Loaded([](auto*, auto*) {});
  test::RandomNumbers random(8);
  NoiseRoots roots;
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    roots.push_back(problem.SqrtCovariance(static_cast<int>(i)) / random.Uniform(0.2, 1.0));
    roots.back()(1, 0) = 0.3 * roots.back()(0, 0);
  }
  problem.resolved_noise = roots;
  return problem;
}

struct NamedProblem {
  const char* name;
  std::function<CalibrationProblem()> make;
};

void PrintTo(const NamedProblem& problem, std::ostream* out) { *out << problem.name; }

const NamedProblem kProblems[] = {
    {"Rigid", [] { return Rigid(21); }},
    {"ManyRigid", [] { return Rigid(600); }},  // more than one block of work, condensed rows
    {"Loaded", [] { return Loaded([](auto*, auto*) {}); }},
    {"LoadedWithoutSpring", [] { return Loaded([](test::LoadedTruth* truth, auto*) { truth->spring.reset(); }); }},
    {"LoadInTheFlange",
     [] { return Loaded([](test::LoadedTruth* truth, auto*) { truth->loads["PX"].frame = WrenchFrame::kFlange; }); }},
    {"JointsDeviate",
     [] { return Loaded([](auto*, Experiment* wanted) { wanted->repeatability.angle.common = 40e-6; }); }},
    {"Effects", WithEffects},
    {"LinesOfSight", WithSights},
    {"Poses", [] { return Poses(30); }},
    {"MeasuredTorques", MeasuredTorques},
    {"Weighted", Weighted},
    {"Priors", [] { return Loaded([](auto*, Experiment* wanted) {
                      wanted->priors["compliance/A2"] = {0.3, 0.05};
                    }); }},
};

class NormalEquationsOf : public testing::TestWithParam<NamedProblem> {
 protected:
  NormalEquationsOf() : problem_(GetParam().make()), rows_(CalibrationResiduals(problem_)) {
    parameters_ = problem_.parameters;
    AlignNominal(problem_, &parameters_);
    // Away from nominal, where everything bends.
    test::RandomNumbers random(3);
    for (int i = 0; i < parameters_.num_model_parameters(); ++i) {
      const ParameterBlock& block = parameters_.model_parameter(i);
      const Coordinate& coordinate = parameters_.coordinates()[block.first_coordinate];
      const double size = std::max(0.02 * std::abs(block.values[0]), 0.1 * TraitsOf(coordinate.quantity).hold_limit);
      parameters_.SetModelValue(i, block.values[0] + random.Uniform(0.0, size));
    }
    columns_ = parameters_.EstimatedCoordinates();
  }

  CalibrationProblem problem_;
  ResidualSelection rows_;
  ParameterSet parameters_;
  std::vector<int> columns_;
};

// Rows: residuals to 1e-7 of the noise, derivatives to the last Newton step (1e-8) of their column.
TEST_P(NormalEquationsOf, BatchedRowsAreTheModels) {
  for (const LatentTreatment treatment : {LatentTreatment::kIgnore, LatentTreatment::kMarginalise}) {
    const Linearization model =
        LinearizeByModel(problem_, parameters_, rows_.observations, columns_, rows_.noise, treatment);
    const Linearization batched =
        Linearize(problem_, parameters_, rows_.observations, columns_, rows_.noise, treatment);
    ASSERT_TRUE(model.valid && batched.valid);
    EXPECT_LT((model.residual - batched.residual).cwiseAbs().maxCoeff(), 1e-7 * (1.0 + model.residual.norm()));
    EXPECT_EQ(model.latent.cols(), batched.latent.cols());
    for (int c = 0; c < model.num_columns(); ++c) {
      EXPECT_LT((model.jacobian.col(c) - batched.jacobian.col(c)).norm(), 1e-7 * model.jacobian.col(c).norm())
          << parameters_.coordinates()[columns_[c]].name;
    }
  }
}

TEST_P(NormalEquationsOf, SumsAreThoseOfTheModelsRows) {
  const NormalEquations equations(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 1);
  const NormalSums sums = equations.Sum(parameters_, columns_);
  Linearization model = LinearizeByModel(problem_, parameters_, rows_.observations, columns_, rows_.noise);
  AppendPriors(parameters_, &model);
  Eigen::MatrixXd both(model.num_rows(), model.num_columns() + 1);
  both << model.jacobian, model.residual;
  const Eigen::VectorXd size = both.colwise().norm();
  const Eigen::MatrixXd difference =
      size.cwiseInverse().asDiagonal() * (both.transpose() * both - sums.matrix) * size.cwiseInverse().asDiagonal();
  EXPECT_EQ(sums.rows, model.num_rows());
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-7);
}

// The latest sums are kept: those of other values, other columns or without priors are none of theirs.
TEST_P(NormalEquationsOf, SumsAreOfTheValuesThatAreAskedFor) {
  const auto fresh = [this] {
    return NormalEquations(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 1);
  };
  const NormalEquations equations = fresh();
  ParameterSet moved = parameters_;
  Move(columns_, Eigen::VectorXd::Constant(static_cast<long>(columns_.size()), 1e-9), 1.0, &moved);
  const std::vector<int> fewer(columns_.begin() + 1, columns_.end());
  const int rows = 3 * static_cast<int>(rows_.observations.size());
  for (const ParameterSet& at : {parameters_, moved, moved, parameters_}) {
    EXPECT_EQ(equations.Sum(at, columns_).matrix, fresh().Sum(at, columns_).matrix);
    EXPECT_EQ(equations.Sum(at, columns_, {}, /*with_priors=*/false).rows, rows);
    EXPECT_EQ(equations.Sum(at, fewer).columns, fewer);
    EXPECT_EQ(equations.Sum(at, fewer).matrix, fresh().Sum(at, fewer).matrix);
  }
  EXPECT_NE(equations.Sum(parameters_, columns_).matrix, equations.Sum(moved, columns_).matrix);
}

TEST_P(NormalEquationsOf, SumsOfSomeColumnsNeedNoPassWhereThoseOfAllAreKept) {
  const NormalEquations equations(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 1);
  equations.Sum(parameters_, columns_);
  const std::vector<int> fewer(columns_.begin() + 1, columns_.end());
  const NormalSums some = equations.Sum(parameters_, fewer);
  EXPECT_EQ(equations.num_passes(), 1);
  const NormalEquations others(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 1);
  EXPECT_EQ(some.matrix, others.Sum(parameters_, fewer).matrix);
  others.Sum(parameters_, columns_);
  EXPECT_EQ(others.num_passes(), 2);  // not the other way round
}

// After a small step they need no pass.
TEST_P(NormalEquationsOf, MovedSumsAreThoseOfWhereTheyAreMovedTo) {
  const NormalEquations equations(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 1);
  const Eigen::VectorXd step =  // standard deviations
      1e-5 * equations.Sum(parameters_, columns_).matrix.diagonal().head(columns_.size()).cwiseSqrt().cwiseInverse();
  ParameterSet moved = parameters_;
  Move(columns_, step, 1.0, &moved);
  const Eigen::MatrixXd there = equations.Sum(moved, columns_).matrix;
  const Eigen::MatrixXd before = equations.Sum(parameters_, columns_).matrix;
  const int passes = equations.num_passes();
  equations.KeepMoved(parameters_, columns_, step, moved);
  const Eigen::MatrixXd kept = equations.Sum(moved, columns_).matrix;
  EXPECT_EQ(equations.num_passes(), passes);
  const Eigen::VectorXd size = there.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  EXPECT_LT((size.asDiagonal() * (kept - there) * size.asDiagonal()).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_EQ(kept, kept.transpose());
  EXPECT_EQ(equations.Sum(parameters_, columns_).matrix, before);
  EXPECT_EQ(equations.num_passes(), passes);  // where it began is kept as well
}

// |r + J d|^2 = r'r + 2 d'J'r + d'J'J d, however far the step goes.
TEST_P(NormalEquationsOf, MovedSquaresAreThoseOfTheLinearModel) {
  const NormalEquations equations(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 1);
  const Eigen::MatrixXd before = equations.Sum(parameters_, columns_).matrix;
  const auto n = static_cast<long>(columns_.size());
  const Eigen::VectorXd step = before.diagonal().head(n).cwiseSqrt().cwiseInverse();
  ParameterSet moved = parameters_;
  Move(columns_, step, 1.0, &moved);
  equations.KeepMoved(parameters_, columns_, step, moved);
  const double squares =
      before(n, n) + 2.0 * step.dot(before.col(n).head(n)) + step.dot(before.topLeftCorner(n, n) * step);
  EXPECT_NEAR(equations.Sum(moved, columns_).matrix(n, n) / squares, 1.0, 1e-12);
}

// Pieces: the same rows, each once, deviations of joints with their visit.
TEST_P(NormalEquationsOf, PiecesAreTheRows) {
  const std::vector<int> clusters = ConfigurationClusters(problem_.data(), rows_.observations);
  const auto noise = [this](const std::vector<int>& listed) {
    return ObservationNoise(problem_, listed, kFallbackSigma);
  };
  const RowStream stream(problem_, rows_.observations, noise, LatentTreatment::kMarginalise, clusters);
  const Linearization model = LinearizeByModel(problem_, parameters_, rows_.observations, columns_,
                                               noise(rows_.observations), LatentTreatment::kMarginalise);
  std::vector<int> seen(rows_.observations.size(), 0), piece_of(rows_.observations.size(), -1);
  int pieces = 0;
  const double size = 1e-7 * (1.0 + model.residual.norm());
  const auto look_at = [&](const RowPiece& piece) {
    for (int i = 0; i < piece.num_observations(); ++i) {
      const int k = piece.positions[i];
      ++seen[k];
      piece_of[k] = pieces;
      EXPECT_LT((piece.rows.col(columns_.size()).segment<3>(3 * i) - model.residual.segment<3>(3 * k)).norm(), size);
      for (size_t c = 0; c < columns_.size(); ++c) {
        EXPECT_LT((piece.rows.col(c).segment<3>(3 * i) - model.jacobian.col(c).segment<3>(3 * k)).norm(),
                  1e-7 * model.jacobian.col(c).norm());
      }
    }
    ++pieces;
  };
  const NormalEquations equations(problem_, rows_.observations, noise(rows_.observations),
                                  LatentTreatment::kMarginalise, 1);
  ASSERT_TRUE(ForEachPiece(equations.batches(), parameters_, columns_, 1, look_at));
  for (int& times : seen) EXPECT_EQ(std::exchange(times, 0), 1);
  ASSERT_TRUE(stream.ForEach(parameters_, columns_, look_at));
  for (size_t k = 0; k < seen.size(); ++k) {
    EXPECT_EQ(seen[k], 1);
    for (size_t other = 0; other < k; ++other) {
      if (clusters[k] == clusters[other]) {
        EXPECT_EQ(piece_of[k], piece_of[other]);
      }
    }
  }
}

// Both ways to the sandwich, to 1e-6 standard deviations.
TEST_P(NormalEquationsOf, ClustersSideBySideAreThoseOneByOne) {
  const std::vector<int> clusters = ConfigurationClusters(problem_.data(), rows_.observations);
  const auto noise = [this](const std::vector<int>& listed) {
    return ObservationNoise(problem_, listed, kFallbackSigma);
  };
  const Linearization rows = Linearize(problem_, parameters_, rows_.observations, columns_, noise(rows_.observations));
  ClusterFit fit;
  fit.solution = SolveLinearization(rows);
  if (!fit.solution.full_rank) GTEST_SKIP() << "nothing to compare";
  const RobustCovariance alone = SandwichCovariance(rows, clusters);
  ClusterSandwich together(static_cast<int>(columns_.size()), alone.clusters, fit.solution.covariance, {fit});
  const RowStream stream(problem_, rows_.observations, noise, LatentTreatment::kMarginalise, clusters);
  stream.ForEach(parameters_, columns_, [&](const RowPiece& piece) { together.Add(piece, clusters); });
  const RobustCovariance side_by_side = together.Result(0);
  for (size_t c = 0; c < columns_.size(); ++c) {
    EXPECT_NEAR(std::sqrt(side_by_side.covariance(c, c) / alone.covariance(c, c)), 1.0, 1e-6);
    EXPECT_NEAR(side_by_side.dof[c] / alone.dof[c], 1.0, 1e-5);
  }
  const int last = static_cast<int>(columns_.size()) - 1;
  EXPECT_NEAR(together.DegreesOf(0, {last})[0] / side_by_side.dof[last], 1.0, 1e-9);
}

TEST_P(NormalEquationsOf, CondensedRowsHaveTheSameSums) {
  const NormalEquations equations(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 1);
  const NormalSums sums = equations.Sum(parameters_, columns_);
  const Linearization rows = Condense(sums);
  Eigen::MatrixXd both(rows.num_rows(), rows.num_columns() + 1);
  both << rows.jacobian, rows.residual;
  const Eigen::VectorXd size = sums.matrix.diagonal().cwiseSqrt();
  const Eigen::MatrixXd difference =
      size.cwiseInverse().asDiagonal() * (both.transpose() * both - sums.matrix) * size.cwiseInverse().asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(NormalEquationsOf, ThreadsDoNotShow) {
  const NormalEquations one(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 1);
  const NormalEquations three(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 3);
  EXPECT_EQ(one.Sum(parameters_, columns_).matrix, three.Sum(parameters_, columns_).matrix);
}

// So many that there are several blocks of each group: every row is summed once, and who sums it does not show.
TEST(NormalEquationsOfMany, SumsAreThoseOfTheRows) {
  const CalibrationProblem problem = Rigid(4300);
  const ResidualSelection rows = CalibrationResiduals(problem, kFallbackSigma);
  const std::vector<int> columns = problem.parameters.EstimatedCoordinates();
  const Linearization all = Linearize(problem, problem.parameters, rows.observations, columns, rows.noise);
  Eigen::MatrixXd both(all.num_rows(), all.num_columns() + 1);
  both << all.jacobian, all.residual;
  const Eigen::VectorXd size = both.colwise().norm().cwiseMax(1e-300);
  const auto sums_of = [&](int threads) {
    const NormalEquations equations(problem, rows.observations, rows.noise, LatentTreatment::kMarginalise, threads);
    return equations.Sum(problem.parameters, columns, {}, /*with_priors=*/false).matrix;
  };
  const Eigen::MatrixXd one = sums_of(1);
  const Eigen::MatrixXd difference =
      size.cwiseInverse().asDiagonal() * (both.transpose() * both - one) * size.cwiseInverse().asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_EQ(one, sums_of(2));
  EXPECT_EQ(one, sums_of(5));
}

// One pass for each iteration and one for the start: no step is looked at that is not gone, and where it ends the sums
// are at hand.
TEST(NormalEquationsOfMany, ASolveMakesNoPassInVain) {
  const CalibrationProblem problem = Rigid(300);
  const ResidualSelection rows = CalibrationResiduals(problem, kFallbackSigma);
  const NormalEquations equations(problem, rows.observations, rows.noise, LatentTreatment::kMarginalise, 1);
  ParameterSet parameters = problem.parameters;
  FindStartingValues(problem, rows.observations, &parameters);
  const MinimizeSummary solved = MinimizeSums(equations, MinimizeOptions(), &parameters);
  EXPECT_TRUE(solved.converged);
  EXPECT_GE(solved.iterations, 1);
  EXPECT_EQ(equations.num_passes(), 1 + solved.iterations);
  const Linearization left = Condense(equations.Sum(parameters, parameters.EstimatedCoordinates()));
  EXPECT_EQ(equations.num_passes(), 1 + solved.iterations);
  const double cost = left.residual.squaredNorm();
  EXPECT_LE(cost - left.residual.tail(1).squaredNorm(), 1e-9 * cost);
  // Nothing is left after the last step.
  const Eigen::VectorXd step = SolveLinearization(left).step;
  ParameterSet moved = parameters;
  Move(left.columns, step, 1.0, &moved);
  equations.KeepMoved(parameters, left.columns, step, moved);
  const Linearization after = Condense(equations.Sum(moved, left.columns));
  EXPECT_LT(SolveLinearization(after).step.norm(), 1e-6 * step.norm());
  EXPECT_EQ(equations.num_passes(), 1 + solved.iterations);
}

// Cost and gradient of a least-squares problem (tangent columns, those of `later` last) whose later blocks are at the
// optimum of its Gauss-Newton model, by the Schur complement
//   c = |r|^2 / 2 - g_l' H_ll^-1 g_l / 2,   g = g_p - H_pl H_ll^-1 g_l
struct Reduced {
  double cost = 0.0;
  Eigen::VectorXd gradient;
};

Reduced Reduce(ceres::Problem* problem, const std::vector<double*>& first, const std::vector<double*>& later) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = first;
  options.parameter_blocks.insert(options.parameter_blocks.end(), later.begin(), later.end());
  double cost = 0.0;
  std::vector<double> residuals, gradient;
  ceres::CRSMatrix sparse;
  if (!problem->Evaluate(options, &cost, &residuals, &gradient, &sparse)) return {};
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int i = 0; i < sparse.num_rows; ++i) {
    for (int k = sparse.rows[i]; k < sparse.rows[i + 1]; ++k) jacobian(i, sparse.cols[k]) = sparse.values[k];
  }
  int num_later = 0;
  for (double* block : later) num_later += problem->ParameterBlockTangentSize(block);
  const int num_first = sparse.num_cols - num_later;
  const Eigen::VectorXd g = Eigen::Map<const Eigen::VectorXd>(gradient.data(), sparse.num_cols);
  if (num_later == 0) return {cost, g};
  const Eigen::MatrixXd of_later = jacobian.rightCols(num_later);
  const Eigen::VectorXd step = (of_later.transpose() * of_later).llt().solve(g.tail(num_later));
  return {cost - 0.5 * g.tail(num_later).dot(step),
          g.head(num_first) - jacobian.leftCols(num_first).transpose() * (of_later * step)};
}

// What Ceres is given: the cost of all rows, and its gradient; joint deviations, blocks of their own in the cost per
// marker, are at their optimum.
TEST_P(NormalEquationsOf, CondensedCostIsTheCostPerMarker) {
  const NormalEquations equations(problem_, rows_.observations, rows_.noise, LatentTreatment::kMarginalise, 1);
  ParameterSet a = parameters_, b = parameters_;
  ceres::Problem condensed, by_marker;
  AddCondensed(equations, &a, &condensed);
  rows_.granularity = CostGranularity::kMarker;
  LatentBlocks latents;
  AddToProblem(problem_, rows_, &b, &by_marker, problem_.latent.empty() ? nullptr : &latents);
  std::vector<double*> blocks_a, blocks_b, deviations;
  for (size_t i = 0; i < a.blocks().size(); ++i) {
    double* const values = const_cast<double*>(a.blocks()[i].values.data());
    if (!condensed.HasParameterBlock(values)) continue;
    blocks_a.push_back(values);
    blocks_b.push_back(const_cast<double*>(b.blocks()[i].values.data()));
  }
  for (std::vector<double>& block : latents) {
    if (by_marker.HasParameterBlock(block.data())) deviations.push_back(block.data());
  }
  EXPECT_EQ(deviations.empty(), problem_.latent.empty());
  const Reduced of_a = Reduce(&condensed, blocks_a, {}), of_b = Reduce(&by_marker, blocks_b, deviations);
  ASSERT_GT(of_b.cost, 0.0);
  // Of deviations the cost itself holds derivatives, which are known to 1e-8 (BatchedRowsAreTheModels), ten of them.
  const double tolerance = deviations.empty() ? 1e-9 : 1e-7;
  EXPECT_NEAR(of_a.cost, of_b.cost, tolerance * of_b.cost);
  ASSERT_EQ(of_a.gradient.size(), of_b.gradient.size());
  const Linearization scale = LinearizeByModel(problem_, a, rows_.observations, columns_, rows_.noise);
  for (int c = 0; c < of_a.gradient.size(); ++c) {
    const double size = scale.jacobian.col(c).norm() * std::sqrt(2.0 * of_b.cost);
    EXPECT_NEAR(of_a.gradient[c], of_b.gradient[c], 1e-7 * size) << parameters_.coordinates()[columns_[c]].name;
  }
}

// The whole way: the estimate by sums is the one by markers, to 1e-6 standard deviations.
TEST_P(NormalEquationsOf, EstimatesAreThoseByMarker) {
  JointOptions by_marker, judged;
  by_marker.granularity = CostGranularity::kMarker;
  const Estimate a = EstimateJointly(problem_, judged), b = EstimateJointly(problem_, by_marker);
  ASSERT_TRUE(IsUsable(a.status)) << a.message;
  ASSERT_EQ(a.estimated, b.estimated);
  for (size_t c = 0; c < a.estimated.size(); ++c) {
    const ParameterEstimate& row = a.table[a.estimated[c]];
    EXPECT_NEAR(row.value, b.table[a.estimated[c]].value, 1e-6 * row.sigma) << row.name;
    EXPECT_NEAR(row.sigma, b.table[a.estimated[c]].sigma, 1e-6 * row.sigma) << row.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Problems, NormalEquationsOf, testing::ValuesIn(kProblems),
                         [](const auto& own) { return std::string(own.param.name); });

// From nominal a loaded arm needs few steps, however few the configurations.
TEST(JointEstimate, TakesAtMostFiveIterationsFromNominal) {
  for (const int configurations : {18, 100}) {
    test::LoadedTruth truth = test::Everything();
    test::LoadedDesign design;
    design.configurations = configurations;
    truth.spring.reset();
    Measurements data = test::LoadedRows(design, truth);
    test::Measure(test::ExactPoints(truth, data), design.sigma, 5, &data);
    const test::LoadedSetup setup = test::SetupFor(truth);
    const Estimate estimate = EstimateJointly(MakeCalibrationProblem(setup.robot, data, setup.experiment));
    ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
    EXPECT_LE(estimate.iterations, 5);
  }
}

// A joint that does not yield: half of the estimates without bounds are negative. The bound costs no more steps.
TEST(JointEstimate, TakesAtMostFiveIterationsOntoABound) {
  int on_bound = 0;
  for (const int seed : {5, 6, 7, 8}) {
    test::LoadedTruth truth = test::Everything();
    test::LoadedDesign design;
    design.configurations = 100;
    truth.spring.reset();
    truth.k[5] = 0.0;
    Measurements data = test::LoadedRows(design, truth);
    test::Measure(test::ExactPoints(truth, data), design.sigma, seed, &data);
    const test::LoadedSetup setup = test::SetupFor(truth);
    const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
    const Estimate estimate = EstimateJointly(problem);
    ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
    EXPECT_LE(estimate.iterations, 5);
    const int k6 = problem.parameters.FindCoordinate("compliance/A6");
    ASSERT_GE(k6, 0);
    on_bound += estimate.parameters.Value(k6) == 0.0;
    JointOptions by_marker;
    by_marker.granularity = CostGranularity::kMarker;
    EXPECT_NEAR(estimate.cost, EstimateJointly(problem, by_marker).cost, 1e-9 * estimate.cost);
  }
  EXPECT_GT(on_bound, 0);
}

}  // namespace
}  // namespace sagitta::normal_equations_test
