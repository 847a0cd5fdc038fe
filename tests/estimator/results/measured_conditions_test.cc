// Rows beyond the times, temperatures and loads of a calibration: said, where anything goes with these.
#include "estimator/results/measured_conditions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/sagitta.h"
#include "problems/io/robot_file.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::measured_conditions_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kBegin = 5000.0, kBetween = 60.0;  // s
constexpr int kPoses = 30;

// One pose a minute, from 20 to 23 degrees.
void Stamp(Measurements* data) {
  for (Shot& shot : data->shots) {
    shot.has_time = shot.has_temperature = true;
    shot.time = kBegin + kBetween * shot.configuration;
    shot.temperature = 20.0 + 3.0 * shot.configuration / (kPoses - 1.0);
  }
}

struct Measured {
  KnownRobot known;
  Measurements rows;
};

// Of a robot with these effects, whose values are zero as measured.
Measured Calibrated(const std::vector<EffectSpec>& effects) {
  test::LoadedTruth truth;
  test::LoadedDesign design;
  design.configurations = kPoses, design.stations = 1;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), 2e-5, 7, &data);
  Stamp(&data);
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.robot.effects = effects;
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  return {KnownFrom(Calibration{problem, EstimateJointly(problem), {}}), data};
}

std::vector<std::string> SaidOf(const Measured& measured) {
  return WarningsOf(measured.known, measured.rows, Predict(measured.known, measured.rows));
}

template <typename Change>
std::vector<std::string> SaidAfter(Measured measured, const Change& change) {
  for (Shot& shot : measured.rows.shots) {
    if (shot.configuration < 4) change(&shot);
  }
  for (Observation& row : measured.rows.observations) row.point_in_station.setZero();  // to be predicted
  return SaidOf(measured);
}

TEST(MeasuredConditions, RowsOfTheCalibrationAreWithin) {
  EXPECT_THAT(SaidOf(Calibrated({{"station_drift", "S1", {}, {}}, {"thermal_growth", "robot", {}, {}}})), IsEmpty());
}

TEST(MeasuredConditions, AnotherDayIsBeyondADrift) {
  const auto another_day = [](Shot* shot) { shot->time += 86400.0; };
  EXPECT_THAT(SaidAfter(Calibrated({{"station_drift", "S1", {}, {}}}), another_day),
              ElementsAre(AllOf(HasSubstr("8 of 60 shots"), HasSubstr("by up to 24 h"), HasSubstr("S1"))));
  EXPECT_THAT(SaidAfter(Calibrated({}), another_day), IsEmpty());  // nothing goes with the time
  EXPECT_THAT(SaidAfter(Calibrated({{"joint_slip", "A3", {{"after_s", "600"}}, {}}}), another_day), IsEmpty());
}

TEST(MeasuredConditions, AWarmerDayIsBeyondAGrowth) {
  const auto warmer = [](Shot* shot) { shot->temperature = 31.0; };
  EXPECT_THAT(SaidAfter(Calibrated({{"thermal_growth", "robot", {}, {}}}), warmer),
              ElementsAre(AllOf(HasSubstr("8 of 60 shots"), HasSubstr("by up to 8 K"))));
  const auto hardly = [](Shot* shot) { shot->temperature = 23.2; };
  EXPECT_THAT(SaidAfter(Calibrated({{"thermal_growth", "robot", {}, {}}}), hardly), IsEmpty());
}

TEST(MeasuredConditions, AHeavierLoadIsBeyondTheCompliances) {
  const auto heavier = [](Shot* shot) { shot->wrench.force *= 1.5; };
  EXPECT_THAT(SaidAfter(Calibrated({}), heavier),
              ElementsAre(AllOf(HasSubstr("4 of 60 shots"), HasSubstr("3680 N"), HasSubstr("2450 N"))));
}

// The next campaign is warmer, its mean another one: the growth counts from where it was found.
TEST(MeasuredConditions, ARobotFileKnowsTheTemperatureItsGrowthCountsFrom) {
  EffectSpec growth{"thermal_growth", "robot", {}, {}};
  growth.values = {10e-6};
  const Measured measured = Calibrated({growth});
  const Robot robot = ReadRobotText(RobotToYaml(measured.known.robot), "robot.yaml");
  ASSERT_TRUE(robot.reference_temperature.has_value());
  EXPECT_DOUBLE_EQ(*robot.reference_temperature, 21.5);
  Measurements warm = measured.rows;
  for (Shot& shot : warm.shots) shot.temperature += 10.0;
  const CalibrationProblem next = MakeCalibrationProblem(robot, warm, measured.known.loading);
  EXPECT_NEAR(next.shot_inputs()[0].conditions.temperature, 30.0 - 21.5, 1e-12);
  Experiment bare = measured.known.loading;
  bare.origins.reset();
  const CalibrationProblem anew = MakeCalibrationProblem(robot, warm, bare);
  EXPECT_NEAR(anew.shot_inputs()[0].conditions.temperature, 30.0 - 21.5, 1e-12);
  EXPECT_EQ(anew.RobotWith(anew.parameters).reference_temperature, robot.reference_temperature);
  Robot cold = robot;
  cold.reference_temperature.reset();
  EXPECT_NEAR(MakeCalibrationProblem(cold, warm, bare).shot_inputs()[0].conditions.temperature, -1.5, 1e-12);
  // Nothing goes with the temperature: the file says nothing of it.
  EXPECT_FALSE(Calibrated({}).known.robot.reference_temperature.has_value());
}

// A slip between the readings at 600 and 660 s.
TEST(MeasuredConditions, OnWhichSideOfASlipIsNotKnown) {
  const Measured slipped = Calibrated({{"joint_slip", "A3", {{"after_s", "630"}}, {}}});
  const auto between = [](Shot* shot) { shot->time = kBegin + 640.0; };
  EXPECT_THAT(SaidAfter(slipped, between), ElementsAre(AllOf(HasSubstr("8 of 60 shots"), HasSubstr("A3"))));
  const auto at_a_reading = [](Shot* shot) { shot->time = kBegin + 660.0; };
  EXPECT_THAT(SaidAfter(slipped, at_a_reading), IsEmpty());
}

TEST(MeasuredConditions, LearntFunctionsThatAreHeldAreSaidByCalibrate) {
  EffectSpec learnt{"learnt_wave_deviation", "A3", {{"driver", "A3"}, {"order", "5"}}, {}};
  learnt.values = {1e-5, 0.0};
  test::LoadedTruth truth;
  test::LoadedDesign design;
  design.configurations = kPoses, design.stations = 1;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), 2e-5, 7, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  const auto warnings = [&] {
    return Calibrate(MakeCalibrationProblem(setup.robot, data, setup.experiment)).estimate.warnings;
  };
  const auto says_so = ::testing::Contains(HasSubstr("held as learnt"));
  EXPECT_THAT(warnings(), ::testing::Not(says_so));
  setup.robot.effects = {learnt};
  EXPECT_THAT(warnings(), says_so);
}

TEST(MeasuredConditions, AreInTheFile) {
  const Measured measured = Calibrated({});
  const MeasuredConditions& conditions = measured.known.measured_conditions;
  ASSERT_TRUE(conditions.time && conditions.temperature);
  EXPECT_DOUBLE_EQ(conditions.time->least, kBegin);
  EXPECT_DOUBLE_EQ(conditions.time->most, kBegin + kBetween * (kPoses - 1));
  EXPECT_DOUBLE_EQ(conditions.temperature->least, 20.0);
  EXPECT_DOUBLE_EQ(conditions.temperature->most, 23.0);
}

}  // namespace
}  // namespace sagitta::measured_conditions_test
