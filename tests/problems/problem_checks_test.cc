// What robot, experiment and data say together is checked before anything is estimated.
#include "problems/problem_checks.h"

#include <gtest/gtest.h>

#include "problems/calibration_problem.h"
#include "problems/text.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::problem_checks_test {
namespace {

using From = NoiseSpec::From;

class ProblemChecksTest : public ::testing::Test {
 protected:
  ProblemChecksTest() {
    robot_.chain = test::Kr270Chain();
    data_ = test::DesignMeasurements({6, 1, 1, 1e-4});
    test::MeasureKr270(test::Kr270Truth(), 1e-4, 1, &data_);
    experiment_.file = "experiment.yaml";
    experiment_.robot_file = "robot.yaml";
  }
  std::string Refusal() const {
    return ErrorOf([&] { MakeCalibrationProblem(robot_, data_, experiment_); });
  }

  Robot robot_;
  Measurements data_;
  Experiment experiment_;
};

TEST_F(ProblemChecksTest, WhatIsNamedHasRows) {
  EXPECT_EQ(Refusal(), "");
  experiment_.markers["P4"];
  experiment_.lines["markers.P4"] = 7;
  EXPECT_TRUE(SaysInOrder(Refusal(), {"experiment.yaml:7", "markers.P4", "no row measures this marker", "P1"}));
  experiment_.markers.clear();
  experiment_.stations["S2"];
  EXPECT_TRUE(SaysInOrder(Refusal(), {"experiment.yaml", "stations.S2", "no row is measured from", "S1"}));
}

// Bases and markers have no nominal value: what holds one says where.
TEST_F(ProblemChecksTest, WhatIsHeldByNameIsStated) {
  for (const char* held : {"base/S1", "base/S1/rz"}) {
    experiment_.estimate.fixed = {held};
    EXPECT_TRUE(SaysInOrder(Refusal(), {"--fixed", "the base is held but station 'S1' has no pose", "stations: {S1"}));
  }
  experiment_.stations["S1"].base_xyz = Vector3<double>(1.0, 2.0, 3.0);
  EXPECT_EQ(Refusal(), "");
  experiment_.estimate.fixed = {"marker/P1"};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"--fixed", "the markers are held but marker 'P1' has no point", "markers: {P1"}));
  experiment_.markers["P1"].point = Vector3<double>(0.1, 0.2, 0.3);
  EXPECT_EQ(Refusal(), "");
}

// Of two names of which one holds the other the longer goes last, whichever is free.
TEST_F(ProblemChecksTest, APartIsFreeOfWhatIsFixedAndTheOtherWayRound) {
  const auto free_errors = [&] {
    const CalibrationProblem problem = MakeCalibrationProblem(robot_, data_, experiment_);
    std::vector<std::string> names;
    for (const int i : problem.parameters.Match("geometry")) {
      const Coordinate& coordinate = problem.parameters.coordinates()[i];
      if (coordinate.free) names.push_back(coordinate.name);
    }
    return names;
  };
  const std::vector<std::string> all = free_errors();
  experiment_.estimate.fixed = {"geometry"};
  experiment_.estimate.free = {"geometry/p_x2"};
  EXPECT_EQ(free_errors(), std::vector<std::string>{"geometry/p_x2"});
  std::swap(experiment_.estimate.fixed, experiment_.estimate.free);
  const std::vector<std::string> others = free_errors();
  EXPECT_EQ(std::count(others.begin(), others.end(), "geometry/p_x2"), 0);
  EXPECT_GE(others.size() + 1, all.size());
  experiment_.estimate.fixed = {"geometri"};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"--fixed", "no parameter 'geometri'", "did you mean 'geometry'?"}));
  experiment_.estimate.fixed = {"p_x2"};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"--fixed", "no parameter 'p_x2'", "did you mean 'geometry/p_x2'?"}));
}

// joint_offset of other programs: what it is called here is said.
TEST_F(ProblemChecksTest, OffsetsOfJointsHaveTheNamesOfTheirMotions) {
  const std::string right = robot_.chain.transforms[robot_.chain.JointTransform(1)].error;
  const std::string joint = robot_.chain.joints[1].name;
  ASSERT_NE(right, joint + ".theta");
  experiment_.estimate.geometry = {Selection::Kind::kList, {joint + ".theta"}};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"estimate.geometry", "no geometric error '" + joint + ".theta'",
                                      "the joints' own offsets are [", right}));
}

// With less to estimate, as the hint says, the same rows suffice.
TEST_F(ProblemChecksTest, FewerEquationsThanUnknownsNameWhatToHold) {
  data_ = test::DesignMeasurements({2, 1, 1, 1e-4});
  const std::string refusal = Refusal();
  EXPECT_TRUE(SaysInOrder(refusal, {"fewer equations (18) than unknowns (33)", "base 6", "geometry 18 and marker 9",
                                    "at least 15 have to be held", "--fixed="}));
  const std::string names = refusal.substr(refusal.find("--fixed=") + 8);
  experiment_.estimate.fixed = SplitText(names.substr(0, names.find_first_of(" )\n")), ',');
  EXPECT_EQ(experiment_.estimate.fixed.size(), 15u);
  EXPECT_EQ(Refusal(), "");
}

// What is held out could have been fitted.
TEST_F(ProblemChecksTest, FewerEquationsThanUnknownsOfAFileThatHasMoreNameTheHoldout) {
  data_ = test::DesignMeasurements({4, 1, 1, 1e-4});
  experiment_.validation.kind = ValidationSpec::Kind::kFraction;
  experiment_.validation.fraction = 0.5;
  EXPECT_TRUE(SaysInOrder(Refusal(), {"fewer equations (", "than unknowns (33)",
                                      "more are of configurations that are held out", "validation: none"}));
}

// Whoever may change the data, at once or later, gets what is fitted as they are then; copies are not.
TEST_F(ProblemChecksTest, WhatIsFittedFollowsTheData) {
  CalibrationProblem problem = MakeCalibrationProblem(robot_, data_, experiment_);
  std::vector<int> expected = problem.CalibrationObservations();
  ASSERT_EQ(expected.size(), data_.observations.size());
  const CalibrationProblem before = problem;
  Measurements* const data = problem.mutable_data();
  EXPECT_EQ(problem.CalibrationObservations(), expected);
  data->ExcludeRow(2);
  expected.erase(expected.begin() + 2);
  EXPECT_EQ(problem.CalibrationObservations(), expected);
  EXPECT_EQ(before.CalibrationObservations().size(), data_.observations.size());
  Measurements fewer = before.data();
  for (const int i : {0, 1, 2}) fewer.ExcludeRow(i);
  CalibrationProblem replaced = before;
  replaced.set_data(fewer);
  EXPECT_EQ(replaced.CalibrationObservations().size(), data_.observations.size() - 3);
}

TEST_F(ProblemChecksTest, TargetsOfEffectsAreInTheData) {
  const auto refused = [&](const std::string& effect, const std::string& target,
                           const std::map<std::string, std::string>& settings = {}) {
    robot_.effects = {{effect, target, settings, {}}};
    return Refusal();
  };
  EXPECT_TRUE(SaysInOrder(refused("station_scale", "S9"), {"robot.yaml", "station_scale", "no 'S9'", "S1"}));
  EXPECT_TRUE(SaysInOrder(refused("marker_shift", "P9", {{"after_s", "100"}}),
                          {"robot.yaml", "marker_shift", "no 'P9'", "P1"}));
  EXPECT_TRUE(SaysInOrder(refused("payload", "crate"), {"robot.yaml", "payload", "no 'crate'"}));
}

TEST_F(ProblemChecksTest, JointsOfEffectsAreThoseOfTheRobot) {
  robot_.effects = {{"joint_harmonic", "A7", {{"order", "1"}}, {}}};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"robot.yaml", "joint_harmonic", "the robot has no joint 'A7'", "A1"}));
  robot_.effects = {{"joint_coupling", "A2", {{"driver", "B3"}}, {}}};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"joint_coupling", "the robot has no joint 'B3'", "A3"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { MakeKnownProblem(robot_, data_, experiment_, {}); }), {"no joint 'B3'"}));
}

TEST_F(ProblemChecksTest, ColumnsOfEffectsAreInTheData) {
  robot_.effects = {{"thermal_growth", "robot", {}, {}}};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"simulated.csv:2", "temperature_degC", "thermal_growth/robot needs this column",
                                      "remove the effect"}));
}

// Loads bend the joints, and so does what pulls by itself.
TEST_F(ProblemChecksTest, CompliancesNeedWhatPulls) {
  experiment_.estimate.compliance = {Selection::Kind::kList, {"A2"}};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"estimate.compliance", "no row is loaded"}));
  robot_.effects = {{"encoder_gain", "A3", {}, {}}};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"estimate.compliance", "no row is loaded"}));
  robot_.effects = {{"link_gravity", "A3", {}, {300.0, 200.0, 0.0, 50.0}}};
  EXPECT_EQ(Refusal(), "");
}

// At the angle that the spring has, from its own zero and with the joints that drive it.
TEST_F(ProblemChecksTest, SpringsHaveALengthAtTheirOwnAngle) {
  const double none = std::atan2(0.3, 0.4) - kPi;  // L = a: the lever's end is on the anchor
  robot_.gravity_compensator = {1, 0.5, 0.3, 0.4, 0.3, 1e4};
  EXPECT_EQ(Refusal(), "");
  const Eigen::VectorXd& q = data_.configurations[0].q;
  robot_.gravity_compensator->zero = q[1] - none;
  EXPECT_TRUE(SaysInOrder(Refusal(), {"gravity_compensator", "no length", data_.configurations[0].id}));
  robot_.gravity_compensator->zero.reset();
  robot_.chain.couplings = {{1, 0, (none - q[1]) / q[0]}};
  EXPECT_TRUE(SaysInOrder(Refusal(), {"gravity_compensator", "no length", data_.configurations[0].id}));
}

// A joint may be called as a place is; a marker there has two meanings.
TEST_F(ProblemChecksTest, APlaceHasOneMeaning) {
  experiment_.markers["P1"].on = MarkerPlace::Named("base");
  EXPECT_EQ(Refusal(), "");
  robot_.chain.joints[0].name = "base";
  EXPECT_TRUE(SaysInOrder(Refusal(), {"markers.P1.on", "'base' is a joint of this robot too", "another name"}));
}

TEST_F(ProblemChecksTest, WeightsHangAlongAGravityThatIsKnown) {
  experiment_.stations["S1"].levelled = false;
  EXPECT_EQ(Refusal(), "");
  robot_.compliances = {{1, {{0.0, 1e-6}}, false}};
  experiment_.tool_mass = 20.0;
  EXPECT_TRUE(SaysInOrder(Refusal(), {"stations.S1.levelled", "not levelled", "frame: base"}));
  experiment_.gravity_in_base = true;
  EXPECT_EQ(Refusal(), "");
}

// Weights, loss and noise that do not go together.
TEST_F(ProblemChecksTest, NoiseOfResidualsIsAllThatScatters) {
  experiment_.noise.from = From::kResiduals;
  experiment_.repeatability.angle.common = 1e-5;
  EXPECT_TRUE(SaysInOrder(Refusal(), {"noise.from", "contain the repeatability", "variance-components"}));
  experiment_.repeatability = {};
  experiment_.method.loss = LossKind::kHuber;
  EXPECT_TRUE(SaysInOrder(Refusal(), {"loss", "outliers", "loss: none"}));
}

TEST_F(ProblemChecksTest, Equation14WeighsRows) {
  experiment_.method.weights = Weights::kEq14;
  for (const From from : {From::kVarianceComponents, From::kRepeats}) {
    experiment_.noise.from = from;
    EXPECT_TRUE(SaysInOrder(Refusal(), {"weights", "eq. (14) weighs standard deviations of rows", "weights: sigma"}));
  }
}

TEST_F(ProblemChecksTest, RepeatsThatAreCopiesShowNoNoise) {
  experiment_.noise.from = From::kRepeats;
  EXPECT_TRUE(SaysInOrder(Refusal(), {"noise.from", "no marker was shot twice"}));
  Shot again = data_.shots[0];
  again.repeat = "2";
  again.observations.clear();
  for (const int i : data_.shots[0].observations) {
    Observation copy = data_.observations[i];
    copy.shot = static_cast<int>(data_.shots.size());
    again.observations.push_back(static_cast<int>(data_.observations.size()));
    data_.observations.push_back(copy);
  }
  data_.shots.push_back(again);
  EXPECT_TRUE(SaysInOrder(Refusal(), {"noise.from", "equal to the last digit", "instead of copying"}));
}

TEST_F(ProblemChecksTest, SigmasAreStatedByAllRowsOrByNone) {
  data_.observations[4].sigma.setZero();
  EXPECT_TRUE(SaysInOrder(Refusal(), {"simulated.csv:6", "sigma_x_mm", "this one has none", "--sigma_mm"}));
  for (Observation& observation : data_.observations) observation.sigma.setZero();
  EXPECT_EQ(Refusal(), "");
  experiment_.repeatability.angle.common = 1e-5;
  EXPECT_TRUE(SaysInOrder(Refusal(), {"repeatability_urad", "the instrument's noise is not", "variance-components"}));
}

}  // namespace
}  // namespace sagitta::problem_checks_test
