// An arm that grows late: points from the independent kinematics of tests/support, the arm's temperature from the law
// of cooling every second, of which the thermometer's readings at the shots are all that the diagnosis sees.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "estimator/diagnosis/scanned_settings.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/random_vector.h"

namespace sagitta::thermal_lag_test {
namespace {

constexpr double kSigma = 1e-5;    // m
constexpr double kGrowth = 12e-6;  // 1/K
constexpr double kBetween = 75.0;  // s, from shot to shot
constexpr int kConfigurations = 60;

double Air(double time) { return 21.0 + 5.0 * (1.0 - std::exp(-time / 2400.0)) + 0.4 * std::sin(time / 700.0); }

// Of an arm that starts at the air's temperature.
double ArmAt(double time, double lag) {
  if (lag <= 0.0) return Air(time);
  double arm = Air(0.0);
  for (double t = 0.0; t < time; t += 1.0) arm += (Air(t + 0.5) - arm) / lag;
  return arm;
}

CalibrationProblem Warming(double lag, bool with_time = true) {
  test::Kr270Design design;
  design.configurations = kConfigurations;
  design.stations = 1;
  design.sigma = kSigma;
  design.seed = 11;
  Measurements data = test::DesignMeasurements(design);
  for (Shot& shot : data.shots) {
    shot.has_time = with_time;
    shot.time = kBetween * (shot.configuration);
    shot.has_temperature = true;
    shot.temperature = Air(shot.time);
  }
  const test::Kr270Truth truth;
  NormalNumbers normal(12);
  const Eigen::Matrix3d rotation = test::BaseRotation(truth, 0);
  for (Observation& row : data.observations) {
    const double grown = 1.0 + kGrowth * (ArmAt(kBetween * data.shots[row.shot].configuration, lag) - 23.5);
    const Vector3<double> in_base =
        test::IndependentKr270Point(data.ConfigurationOf(row).q, truth.errors, truth.tools[row.marker]);
    row.point_in_station = truth.base_xyz[0] + rotation * (grown * in_base) + kSigma * test::RandomVector(normal);
  }
  return test::Kr270ProblemOf(data, Experiment());
}

struct Grown {
  DiagnosedModel model;
  Candidate effect;
  ParameterEstimate before, after;
  std::optional<PossibleNumbers> lag;
};

// settings: of the effect, as a lag of its own.
Grown FitGrowth(const CalibrationProblem& problem, const std::map<std::string, std::string>& settings = {}) {
  Grown grown;
  grown.effect.spec = {"thermal_growth", "robot", settings, {}};
  grown.model = Extend(FitFully(problem, JointOptions()), {grown.effect}, JointOptions());
  grown.model =
      JudgeFully(grown.model.problem, grown.model.estimate.parameters, grown.model.estimate.parameters, JointOptions());
  std::vector<ParameterEstimate> rows;
  for (const ParameterEstimate& row : grown.model.estimate.table) {
    if (IsParameterOf(grown.effect.spec, row.name)) rows.push_back(row);
  }
  grown.before = rows.at(0);
  grown.lag = AllowForSetting(grown.model, grown.effect.spec, &rows);
  grown.after = rows.at(0);
  return grown;
}

bool Holds(const Interval& interval, double value) { return interval.low <= value && value <= interval.high; }

TEST(ThermalLag, AnArmThatIsLateStaysWithinTheIntervalOfItsGrowth) {
  const Grown grown = FitGrowth(Warming(420.0));
  ASSERT_FALSE(Holds(grown.before.ci95, kGrowth)) << grown.before.ci95.low << " " << grown.before.ci95.high;
  EXPECT_TRUE(Holds(grown.after.ci95, kGrowth)) << grown.after.ci95.low << " " << grown.after.ci95.high;
  EXPECT_EQ(grown.after.value, grown.before.value);
  EXPECT_NEAR(grown.after.sigma / grown.before.sigma,
              (grown.after.ci95.high - grown.after.ci95.low) / (grown.before.ci95.high - grown.before.ci95.low), 1e-9);
  ASSERT_TRUE(grown.lag);
  EXPECT_LE(grown.lag->least, 420.0);
  EXPECT_GE(grown.lag->most, 420.0);
}

TEST(ThermalLag, AnArmThatIsNotIsAllowedLittle) {
  const Grown grown = FitGrowth(Warming(0.0));
  ASSERT_TRUE(grown.lag);
  EXPECT_EQ(grown.lag->least, 0.0);
  EXPECT_LE(grown.lag->most, 300.0);
  EXPECT_TRUE(Holds(grown.after.ci95, kGrowth));
}

// An effect with a lag of its own: what is possible counts from the thermometer, not from that lag.
TEST(ThermalLag, AnEffectWithALagOfItsOwn) {
  for (const double lag : {0.0, 420.0}) {
    const Grown grown = FitGrowth(Warming(lag), {{"lag_s", "1200"}});
    EXPECT_FALSE(Holds(grown.before.ci95, kGrowth)) << lag;
    EXPECT_TRUE(Holds(grown.after.ci95, kGrowth))
        << lag << ": " << grown.after.ci95.low << " " << grown.after.ci95.high;
    ASSERT_TRUE(grown.lag);
    EXPECT_LE(grown.lag->least, lag);
    EXPECT_GE(grown.lag->most, lag);
    EXPECT_LT(grown.lag->most, 1200.0);
  }
}

TEST(ThermalLag, WithoutTimeTheOrderOfTheShotsHasToDo) {
  const Grown grown = FitGrowth(Warming(420.0, false));
  ASSERT_TRUE(grown.lag);
  EXPECT_FALSE(grown.lag->is_timed);
  ASSERT_FALSE(Holds(grown.before.ci95, kGrowth));
  EXPECT_TRUE(Holds(grown.after.ci95, kGrowth));
}

TEST(ThermalLag, OnlyWhatTemperatureDrives) {
  Grown grown = FitGrowth(Warming(420.0));
  grown.effect.spec = {"encoder_gain", "A2", {}, {}};
  std::vector<ParameterEstimate> rows = {grown.before};
  EXPECT_FALSE(AllowForSetting(grown.model, grown.effect.spec, &rows));
  EXPECT_EQ(rows[0].ci95.high, grown.before.ci95.high);
}

}  // namespace
}  // namespace sagitta::thermal_lag_test
