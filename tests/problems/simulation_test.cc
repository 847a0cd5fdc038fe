#include "problems/simulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "problems/io/measurement_file.h"
#include "problems/io/measurement_writer.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/kr270.h"

namespace sagitta::simulation_test {
namespace {

constexpr double kFarOut = 4.8;  // standard deviations: exceeded once in 600 000 draws

// Two stations, two markers; every row a configuration of its own.
Measurements Rows(int n) {
  Measurements rows;
  rows.stations = {"S1", "S2"};
  rows.markers = {"P1", "P2"};
  test::RandomNumbers random(12);
  for (int i = 0; i < n; ++i) {
    Eigen::VectorXd q(6);
    for (int j = 0; j < 6; ++j) q[j] = random.Uniform(-2.0, 2.0);
    rows.configurations.push_back({"C" + std::to_string(i), q, false});
    Shot shot;
    shot.configuration = i;
    shot.station = i % 2;
    shot.observations = {i};
    rows.shots.push_back(shot);
    Observation observation;
    observation.shot = i;
    observation.marker = (i / 2) % 2;
    rows.observations.push_back(observation);
  }
  return rows;
}

SimulationTruth Truth() {
  SimulationTruth truth;
  truth.robot.chain = test::Kr270Chain();
  const int flange = truth.robot.chain.FlangeFrame();
  truth.markers = {{flange, {0.28, -0.05, -0.09}}, {flange, {0.27, 0.10, 0.02}}};
  truth.base_in_station.resize(2);
  truth.base_in_station[0].translation = {1.0, -2.0, 0.5};
  truth.base_in_station[1].translation = {-3.0, 0.2, 0.1};
  truth.base_in_station[1].rotation = RotationFromVector<double>(Vector3<double>(0.1, -0.2, 2.5));
  return truth;
}

std::vector<Vector3<double>> Everywhere(const Measurements& rows, const Vector3<double>& sigma) {
  return std::vector<Vector3<double>>(rows.observations.size(), sigma);
}

// The sigma of every observation, m: what its row states, else `otherwise`.
std::vector<Vector3<double>> SigmaOfRows(const Measurements& rows, const Vector3<double>& otherwise) {
  std::vector<Vector3<double>> sigma;
  sigma.reserve(rows.observations.size());
  for (const Observation& observation : rows.observations) {
    sigma.push_back((observation.sigma.array() > 0.0).select(observation.sigma, otherwise));
  }
  return sigma;
}

TEST(NormalNumbers, HaveTheMomentsOfTheNormalDistribution) {
  constexpr int n = 200000;
  NormalNumbers normal(7);
  double sum = 0, square = 0, cube = 0, fourth = 0, neighbours = 0, before = 0;
  int within_one = 0;
  for (int i = 0; i < n; ++i) {
    const double x = normal();
    sum += x;
    square += x * x;
    cube += x * x * x;
    fourth += x * x * x * x;
    neighbours += x * before;
    within_one += std::abs(x) < 1.0;
    before = x;
  }
  // Standard deviations of these means: 1, sqrt 2, sqrt 15, sqrt 96, 1, over sqrt n.
  const double root = std::sqrt(n);
  EXPECT_NEAR(sum / n, 0.0, kFarOut * 1.0 / root);
  EXPECT_NEAR(square / n, 1.0, kFarOut * std::sqrt(2.0) / root);
  EXPECT_NEAR(cube / n, 0.0, kFarOut * std::sqrt(15.0) / root);
  EXPECT_NEAR(fourth / n, 3.0, kFarOut * std::sqrt(96.0) / root);
  EXPECT_NEAR(neighbours / n, 0.0, kFarOut * 1.0 / root);
  EXPECT_NEAR(within_one / double{n}, 0.6826894921, kFarOut * std::sqrt(0.6827 * 0.3173) / root);
}

// Frozen: a seed in a report has to mean the same noise tomorrow and elsewhere.
// Computed by an independent MT19937-64 and Box-Muller (Python).
TEST(NormalNumbers, AreTheSameEverywhere) {
  NormalNumbers normal(1);
  for (const double expected : {0.35099249780849084, -0.40529019332161614, 1.0859449105047105, -0.1442926593060653,
                                0.78918877611049598, 0.49143895425895007})
    EXPECT_NEAR(normal(), expected, 1e-14);
}

TEST(Simulation, WithoutNoiseGivesThePredictedPoints) {
  const Measurements rows = Rows(12);
  const SimulationTruth truth = Truth();
  const Measurements simulated = SimulateMeasurements(rows, truth, Everywhere(rows, Vector3<double>::Zero()), 1);
  const ForwardModel model(truth.robot.chain);
  const std::vector<double> theta(model.num_parameters(), 0.0);
  for (int i = 0; i < 12; ++i) {
    std::vector<PointPrediction> predictions;
    model.Predict(rows.configurations[i].q, theta.data(), {}, truth.base_in_station[i % 2],
                  {truth.markers[(i / 2) % 2]}, &predictions);
    EXPECT_LT((simulated.observations[i].point_in_station - predictions[0].point).norm(), 1e-14);
  }
}

TEST(Simulation, GeometricErrorsOfTheTruthMoveThePoints) {
  const Measurements rows = Rows(4);
  SimulationTruth truth = Truth();
  const auto exact = Everywhere(rows, Vector3<double>::Zero());
  const Measurements nominal = SimulateMeasurements(rows, truth, exact, 1);
  truth.robot = WithGeometricErrors(truth.robot, {{"p_x2", 1e-3}});
  const Measurements moved = SimulateMeasurements(rows, truth, exact, 1);
  for (int i = 0; i < 4; ++i) {
    const Vector3<double> change = moved.observations[i].point_in_station - nominal.observations[i].point_in_station;
    EXPECT_NEAR(change.norm(), 1e-3, 1e-12);
  }
}

// Per axis: sum (residual / sigma)^2 is chi-square with n degrees of freedom,
// mean n, variance 2 n; the sum of the residuals has variance n sigma^2.
TEST(Simulation, NoiseHasTheStatedSigmaOnEveryAxis) {
  constexpr int n = 20000;
  const Measurements rows = Rows(n);
  const Vector3<double> sigma(1e-5, 1e-4, 1e-3);
  const Measurements exact = SimulateMeasurements(rows, Truth(), Everywhere(rows, Vector3<double>::Zero()), 3);
  const Measurements noisy = SimulateMeasurements(rows, Truth(), Everywhere(rows, sigma), 3);
  Eigen::Array3d sum = Eigen::Array3d::Zero(), chi2 = Eigen::Array3d::Zero(), cross = Eigen::Array3d::Zero();
  for (int i = 0; i < n; ++i) {
    const Eigen::Array3d e =
        (noisy.observations[i].point_in_station - exact.observations[i].point_in_station).array() / sigma.array();
    sum += e;
    chi2 += e * e;
    cross += e * Eigen::Array3d(e[1], e[2], e[0]);
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(chi2[axis], n, kFarOut * std::sqrt(2.0 * n)) << axis;
    EXPECT_NEAR(sum[axis], 0.0, kFarOut * std::sqrt(double{n})) << axis;
    EXPECT_NEAR(cross[axis], 0.0, kFarOut * std::sqrt(double{n})) << axis;
  }
}

TEST(Simulation, ASeedRepeatsAndAnotherDoesNot) {
  const Measurements rows = Rows(30);
  const auto sigma = Everywhere(rows, Vector3<double>::Constant(1e-4));
  const Measurements first = SimulateMeasurements(rows, Truth(), sigma, 5);
  const Measurements again = SimulateMeasurements(rows, Truth(), sigma, 5);
  const Measurements other = SimulateMeasurements(rows, Truth(), sigma, 6);
  for (size_t i = 0; i < rows.observations.size(); ++i) {
    EXPECT_EQ(first.observations[i].point_in_station, again.observations[i].point_in_station);
    EXPECT_NE(first.observations[i].point_in_station, other.observations[i].point_in_station);
  }
}

TEST(Simulation, KeepsEverythingButThePoints) {
  Measurements rows = Rows(3);
  rows.observations[1].sigma = {1e-5, 2e-5, 3e-5};
  rows.configurations[2].is_validation = true;
  const Measurements simulated = SimulateMeasurements(rows, Truth(), SigmaOfRows(rows, {1e-4, 1e-4, 1e-4}), 5);
  EXPECT_EQ(simulated.observations[1].sigma, rows.observations[1].sigma);
  EXPECT_EQ(simulated.observations[0].sigma, Vector3<double>::Zero());
  EXPECT_TRUE(simulated.configurations[2].is_validation);
  EXPECT_EQ(simulated.shots.size(), 3u);
  EXPECT_EQ(simulated.observations[2].marker, rows.observations[2].marker);
}

class MeasurementWriter : public FileTest {};

Measurements FromCells(std::vector<MeasurementFile> files) {
  Measurements data;
  data.files = std::move(files);
  for (size_t f = 0; f < data.files.size(); ++f) {
    for (size_t r = 0; r < data.files[f].rows.size(); ++r) {
      Observation observation;
      observation.file = static_cast<int>(f);
      observation.row = static_cast<int>(r);
      observation.point_in_station = {0.0011, 0.0022 + f, 1.0 / 3.0};
      data.observations.push_back(observation);
    }
  }
  return data;
}

TEST_F(MeasurementWriter, AppendsPointsAndKeepsOtherCellsAsTheyAre) {
  MeasurementFile file;
  file.header = {"config", "q1_deg", "remark"};
  file.rows = {{2, {"C1", "1.50", "a, b"}}, {3, {"C2", "-0", "say \"no\""}}};
  EXPECT_EQ(MeasurementsToCsv(FromCells({file})),
            "config,q1_deg,remark,x_mm,y_mm,z_mm\n"
            "C1,1.50,\"a, b\",1.1,2.2,333.3333333333333\n"
            "C2,-0,\"say \"\"no\"\"\",1.1,2.2,333.3333333333333\n");
}

TEST_F(MeasurementWriter, ReplacesPointsWhereTheyStandAndWritesThemInMm) {
  MeasurementFile file;
  file.header = {"config", "y_m", "x_m", "z_m", "time_s"};
  file.rows = {{2, {"C1", "9", "9", "9", "12.0"}}};
  EXPECT_EQ(MeasurementsToCsv(FromCells({file})),
            "config,y_mm,x_mm,z_mm,time_s\n"
            "C1,2.2,1.1,333.3333333333333,12.0\n");
}

TEST_F(MeasurementWriter, MissingPointsAreEmptyCells) {
  MeasurementFile file;
  file.header = {"config"};
  file.rows = {{2, {"C1"}}};
  Measurements data = FromCells({file});
  data.observations[0].point_in_station.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(MeasurementsToCsv(data), "config,x_mm,y_mm,z_mm\nC1,,,\n");
}

TEST_F(MeasurementWriter, JoinsFilesWithDifferentColumnsAndUnits) {
  MeasurementFile first, second;
  first.header = {"config", "q1_deg", "x_mm", "y_mm", "z_mm"};
  first.rows = {{2, {"A", "90", "0", "0", "0"}}};
  second.header = {"sigma_x_um", "config", "q1_mrad"};
  second.rows = {{2, {"15", "B", "250"}}};
  EXPECT_EQ(MeasurementsToCsv(FromCells({first, second})),
            "config,q1_deg,x_mm,y_mm,z_mm,sigma_x_um\n"
            "A,90,1.1,2.2,333.3333333333333,\n"
            "B,14.32394487827058,1.1,1002.2,333.3333333333333,15\n");
}

// tool_mm and tool_deg are two columns, and so are tool_mm and tool_m of one file; of two files they are one.
TEST_F(MeasurementWriter, ColumnsOfOneStemKeepTheirOwnCells) {
  MeasurementFile first, second, third;
  first.header = {"config", "tool_mm", "tool_deg", "x_deg", "tool"};
  first.rows = {{2, {"A", "12.5", "90", "7", "drill"}}};
  second.header = {"config", "tool_m", "tool_mm"};
  second.rows = {{2, {"B", "0.25", "3"}}};
  third.header = {"config", "tool_m"};
  third.rows = {{2, {"C", "0.5"}}};
  EXPECT_EQ(MeasurementsToCsv(FromCells({first, second})),
            "config,tool_mm,tool_deg,x_deg,tool,tool_m,x_mm,y_mm,z_mm\n"
            "A,12.5,90,7,drill,,1.1,2.2,333.3333333333333\n"
            "B,3,,,,0.25,1.1,1002.2,333.3333333333333\n");
  EXPECT_EQ(MeasurementsToCsv(FromCells({first, third})),
            "config,tool_mm,tool_deg,x_deg,tool,x_mm,y_mm,z_mm\n"
            "A,12.5,90,7,drill,1.1,2.2,333.3333333333333\n"
            "C,500,,,,1.1,1002.2,333.3333333333333\n");
}

TEST_F(MeasurementWriter, WhatItWritesReadsBackInFullPrecision) {
  std::string text =
      "config,marker,station,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,sigma_x_mm,sigma_y_mm,sigma_z_mm\n";
  for (int c = 0; c < 6; ++c) {
    for (const char* marker : {"P1", "P2"}) {
      const std::string id = std::to_string(c);
      text += "C" + id + "," + marker + "," + (c < 3 ? "S1" : "S2") + ",1" + id + ",-2" + id + ".5,3" + id + ",4,-5." +
              id + ",6,0.1,0.2,0.3\n";
    }
  }
  const std::vector<std::string> joints = {"A1", "A2", "A3", "A4", "A5", "A6"};
  const std::vector<bool> prismatic(6, false);
  MeasurementReadOptions without_points;
  without_points.points_required = false;
  const Measurements rows = ReadMeasurements({Write("rows.csv", text)}, joints, prismatic, without_points);
  const Measurements simulated = SimulateMeasurements(rows, Truth(), SigmaOfRows(rows, Vector3<double>::Zero()), 99);
  const Measurements read = ReadMeasurements({Write("simulated.csv", MeasurementsToCsv(simulated))}, joints, prismatic);
  ASSERT_EQ(read.observations.size(), 12u);
  for (int i = 0; i < 12; ++i) {
    // Not every double in m has a double in mm: the last bit may differ.
    const Vector3<double>& point = simulated.observations[i].point_in_station;
    EXPECT_LT((read.observations[i].point_in_station - point).norm(), 4e-16 * point.norm());
    EXPECT_EQ(read.observations[i].sigma, rows.observations[i].sigma);
    EXPECT_EQ(read.ConfigurationOf(read.observations[i]).q, rows.ConfigurationOf(rows.observations[i]).q);
  }
}

}  // namespace
}  // namespace sagitta::simulation_test
