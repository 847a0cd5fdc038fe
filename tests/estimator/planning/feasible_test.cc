// Which poses can be measured: collisions against distances by sampling, lines of sight and cones against hand-made
// ones.
#include "estimator/planning/feasible.h"

#include <gtest/gtest.h>

#include <random>

#include "estimator/planning/collision.h"
#include "estimator/planning/plan.h"
#include "models/kinematics.h"
#include "problems/input_error.h"
#include "problems/io/cell_file.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::feasible_test {
namespace {

Cell CellOf(const std::string& text, const Chain& chain) {
  return ReadCellText("schema: sagitta/cell/1\n" + text, "cell.yaml", chain);
}

std::vector<Pose<double>> FramesAt(const Chain& chain, const Eigen::VectorXd& q) {
  const ForwardModel model(chain);
  const std::vector<double> theta(model.num_parameters(), 0.0);
  const std::vector<double> values = model.TransformValues(ShotInput(q), theta.data());
  ChainState<double> state;
  EvaluateChain(model.chain(), values.data(), &state);
  return state.frames;
}

// Least distance of two lines, by sampling both: 2 mm too large at most here.
double SampledDistance(const Vector3<double>& a, const Vector3<double>& b, const Vector3<double>& c,
                       const Vector3<double>& d) {
  double least = 1e9;
  for (int i = 0; i <= 400; ++i) {
    const Vector3<double> p = a + i / 400.0 * (b - a);
    const double t = std::clamp((p - c).dot(d - c) / (d - c).squaredNorm(), 0.0, 1.0);
    least = std::min(least, (p - c - t * (d - c)).norm());
  }
  return least;
}

const char* const kBodies =
    "capsules:\n"
    "  - {name: column, on: A1, from_mm: [0, 0, -500], to_mm: [0, 0, 0], radius_mm: 150}\n"
    "  - {name: upper arm, on: A2, from_mm: [0, 0, 0], to_mm: [1250, 0, 0], radius_mm: 120}\n"
    "  - {name: tool, on: flange, from_mm: [0, 0, 0], to_mm: [300, 0, 0], radius_mm: 80}\n";

// Bodies that often meet.
const char* const kLargeBodies =
    "capsules:\n"
    "  - {name: column, on: A1, from_mm: [-600, 0, -500], to_mm: [0, 0, 0], radius_mm: 500}\n"
    "  - {name: upper arm, on: A2, from_mm: [0, 0, 0], to_mm: [1250, 0, 0], radius_mm: 400}\n"
    "  - {name: tool, on: flange, from_mm: [0, 0, 0], to_mm: [900, 0, 0], radius_mm: 300}\n";

Eigen::VectorXd RandomPose(std::mt19937* random) {
  Eigen::VectorXd q(6);
  const double low[6] = {-150, -140, -100, -170, -110, -170}, high[6] = {150, 0, 140, 170, 110, 170};
  for (int j = 0; j < 6; ++j) q[j] = kDegree * std::uniform_real_distribution<double>(low[j], high[j])(*random);
  return q;
}

TEST(FeasibleTest, BodiesMeetWhereTheirAxesComeNearerThanTheirRadii) {
  const Chain chain = test::Kr270Chain();
  const Cell cell = CellOf(std::string(kLargeBodies) + "clearance_mm: 10\n", chain);
  const CollisionScene scene(chain, cell);
  std::mt19937 random(5);
  int meetings = 0, compared = 0;
  for (int k = 0; k < 1500; ++k) {
    const std::vector<Pose<double>> frames = FramesAt(chain, RandomPose(&random));
    double room = 1e9;  // of the tool to column and upper arm; column and upper arm share A2
    const auto& tool = cell.capsules[2];
    const Pose<double>& flange = frames[chain.FlangeFrame()];
    for (const int i : {0, 1}) {
      const auto& body = cell.capsules[i];
      const Pose<double>& frame = frames[chain.FrameAfterJoint(body.on)];
      room = std::min(room, SampledDistance(frame * body.from, frame * body.to, flange * tool.from, flange * tool.to) -
                                body.radius - tool.radius - 0.010);
    }
    if (std::abs(room) < 0.003) continue;  // sampling does not decide
    ++compared;
    const std::string words = scene.Collision(frames);
    EXPECT_EQ(words.empty(), room > 0.0) << words << ", room " << room;
    if (!words.empty()) ++meetings;
  }
  EXPECT_GT(compared, 1400);
  EXPECT_GT(meetings, 20);
}

TEST(FeasibleTest, PairsThatMayTouchDo) {
  const Chain chain = test::Kr270Chain();
  const CollisionScene strict(chain, CellOf(kLargeBodies, chain));
  const CollisionScene lenient(
      chain, CellOf(std::string(kLargeBodies) + "may_touch: [[tool, upper arm], [column, tool]]\n", chain));
  std::mt19937 random(5);
  int meetings = 0;
  for (int k = 0; k < 300; ++k) {
    const std::vector<Pose<double>> frames = FramesAt(chain, RandomPose(&random));
    if (!strict.Collision(frames).empty()) ++meetings;
    EXPECT_EQ(lenient.Collision(frames), "");
  }
  EXPECT_GT(meetings, 0);
}

// The arm stretched along x at q = 0, 750 mm up: the flange at x = 350 + 1250 + 1100 + 230, z = 750 - 55.
TEST(FeasibleTest, BoxesAndFloorAreMetToTheMillimetre) {
  const Chain chain = test::Kr270Chain();
  const std::vector<Pose<double>> frames = FramesAt(chain, Eigen::VectorXd::Zero(6));
  const auto words = [&](const std::string& text) {
    return CollisionScene(chain, CellOf(kBodies + text, chain)).Collision(frames);
  };
  const auto box_from = [](const std::string& x) {
    return "keep_out: [{name: wall, min_mm: [" + x + ", -2000, 0], max_mm: [4000, 2000, 3000]}]\n";
  };
  // The tool ends at 2930 + 300 + 80 = 3310 mm.
  EXPECT_EQ(words(box_from("3311")), "");
  EXPECT_EQ(words(box_from("3309")), "tool meets wall");
  EXPECT_EQ(words(box_from("3319") + "clearance_mm: 10\n"), "tool meets wall");
  // The same wall, turned by 90 degrees about z.
  EXPECT_EQ(
      words("keep_out: [{name: wall, size_mm: [4000, 691, 3000], xyz_mm: [3654.5, 0, 1500], rpy_deg: [0, 0, 90]}]\n"),
      "tool meets wall");
  EXPECT_EQ(
      words("keep_out: [{name: wall, size_mm: [4000, 687, 3000], xyz_mm: [3654.5, 0, 1500], rpy_deg: [0, 0, 90]}]\n"),
      "");
  // The upper arm's lowest point is 750 - 120 mm, the tool's 695 - 80, the column's 750 - 500 - 150.
  EXPECT_EQ(words("floor_mm: 99\n"), "");
  EXPECT_EQ(words("floor_mm: 101\n"), "column reaches the floor");
}

TEST(FeasibleTest, WhatStandsInALineOfSightIsNamed) {
  const Chain chain = test::Kr270Chain();
  const CollisionScene scene(
      chain, CellOf(std::string(kBodies) +
                        "keep_out: [{name: pillar, min_mm: [990, -2100, 0], max_mm: [1010, -2000, 3000]}]\n",
                    chain));
  const std::vector<Pose<double>> frames = FramesAt(chain, Eigen::VectorXd::Zero(6));
  EXPECT_EQ(scene.Obstruction(frames, {1.0, -3.0, 2.0}, {1.0, -1.0, 2.0}), "pillar");
  EXPECT_EQ(scene.Obstruction(frames, {1.1, -3.0, 2.0}, {1.1, -1.0, 2.0}), "");
  // Through the upper arm, along x at z = 750 mm, from one side to the other; past its end and above it not.
  EXPECT_EQ(scene.Obstruction(frames, {1.2, -1.0, 0.75}, {1.2, 1.0, 0.75}), "upper arm");
  EXPECT_EQ(scene.Obstruction(frames, {1.2, -1.0, 0.872}, {1.2, 1.0, 0.872}), "");
  // A reflector on the arm itself: the last 100 mm do not count.
  EXPECT_EQ(scene.Obstruction(frames, {1.2, -1.0, 0.75}, {1.2, -0.05, 0.75}), "");
}

// One marker at the flange's origin, the instrument at the origin of a station whose base lies at (0, 3, 0), turned by
// 90 degrees about z.
struct Placed {
  Placed() {
    test::Kr270Design design;
    design.configurations = 18;
    design.stations = 1;
    Measurements data = test::DesignMeasurements(design);
    Experiment experiment;
    experiment.noise.from = NoiseSpec::From::kSigma;
    experiment.noise.sigma = 1e-4;
    Robot robot;
    robot.name = "KR 270";
    robot.chain = test::Kr270Chain();
    problem = std::make_unique<CalibrationProblem>(MakeCalibrationProblem(robot, data, experiment));
    Pose<double> base;
    base.translation = {0.0, 3.0, 0.0};
    base.rotation = RotationFromRpy({0.0, 0.0, 0.5 * kPi});
    problem->parameters.SetBaseInStation(0, base);
    problem->parameters.SetMarkerPoint(0, Vector3<double>::Zero());
  }
  std::string WhyNot(const std::string& cell_text, const Eigen::VectorXd& q) const {
    const Cell cell = CellOf(cell_text, problem->robot().chain);
    return FeasiblePoses(*problem, &cell).WhyNot(q, {{0, 0}});
  }
  std::unique_ptr<CalibrationProblem> problem;
};

TEST(FeasibleTest, SightsAndConesAreThoseOfTheStation) {
  const Placed placed;
  const std::string& station = placed.problem->data().stations[0];
  const std::string& marker = placed.problem->data().markers[0];
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(6);
  // The flange at (2930, 0, 695) mm of the base is at (0, 3 + 2.93, 0.695) m of the station: 5.9706 m away, at
  // 6.6845 degrees of elevation.
  const std::string head = "sight: {" + station + ": {";
  EXPECT_EQ(placed.WhyNot(head + "max_range_mm: 5971}}\n", q), "");
  EXPECT_NE(placed.WhyNot(head + "max_range_mm: 5970}}\n", q).find("out of the range of"), std::string::npos);
  EXPECT_EQ(placed.WhyNot(head + "min_elevation_deg: 6.68}}\n", q), "");
  EXPECT_NE(placed.WhyNot(head + "min_elevation_deg: 6.69}}\n", q).find("elevations"), std::string::npos);
  // The instrument lies at (-3, 0, 0) m of the base, from the flange in direction (-5.93, 0, -0.695): 6.6845 degrees
  // from -x, the flange's axes being those of the base.
  const auto cone = [&](const std::string& angle) {
    return "reflectors: {" + marker + ": {axis: [-1, 0, 0], half_angle_deg: " + angle + "}}\n";
  };
  EXPECT_EQ(placed.WhyNot(cone("6.69"), q), "");
  EXPECT_EQ(placed.WhyNot(cone("6.68"), q), "reflector " + marker + " does not face " + station);
  // The tool's x axis turns with A5.
  Eigen::VectorXd bent = q;
  bent[4] = 30.0 * kDegree;
  const std::string tool = "tool_cone: {axis: [1, 0, 0], direction: [1, 0, 0], half_angle_deg: ";
  EXPECT_EQ(placed.WhyNot(tool + "30.1}\n", bent), "");
  EXPECT_EQ(placed.WhyNot(tool + "29.9}\n", bent), "the tool leaves its cone");
  EXPECT_EQ(placed.WhyNot("joints: {A5: {max_deg: 29}}\n", bent), "joint A5 is outside its range in the cell");
  EXPECT_EQ(placed.WhyNot("joints: {A5: {levels_deg: [0, 30]}}\n", bent), "");
  EXPECT_EQ(placed.WhyNot("joints: {A5: {levels_deg: [0, 31]}}\n", bent), "joint A5 is at none of its levels");
  EXPECT_EQ(placed.WhyNot("stay_in: [{name: space, min_mm: [0, -1, 0], max_mm: [2931, 1, 800]}]\n", q), "");
  EXPECT_EQ(placed.WhyNot("stay_in: [{name: space, min_mm: [0, -1, 0], max_mm: [2929, 1, 800]}]\n", q),
            "the flange leaves the boxes to stay in");
}

TEST(FeasibleTest, ANameThatNobodyHasIsRefused) {
  const Placed placed;
  EXPECT_THROW(placed.WhyNot("sight: {S9: {}}\n", Eigen::VectorXd::Zero(6)), InputError);
  EXPECT_THROW(placed.WhyNot("reflectors: {M9: {axis: [1, 0, 0], half_angle_deg: 30}}\n", Eigen::VectorXd::Zero(6)),
               InputError);
  EXPECT_THROW(placed.WhyNot("joints: {A9: {max_deg: 1}}\n", Eigen::VectorXd::Zero(6)), InputError);
  EXPECT_THROW(placed.WhyNot("may_touch: [[a, b]]\n", Eigen::VectorXd::Zero(6)), InputError);
  EXPECT_THROW(placed.WhyNot("ceiling_mm: 2\n", Eigen::VectorXd::Zero(6)), InputError);
}

// Every pose of a plan keeps to the cell, those that were moved too.
TEST(FeasibleTest, PlansKeepToTheCell) {
  test::Kr270Design design;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 3, &data);
  Robot robot;
  robot.name = "KR 270";
  robot.chain = test::Kr270Chain();
  const Cell cell = CellOf(
      "joints: {A1: {min_deg: -60, max_deg: 60}, A2: {levels_deg: [-100, -60, -20]}, A3: {min_deg: -90, max_deg: "
      "120},\n"
      "         A4: {min_deg: -170, max_deg: 170}, A5: {min_deg: -110, max_deg: 110}, A6: {min_deg: -170, max_deg: "
      "170}}\n"
      "floor_mm: 100\n" +
          std::string(kBodies),
      robot.chain);
  PlanRequest request;
  request.poses = 13;
  request.pool = 120;
  request.starts = 1;
  request.cell = &cell;
  const Plan plan = MakePlan(robot, data, Experiment(), request);
  EXPECT_TRUE(plan.moved);
  EXPECT_GT(plan.infeasible_because.count("the flange is below the floor"), 0u);
  const CollisionScene scene(robot.chain, cell);
  for (const Configuration& configuration : plan.rows.configurations) {
    const Eigen::VectorXd& q = configuration.q;
    EXPECT_LE(std::abs(q[0]), 60.0 * kDegree + 1e-9);
    EXPECT_LT(std::min({std::abs(q[1] + 100 * kDegree), std::abs(q[1] + 60 * kDegree), std::abs(q[1] + 20 * kDegree)}),
              1e-9);
    EXPECT_EQ(scene.Collision(FramesAt(robot.chain, q)), "");
  }
}

}  // namespace
}  // namespace sagitta::feasible_test
