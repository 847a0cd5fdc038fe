// What an unnamed deviation moves, against differences of the model's own predictions, and its functions against the
// kernels that they stand for.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "estimator/diagnosis/driver_functions.h"
#include "estimator/diagnosis/evidence_columns.h"
#include "models/effects/learnt_deviation.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta {
namespace {

constexpr double kSigma = 2e-5;  // m

CalibrationProblem Problem() {
  test::Kr270Design design;
  design.configurations = 12;
  design.stations = 1;
  design.sigma = kSigma;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), kSigma, 300, &data);
  Robot robot;
  robot.chain = test::Kr270Chain();
  return MakeCalibrationProblem(robot, data, Experiment());
}

// Parameters near the truth, where lever arms are those of a robot.
ParameterSet Placed(const CalibrationProblem& problem) {
  ParameterSet parameters = problem.parameters;
  parameters.SetBaseInStation(0, {RotationFromVector(Vector3<double>(0.1, -0.2, 0.7)), {3.0, -1.0, 0.5}});
  for (int m = 0; m < parameters.num_markers(); ++m) parameters.SetMarkerPoint(m, {0.1 * m, 0.05 - 0.1 * m, 0.2});
  return parameters;
}

// Of a source times one, m per unit: rows of all observations.
Eigen::VectorXd Moves(const CalibrationProblem& problem, const ParameterSet& parameters, const Source& source) {
  EvidenceColumns columns(problem, parameters, {});
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(static_cast<long>(problem.data().shots.size()));
  const std::vector<int> column = columns.Add({source, ones});
  const std::vector<int> all = problem.CalibrationObservations();
  return kSigma * columns.RowsAt(all, StatedScatter(problem), column).rightCols(1);
}

Eigen::VectorXd Predicted(const CalibrationProblem& problem, const ParameterSet& parameters) {
  return PredictPoints(problem, parameters, problem.CalibrationObservations()).reshaped();
}

TEST(UnnamedSources, APlateTurnsAllMarkersAboutTheFlange) {
  const CalibrationProblem problem = Problem();
  const ParameterSet parameters = Placed(problem);
  ParameterSet turned = parameters;
  for (int m = 0; m < parameters.num_markers(); ++m) {
    const Eigen::AngleAxisd turn(kTypicalPlateTurn, Eigen::Vector3d::UnitY());
    turned.SetMarkerPoint(m, turn * parameters.MarkerPoint(m));
  }
  const Eigen::VectorXd difference = Predicted(problem, turned) - Predicted(problem, parameters);
  EXPECT_GT(difference.norm(), 1e-4);
  const Source source{Source::Kind::kPlate, 0, 4};
  EXPECT_LT((Moves(problem, parameters, source) - difference).norm(), 1e-3 * difference.norm());
}

TEST(UnnamedSources, ALinkGrowsByItsLengths) {
  const CalibrationProblem problem = Problem();
  const ParameterSet parameters = Placed(problem);
  Robot grown = problem.robot();
  int before = -1, lengths = 0;
  for (ElementaryTransform& transform : grown.chain.transforms) {
    if (transform.has_joint()) before = transform.joint;
    if (before != 1 || transform.is_rotation() || transform.nominal == 0.0) continue;
    transform.nominal *= 1.0 + kTypicalGrowth;
    ++lengths;
  }
  ASSERT_GT(lengths, 0);
  const CalibrationProblem longer = MakeCalibrationProblem(grown, problem.data(), Experiment());
  const Eigen::VectorXd difference = Predicted(longer, parameters) - Predicted(problem, parameters);
  EXPECT_GT(difference.norm(), 1e-4);
  const Source source{Source::Kind::kLink, 1, 0};
  EXPECT_LT((Moves(problem, parameters, source) - difference).norm(), 1e-3 * difference.norm());
}

TEST(UnnamedSources, TheBaseTurnsInItsStation) {
  const CalibrationProblem problem = Problem();
  const ParameterSet parameters = Placed(problem);
  ParameterSet turned = parameters;
  Pose<double> pose = parameters.BaseInStation(0);
  pose.rotation = RotationFromVector(Vector3<double>(kTypicalStationTurn, 0.0, 0.0)) * pose.rotation;
  turned.SetBaseInStation(0, pose);
  const Eigen::VectorXd difference = Predicted(problem, turned) - Predicted(problem, parameters);
  const Source source{Source::Kind::kStationTurn, 0, 0};
  EXPECT_LT((Moves(problem, parameters, source) - difference).norm(), 1e-3 * difference.norm());
}

// Random functions of a direction: covariance (c + c^2 + c^3) / 3 between two of cosine c.
TEST(DriverFunctions, OfADirectionDependOnTheAngleAlone) {
  Eigen::MatrixXd directions(2, 3);
  directions << 0.6, 0.0, 0.8, 0.0, -0.6, 0.8;
  const double c = 0.64;
  const Eigen::MatrixXd functions = OfDirection(directions, 3);
  EXPECT_EQ(functions.cols(), 3 + 6 + 10);
  EXPECT_NEAR(functions.row(0).dot(functions.row(1)), (c + c * c + c * c * c) / 3.0, 1e-12);
  EXPECT_NEAR(functions.row(0).squaredNorm(), 1.0, 1e-12);
}

TEST(DriverFunctions, StretchesShareTheVisitsEvenly) {
  const Eigen::VectorXd visits = Eigen::VectorXd::LinSpaced(60, 1.0, 60.0);
  const Eigen::MatrixXd stretches = Stretches(visits, 25);
  EXPECT_EQ(stretches.cols(), 25);
  EXPECT_TRUE((stretches.rowwise().sum().array() == 1.0).all());
  EXPECT_GE(stretches.colwise().sum().minCoeff(), 2.0);
  EXPECT_LE(stretches.colwise().sum().maxCoeff(), 3.0);
  EXPECT_EQ(Stretches(visits.head(10), 25).cols(), 10);
}

// A row of bumps with weights of unit variance has unit variance between the knots.
TEST(DriverFunctions, BumpsHaveUnitVariance) {
  const Eigen::VectorXd inside = Eigen::VectorXd::LinSpaced(50, 30.0, 70.0);
  EXPECT_LT((Bumps(inside, 0.0, 100.0, 10).rowwise().squaredNorm().array() - 1.0).abs().maxCoeff(), 2e-3);
}

}  // namespace
}  // namespace sagitta
