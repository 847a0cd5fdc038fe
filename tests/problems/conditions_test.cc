// What a shot gets from its rows: clocks, gravity, instrument; and what one unit of a parameter moves.
#include <gtest/gtest.h>

#include "problems/excitation.h"
#include "problems/io/measurement_file.h"
#include "problems/loads.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/two_link.h"

namespace sagitta::conditions_test {
namespace {

class ConditionsTest : public FileTest {
 protected:
  Measurements Read(const std::string& text) {
    return ReadMeasurements({Write("m.csv", text)}, {"J1", "J2"}, {false, false});
  }
  std::vector<ShotConditions> Conditions(const std::string& text, const Experiment& experiment = Experiment()) {
    std::vector<ShotConditions> conditions;
    for (const ShotInput& input : MakeShotInputs(ForwardModel(test::TwoLink()), Read(text), experiment))
      conditions.push_back(input.conditions);
    return conditions;
  }
};

// S2 begins 900 s after S1: at its second row the campaign is 1000 s old and the station 100 s.
constexpr char kTwoStations[] = R"(config,marker,q1_deg,q2_deg,x_mm,y_mm,z_mm,station,time_s
C1,M1,0,0,1400,0,500,S1,5000
C2,M1,10,0,1400,0,500,S1,5060
C3,M1,20,0,1400,0,500,S2,5900
C4,M1,30,0,1400,0,500,S2,6000
)";

TEST_F(ConditionsTest, OneClockForTheCampaignAndOneForEachStation) {
  const std::vector<ShotConditions> shots = Conditions(kTwoStations);
  ASSERT_EQ(shots.size(), 4u);
  const double campaign[4] = {0.0, 60.0, 900.0, 1000.0}, station[4] = {0.0, 60.0, 0.0, 100.0};
  for (int s = 0; s < 4; ++s) {
    EXPECT_EQ(shots[s].time, campaign[s]);
    EXPECT_EQ(shots[s].station_time, station[s]);
  }
}

// A weight that is stated for a load acts where the rows have the load's moments alone.
TEST_F(ConditionsTest, MomentsAreAddedToTheStatedWeight) {
  Experiment experiment;
  experiment.loads["V"].mass = 10.0;
  experiment.loads["V"].point = Vector3<double>(0.1, 0.0, 0.0);
  const std::string rows = R"(config,marker,q1_deg,q2_deg,x_mm,y_mm,z_mm,load,my_Nm
C1,M1,0,0,1400,0,500,V,30
)";
  const std::vector<ShotConditions> shots = Conditions(rows, experiment);
  ASSERT_EQ(shots.front().load_wrenches.size(), 1u);
  const AppliedWrench& wrench = shots.front().load_wrenches.front();
  EXPECT_LT((wrench.force - Vector3<double>(0.0, 0.0, -10.0 * experiment.gravity)).norm(), 1e-12);
  EXPECT_EQ(wrench.moment, Vector3<double>(0.0, 30.0, 0.0));
  experiment.loads["V"].frame = WrenchFrame::kFlange;  // of which gravity is none
  EXPECT_THROW(Conditions(rows, experiment), InputError);
}

// Rows need not stand in the order in which they were measured: time begins with the earliest.
TEST_F(ConditionsTest, TimeCountsFromTheEarliestRow) {
  const std::vector<ShotConditions> shots = Conditions(R"(config,marker,q1_deg,q2_deg,x_mm,y_mm,z_mm,station,time_s
C1,M1,0,0,1400,0,500,S1,5000
C2,M1,10,0,1400,0,500,S1,1000
C3,M1,20,0,1400,0,500,S2,9000
C4,M1,30,0,1400,0,500,S2,6000
C4,M2,30,0,1400,0,600,S2,5990
)");
  ASSERT_EQ(shots.size(), 4u);
  const double campaign[4] = {4000.0, 0.0, 8000.0, 4995.0}, station[4] = {4000.0, 0.0, 3010.0, 5.0};
  for (int s = 0; s < 4; ++s) {
    EXPECT_EQ(shots[s].time, campaign[s]);
    EXPECT_EQ(shots[s].station_time, station[s]);
  }
}

// Rows that are predicted with an estimate count from where its own data began.
TEST_F(ConditionsTest, OriginsOfAnotherCampaignCount) {
  Experiment experiment;
  experiment.origins = ConditionOrigins{4000.0, {{"S2", 5500.0}}, 20.0};
  const std::vector<ShotConditions> shots = Conditions(kTwoStations, experiment);
  EXPECT_EQ(shots[3].time, 2000.0);
  EXPECT_EQ(shots[3].station_time, 500.0);
  EXPECT_EQ(shots[1].station_time, 60.0);  // a station that it does not know: its own first row
}

// 20, 23 and 29 degC have the mean 24; the row without a thermometer has none.
TEST_F(ConditionsTest, TemperatureCountsFromTheMeanOfTheData) {
  const std::vector<ShotConditions> shots = Conditions(
      "config,marker,q1_deg,q2_deg,x_mm,y_mm,z_mm,temperature_degC\nC1,M1,0,0,1,2,3,20\nC2,M1,10,0,1,2,4,23\n"
      "C3,M1,20,0,1,2,5,\nC4,M1,30,0,1,2,6,29\n");
  const double above[4] = {-4.0, -1.0, 0.0, 5.0};
  for (int s = 0; s < 4; ++s) {
    EXPECT_EQ(shots[s].has_temperature, s != 2);
    EXPECT_NEAR(shots[s].temperature, above[s], 1e-12);
  }
}

// 10 kg at (0.1, 0, 0) of the flange, the boom upright (q2 = 90 deg), gravity along -x of the frame it is stated in.
TEST_F(ConditionsTest, GravityIsInTheFrameItIsStatedIn) {
  Robot robot = test::TwoLink();
  robot.compliances.push_back({1, {{0.0, 1e-6}}, false});
  const ForwardModel model(robot);
  Experiment experiment;
  experiment.tool_mass = 10.0;
  experiment.tool_com = {0.1, 0.0, 0.0};
  experiment.gravity_direction = -Vector3<double>::UnitX();
  experiment.stations["S1"].instrument_xyz = Vector3<double>(1.0, 2.0, 3.0);
  // The station sees the base turned by 90 deg about z: the measurement frame's -x is the base's +y.
  Pose<double> base;
  base.rotation = RotationFromVector(Vector3<double>(0.0, 0.0, 90 * kDegree));
  const std::vector<double> theta = model.NominalValues();
  for (const bool in_base : {true, false}) {
    experiment.gravity_in_base = in_base;
    const ShotInput shot = MakeShotInputs(model,
                                          Read("config,marker,q1_deg,q2_deg,x_mm,y_mm,z_mm\n"
                                               "C1,M1,0,90,1400,0,500\nC2,M1,10,0,1400,0,500\n"),
                                          experiment)[0];
    EXPECT_EQ(shot.conditions.instrument, Vector3<double>(1.0, 2.0, 3.0));
    const Equilibrium state = model.Equilibrate(shot, theta.data(), base.rotation);
    // In the base's -x: 0.5 m above J2, torque about y = z F_x = 0.5 m * -98.0665 N. In its +y: none about y.
    EXPECT_NEAR(state.torque[0], in_base ? -49.03325 : 0.0, 1e-2);
  }
}

// At 40 N m one urad/Nm turns J2 by 40 urad: 5 mrad are 125 urad/Nm. Of a small arm with 0.5 N m: 10000 urad/Nm.
TEST_F(ConditionsTest, AComplianceIsLimitedByWhatItMoves) {
  for (const double force : {100.0, 1.25}) {
    Robot robot = test::TwoLink();
    robot.compliances.push_back({0, {{0.0, 0.0}}, false});
    robot.compliances.push_back({1, {{0.0, 0.0}}, false});
    robot.effects.push_back({"encoder_gain", "J2", {}, {0.0}});
    robot.effects.push_back({"station_scale", "S1", {}, {0.0}});
    Experiment experiment;
    experiment.load_point = Vector3<double>::Zero();
    experiment.loads["V"].mass = force / experiment.gravity;
    experiment.estimate.compliance = {Selection::Kind::kAll, {}};
    experiment.noise.sigma = 1e-5;
    CalibrationProblem problem = MakeCalibrationProblem(
        robot,
        Read("config,marker,q1_deg,q2_deg,x_mm,y_mm,z_mm,load\nC1,M1,0,0,1400,0,500,none\nC1,M1,0,0,1400,0,500,V\n"
             "C2,M1,10,60,1,0,5,none\nC2,M1,10,60,1,0,5,V\nC3,M1,50,-30,1,2,5,none\nC3,M1,50,-30,1,2,6,V\n"
             "C4,M1,70,20,3,2,5,none\nC4,M1,70,20,3,2,6,V\n"),
        experiment);
    SetHoldLimits(problem, &problem.parameters);
    const auto limit = [&](const std::string& name) {
      return problem.parameters.coordinates()[problem.parameters.FindCoordinate(name)].hold_limit;
    };
    EXPECT_NEAR(limit("compliance/J2"), 5e-3 / (0.4 * force), 1e-9 / force);
    // Weights do not turn an upright axis at all: what they leave there is of its kind.
    EXPECT_EQ(limit("compliance/J1"), TraitsOf(Quantity::kCompliance).hold_limit);
    // The largest |q2| is 60 deg: 5 mrad of it.
    EXPECT_NEAR(limit("effect/encoder_gain/J2/gain"), 5e-3 / (60 * kDegree), 1e-9);
    EXPECT_EQ(limit("marker/M1/x"), 5e-3);
    EXPECT_EQ(limit("geometry/a1"), 5e-3);
  }
}

// A pull along the slot's own axis turns nothing about it, wherever the arm is: 1e-17 is no motion, and its limit is
// that of its kind. (A UR5's robot.extended.yaml held it to 10^14 rad, and the solver went astray along it.)
TEST_F(ConditionsTest, RoundOffIsNoMotion) {
  Robot robot = test::TwoLink();
  EffectSpec sag{"self_weight_sag", "J1", {{"about", "v"}}, std::vector<double>(6, 0.0)};
  robot.effects.push_back(sag);
  Experiment experiment;
  experiment.noise.sigma = 1e-5;
  CalibrationProblem problem = MakeCalibrationProblem(
      robot,
      Read("config,marker,q1_deg,q2_deg,x_mm,y_mm,z_mm\nC1,M1,11,7,1400,0,500\nC2,M1,10,60,1,0,5\n"
           "C3,M1,53,-30,1,2,5\nC4,M1,71,23,3,2,5\nC5,M1,-20,23,3,2,5\nC6,M1,-70,23,3,2,5\nC7,M1,-70,50,3,2,5\n"),
      experiment);
  Pose<double> base;
  base.rotation = RotationFromVector(Vector3<double>(0.3, -0.2, 0.7));
  problem.parameters.SetBaseInStation(0, base);
  SetHoldLimits(problem, &problem.parameters);
  int of_their_kind = 0;
  for (const std::string axis : {"x", "y", "z"}) {
    const double limit =
        problem.parameters
            .coordinates()[problem.parameters.FindCoordinate("effect/self_weight_sag[about=v]/J1/s1" + axis)]
            .hold_limit;
    EXPECT_LT(limit, 1.0) << axis;
    of_their_kind += limit == TraitsOf(Quantity::kSmallAngle).hold_limit;
  }
  EXPECT_EQ(of_their_kind, 1);
}

}  // namespace
}  // namespace sagitta::conditions_test
