// Markers on the two ends of the compensator's spring, inside the joint solve.
#include "problems/spring_tie.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "estimator/baselines/compare_methods.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/ceres_problem.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/spring_tie_cost.h"
#include "estimator/statistics/distributions.h"
#include "problems/input_error.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::spring_tie_test {
namespace {

const std::vector<std::string> kGeometry = {"compensator/L", "compensator/a_x", "compensator/a_y"};

// Lever end and anchor on the arm of the joint solve, errors of joint 1 in.
test::LoadedTruth TruthWithSpringMarkers() {
  test::LoadedTruth truth;
  truth.base_rotvec = {{0.0528, 0.01, 0.3}, {-0.04, 0.02, -1.0}};
  truth.spring = test::SpringTruth();
  const test::SpringTruth& s = *truth.spring;
  const double beta = 0.4;
  const Vector3<double> u(std::cos(beta), 0, -std::sin(beta)), v = Vector3<double>::UnitY().cross(u);
  const Vector3<double> in_axis_frame = -s.a_y * u - s.a_x * v + Vector3<double>(0, 0.3, 0);
  const Vector3<double> in_link_1 = Vector3<double>(0.350 + truth.errors[0], truth.errors[1], 0) +
                                    test::Turn(Eigen::Vector3d::UnitX(), truth.errors[2]) * in_axis_frame;
  truth.link_markers = {{"L1", {1, s.L * u + Vector3<double>(0, 0.25, 0)}}, {"L2", {0, in_link_1}}};
  return truth;
}

// Everything of the spring free, ends at stated sigmas (m).
test::LoadedSetup SetupWithTie(const test::LoadedTruth& truth, double lever_sigma, double anchor_sigma) {
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.experiment.estimate.gravity_compensator = {Selection::Kind::kAll, {}};
  setup.robot.gravity_compensator->L *= 1.01;
  setup.experiment.markers["L1"].spring_sigma = lever_sigma;
  setup.experiment.markers["L2"].spring_sigma = anchor_sigma;
  return setup;
}

Measurements ExactData(const test::LoadedTruth& truth) {
  Measurements data = test::LoadedRows(test::LoadedDesign(), truth);
  test::Measure(test::ExactPoints(truth, data), 0.0, 1, &data);
  return data;
}

Eigen::Vector3d GeometryError(const Estimate& estimate, const test::LoadedTruth& truth) {
  Eigen::Vector3d error;
  for (int i = 0; i < 3; ++i)
    error[i] = test::ErrorOf(estimate, truth, estimate.parameters.FindCoordinate(kGeometry[i]));
  return error;
}

Eigen::Matrix3d GeometryCovariance(const Estimate& estimate) {
  std::vector<int> columns;
  for (const std::string& name : kGeometry) {
    const int coordinate = estimate.parameters.FindCoordinate(name);
    const auto found = std::find(estimate.estimated.begin(), estimate.estimated.end(), coordinate);
    columns.push_back(static_cast<int>(found - estimate.estimated.begin()));
  }
  return estimate.covariance(columns, columns);
}

TEST(SpringTie, ExactEndsGiveTheExactSpringAndOpenTheGauge) {
  const test::LoadedTruth truth = TruthWithSpringMarkers();
  const test::LoadedSetup setup = SetupWithTie(truth, 1e-5, 1e-5);
  const Estimate estimate = EstimateJointly(MakeCalibrationProblem(setup.robot, ExactData(truth), setup.experiment));
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  EXPECT_LT(GeometryError(estimate, truth).cwiseAbs().maxCoeff(), 1e-9);
  for (const std::string& name : kGeometry)
    EXPECT_TRUE(estimate.table[estimate.parameters.FindCoordinate(name)].identifiable) << name;
  EXPECT_NEAR(test::ErrorOf(estimate, truth, estimate.parameters.FindCoordinate("compensator/s0")), 0.0, 1e-7);
}

// Ends off by isotropic sigmas move (L, a_x, a_y) by their slopes: J J' of both, by differences, also where the robot
// file has another spring. A lever's millimetre turns the axes in which the anchor is counted: of a_x and a_y one
// common term.
TEST(SpringTie, TheEndsCovarianceIsThatOfTheirMarkers) {
  const test::LoadedTruth truth = TruthWithSpringMarkers();
  const double cases[][3] = {{1e-3, 1e-5, 1.0}, {1e-5, 1e-3, 1.0}, {3e-4, 2e-4, 1.0}, {1e-3, 1e-5, 1.25}};
  for (const auto& [lever, anchor, file] : cases) {
    test::LoadedSetup setup = SetupWithTie(truth, lever, anchor);
    setup.robot.gravity_compensator->L = file * truth.spring->L;
    setup.robot.gravity_compensator->a_x = truth.spring->a_x;
    setup.robot.gravity_compensator->a_y = truth.spring->a_y;
    setup.experiment.markers["L1"].spring = SpringEnd::kLever;
    setup.experiment.markers["L2"].spring = SpringEnd::kAnchor;
    const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, ExactData(truth), setup.experiment);
    ParameterSet parameters = EstimateJointly(problem).parameters;
    ASSERT_TRUE(parameters.spring_tie());
    const SpringTie& tie = *parameters.spring_tie();
    Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
    for (const int marker : {tie.lever_marker, tie.anchor_marker}) {
      const double sigma = marker == tie.lever_marker ? lever : anchor;
      for (int axis = 0; axis < 3; ++axis) {
        Eigen::Vector3d side[2];
        for (const int s : {0, 1}) {
          ParameterSet moved = parameters;
          moved.SetMarkerPoint(marker,
                               parameters.MarkerPoint(marker) + (s == 0 ? 1e-6 : -1e-6) * Vector3<double>::Unit(axis));
          side[s] = SpringTieMisfit(moved);
        }
        const Eigen::Vector3d slope = (side[0] - side[1]) / 2e-6 * sigma;
        expected += slope * slope.transpose();
      }
    }
    // The robot's errors between anchor and joint turn it by less than a milliradian.
    EXPECT_LT((tie.covariance - expected).norm(), 5e-3 * expected.norm()) << tie.covariance << "\n\n" << expected;
    EXPECT_NEAR(tie.covariance(1, 2), expected(1, 2), 0.02 * std::abs(expected(1, 2)) + 1e-16);
  }
}

TEST(SpringTie, IsInTheProblemOnce) {
  const test::LoadedTruth truth = TruthWithSpringMarkers();
  const test::LoadedSetup setup = SetupWithTie(truth, 1e-5, 1e-5);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, ExactData(truth), setup.experiment);
  ParameterSet parameters = problem.parameters;
  ASSERT_TRUE(parameters.spring_tie());
  const ResidualSelection whole = CalibrationResiduals(problem);
  ResidualSelection parts[2];
  for (size_t k = 0; k < whole.observations.size(); ++k) {
    ResidualSelection& part = parts[2 * k < whole.observations.size() ? 0 : 1];
    part.observations.push_back(whole.observations[k]);
    part.noise.push_back(whole.noise[k]);
  }
  ceres::Problem once, twice;
  AddToProblem(problem, whole, &parameters, &once);
  for (const ResidualSelection& part : parts) AddToProblem(problem, part, &parameters, &twice);
  EXPECT_EQ(twice.NumResiduals(), once.NumResiduals());
  EXPECT_EQ(once.NumResiduals(), static_cast<int>(3 * whole.observations.size()) + 3);  // L, a_x, a_y
}

TEST(SpringTie, WithoutItTheGaugeIsHeld) {
  const test::LoadedTruth truth = TruthWithSpringMarkers();
  test::LoadedSetup setup = SetupWithTie(truth, 1e-5, 1e-5);
  setup.experiment.markers["L1"].spring = SpringEnd::kNone;
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, ExactData(truth), setup.experiment);
  EXPECT_FALSE(problem.parameters.spring_tie());
  const Estimate estimate = EstimateJointly(problem);
  EXPECT_EQ(estimate.status, Status::kConvergedWithHeldParameters);
  EXPECT_FALSE(estimate.table[estimate.parameters.FindCoordinate("compensator/L")].identifiable);
}

TEST(SpringTie, RowsAgreeWithFiniteDifferences) {
  const test::LoadedTruth truth = TruthWithSpringMarkers();
  const test::LoadedSetup setup = SetupWithTie(truth, 2e-5, 1e-4);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, ExactData(truth), setup.experiment);
  const ResidualSelection residuals = CalibrationResiduals(problem);
  ParameterSet parameters = problem.parameters;
  parameters.SetMarkerPoint(3, {0.17, 0.25, -0.06});
  parameters.SetMarkerPoint(4, {0.2, 0.3, -0.6});
  const std::vector<int> columns = parameters.EstimatedCoordinates();
  const auto rows_at = [&](const ParameterSet& at) {
    Linearization empty;
    empty.columns = columns;
    empty.jacobian.resize(0, columns.size());
    AppendPriors(at, &empty);
    return empty;
  };
  const Linearization here = rows_at(parameters);
  ASSERT_EQ(here.num_rows(), 3);
  int moving = 0;
  for (size_t c = 0; c < columns.size(); ++c) {
    constexpr double kStep = 1e-6;
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters.num_coordinates());
    delta[columns[c]] = kStep;
    ParameterSet up = parameters, down = parameters;
    up.Plus(delta);
    down.Plus(-delta);
    const Eigen::Vector3d numeric = (rows_at(up).residual - rows_at(down).residual) / (2 * kStep);
    moving += numeric.norm() > 1.0;
    EXPECT_LT((here.jacobian.col(c) - numeric).norm(), 1e-5 * (1.0 + numeric.norm()))
        << parameters.coordinates()[columns[c]].name;
  }
  EXPECT_EQ(moving, 4 + 2 + 3);  // points in the plane, p_x1 and phi_x1 (p_y1 is along the axis), L a_x a_y
}

TEST(SpringTie, GeometryScattersAsItsCovarianceSays) {
  test::LoadedTruth truth = TruthWithSpringMarkers();
  constexpr double kLever = 5e-5, kAnchor = 2e-4;  // m
  constexpr int kTrials = 40;
  const test::LoadedSetup setup = SetupWithTie(truth, kLever, kAnchor);
  const test::LoadedDesign design;
  Measurements data = test::LoadedRows(design, truth);
  NormalNumbers normal(11);
  double sum = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    test::LoadedTruth off = truth;  // the reflectors are off the ends
    for (int i = 0; i < 3; ++i) {
      off.link_markers["L1"].second[i] += kLever * normal();
      off.link_markers["L2"].second[i] += kAnchor * normal();
    }
    test::Measure(test::ExactPoints(off, data), design.sigma, 100 + trial, &data);
    const Estimate estimate = EstimateJointly(MakeCalibrationProblem(setup.robot, data, setup.experiment));
    ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
    const Eigen::Vector3d error = GeometryError(estimate, truth);
    sum += error.dot(GeometryCovariance(estimate).llt().solve(error));
  }
  EXPECT_GT(ChiSquareSurvival(sum, 3 * kTrials), 1e-4);
  EXPECT_LT(ChiSquareSurvival(sum, 3 * kTrials), 1 - 1e-4);
}

TEST(SpringTie, TwoStepsReachTheJointOptimum) {
  const test::LoadedTruth truth = TruthWithSpringMarkers();
  const test::LoadedSetup setup = SetupWithTie(truth, 2e-5, 1e-4);
  Measurements data = ExactData(truth);
  test::Measure(test::ExactPoints(truth, data), 3e-5, 3, &data);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  const Estimate joint = EstimateJointly(problem);
  const MethodResult two_step = RunMethod(problem, Method::kTwoStep, joint);
  ASSERT_TRUE(IsUsable(two_step.estimate.status)) << two_step.estimate.message;
  EXPECT_LT(two_step.max_deviation_sigma, 1e-4);
}

// What must be refused, and what is said.
struct BadTie {
  const char* name;
  std::function<void(test::LoadedSetup*)> change;
  const char* says;
};

TEST(SpringTie, EndsWhereTheyCannotBeAreRefused) {
  const test::LoadedTruth truth = TruthWithSpringMarkers();
  const std::vector<BadTie> cases = {
      {"swapped",
       [](test::LoadedSetup* s) {
         s->experiment.markers["L1"].spring = SpringEnd::kAnchor;
         s->experiment.markers["L2"].spring = SpringEnd::kLever;
       },
       "the lever end turns with"},
      {"two levers",
       [](test::LoadedSetup* s) {
         s->experiment.markers["L1"].spring = SpringEnd::kLever;
         s->experiment.markers["L2"].spring = SpringEnd::kLever;
       },
       "one lever only"},
      {"anchor before another joint",
       [](test::LoadedSetup* s) {
         s->experiment.markers["L2"].on = MarkerPlace::Named("base");
         s->experiment.markers["L2"].spring = SpringEnd::kAnchor;
       },
       "a joint moves between"},
      {"no spring",
       [](test::LoadedSetup* s) {
         s->experiment.markers["L2"].spring = SpringEnd::kAnchor;
         s->robot.gravity_compensator.reset();
         s->experiment.estimate.gravity_compensator = {};
       },
       "no gravity_compensator"},
  };
  for (const BadTie& bad : cases) {
    test::LoadedSetup setup = SetupWithTie(truth, 1e-5, 1e-5);
    bad.change(&setup);
    try {
      MakeCalibrationProblem(setup.robot, ExactData(truth), setup.experiment);
      FAIL() << bad.name << " was accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(bad.says), std::string::npos) << error.what();
    }
  }
}

TEST(SpringTie, WhatNobodyStatedIsSaid) {
  const test::LoadedTruth truth = TruthWithSpringMarkers();
  test::LoadedSetup setup = SetupWithTie(truth, 1e-5, 1e-5);
  setup.experiment.markers["L2"].spring_sigma.reset();
  Estimate estimate = EstimateJointly(MakeCalibrationProblem(setup.robot, ExactData(truth), setup.experiment));
  ASSERT_FALSE(estimate.warnings.empty());
  EXPECT_NE(estimate.warnings[0].find("'L1' and 'L2' are assumed to be"), std::string::npos) << estimate.warnings[0];

  test::LoadedTruth other = truth;  // markers elsewhere on the same links
  other.link_markers = {{"L1", {1, {0.1, 0.2, 0.15}}}, {"L2", {0, {0.3, 0.2, 0.1}}}};
  estimate = EstimateJointly(MakeCalibrationProblem(setup.robot, ExactData(other), setup.experiment));
  EXPECT_EQ(estimate.status, Status::kConvergedWithHeldParameters) << estimate.message;
  EXPECT_FALSE(estimate.table[estimate.parameters.FindCoordinate("compensator/L")].identifiable);
  ASSERT_FALSE(estimate.warnings.empty());
  EXPECT_NE(estimate.warnings[0].find("not used for it"), std::string::npos) << estimate.warnings[0];
}

}  // namespace
}  // namespace sagitta::spring_tie_test
