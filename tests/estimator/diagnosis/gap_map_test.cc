// The gap in joint space against deviations put into the measured points by the independent kinematics of
// tests/support, and the torques it is drawn over against virtual work.
#include "estimator/diagnosis/gap_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/loaded_kr270.h"

namespace sagitta::gap_map_test {
namespace {

constexpr double kSigma = 1e-7;        // m; with it the fit finds the truth to a few of these
constexpr double kAmplitude = 200e-6;  // rad
constexpr double kTolerated = 1.0;     // urad; second order of kAmplitude and the fit's noise
constexpr int kA4 = 3, kA6 = 5;

test::Kr270Design OneStation() {
  test::Kr270Design design;
  design.configurations = 30;
  design.stations = 1;
  design.sigma = kSigma;
  design.seed = 5;
  return design;
}

DiagnosedModel Healthy(const test::Kr270Truth& truth = test::Kr270Truth()) {
  return FitFully(test::Kr270Problem(OneStation(), truth, 6), JointOptions());
}

double Harmonic(double q) { return kAmplitude * std::sin(3 * q); }

// The fit of healthy rows, and then rows of an arm whose A4 turns a harmonic further than commanded.
DiagnosedModel WithHarmonicOfA4() {
  DiagnosedModel model = Healthy();
  auto problem = std::make_shared<CalibrationProblem>(*model.problem);
  for (Observation& row : problem->mutable_data()->observations) {
    Eigen::VectorXd q = problem->data().ConfigurationOf(row).q;
    q[kA4] += Harmonic(q[kA4]);
    row.point_in_station = test::ExactPoint(test::Kr270Truth(), q, row.marker, 0);
  }
  model.problem = problem;
  return model;
}

const JointGap* GapOf(const std::vector<JointGap>& gaps, const std::string& joint) {
  for (const JointGap& gap : gaps) {
    if (gap.joint == joint) return &gap;
  }
  return nullptr;
}

TEST(GapMap, ReturnsADeviationOfOneJointShotByShot) {
  const DiagnosedModel model = WithHarmonicOfA4();
  const std::vector<JointGap> gaps = MapGap(model, model);
  ASSERT_EQ(gaps.size(), 6u);
  const JointGap& a4 = *GapOf(gaps, "A4");
  EXPECT_EQ(a4.unit, "urad");
  ASSERT_EQ(a4.shots.size(), 30u);
  for (size_t i = 0; i < a4.shots.size(); ++i) {
    const double q =
        model.problem->data().configurations[model.problem->data().shots[a4.shots[i]].configuration].q[kA4];
    EXPECT_NEAR(a4.before[i], 1e6 * Harmonic(q), kTolerated);
    EXPECT_EQ(a4.after[i], a4.before[i]);
  }
}

TEST(GapMap, IsDrawnOverWhatVaries) {
  DiagnosedModel model = Healthy();
  const auto names = [&] {
    std::vector<std::string> found;
    const std::vector<JointGap> gaps = MapGap(model, model);
    for (const Driver& driver : GapOf(gaps, "A4")->over) found.push_back(driver.name);
    return found;
  };
  EXPECT_EQ(names(), std::vector<std::string>{"A4"});  // no loads, no time, no directions
  auto problem = std::make_shared<CalibrationProblem>(*model.problem);
  for (size_t s = 0; s < problem->shot_inputs().size(); ++s) {
    ShotConditions& conditions = (*problem->mutable_shot_inputs())[s].conditions;
    conditions.has_time = true;
    conditions.time = 60.0 * static_cast<double>(s);
    conditions.approach = {1, 1, 1, s % 2 == 0 ? 1 : -1, 1, 1};
  }
  model.problem = problem;
  EXPECT_EQ(names(), (std::vector<std::string>{"A4", "approach of A4", "time"}));
}

// Markers on the axis of A6 do not see it turn; where the fit puts them next to it by rounding and noise, they would
// draw thousands of radians.
TEST(GapMap, LeavesOutAJointThatNoMarkerSees) {
  test::Kr270Truth on_axis;
  on_axis.tools = {{0.1, 0.0, 0.0}, {0.25, 0.0, 0.0}, {0.4, 0.0, 0.0}};
  const DiagnosedModel model = Healthy(on_axis);
  const std::vector<JointGap> gaps = MapGap(model, model);
  EXPECT_EQ(gaps.size(), 5u);
  EXPECT_EQ(GapOf(gaps, "A6"), nullptr);
}

// The chi-square of rows that state no sigma counts that of the fit with all that was found.
TEST(GapMap, WhereTheMisfitIsDoesNotDependOnWhoStatesTheNoise) {
  DiagnosedModel stated = WithHarmonicOfA4(), unstated = stated;
  auto problem = std::make_shared<CalibrationProblem>(*stated.problem);
  for (Observation& row : problem->mutable_data()->observations) row.sigma.setZero();
  unstated.problem = problem;
  const std::vector<WhereShare> expected = FindWhere(stated, 1.0), found = FindWhere(unstated, kSigma);
  EXPECT_FALSE(expected.empty());
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].by + found[i].key, expected[i].by + expected[i].key);
    EXPECT_NEAR(found[i].share, expected[i].share, 1e-9);
  }
}

// Torque on a joint: what the load's force works per radian, by central differences of its point.
TEST(Drivers, TorqueIsTheWorkOfTheLoadPerRadian) {
  test::LoadedTruth truth;
  truth.errors.fill(0.0);
  test::LoadedDesign design;
  design.stations = 1;
  Measurements data = test::LoadedRows(design, truth);
  const test::LoadedSetup setup = test::SetupFor(truth);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  const Eigen::MatrixXd torques = JointTorques(problem, problem.parameters);
  const test::LoadTruth& load = truth.loads.at("V250");
  const auto work_at = [&](const Eigen::VectorXd& q) {
    std::array<double, 6> v{};
    for (int j = 0; j < 6; ++j) v[j] = q[j];
    const test::ArmState arm = test::StateOfArm(v, truth.errors);
    return load.force.dot(arm.flange_origin + arm.flange * load.point);
  };
  constexpr double kStep = 1e-4;  // rad: differences off by kStep^2 / 6 of 10 kN m, rounding far less
  for (long s = 0; s < torques.rows(); ++s) {
    const Shot& shot = problem.data().shots[s];
    const Driver on_a6 = TorqueOf(problem, kA6, torques);
    EXPECT_EQ(on_a6.of_shot[s], torques(s, kA6));
    for (int j = 0; j < 6; ++j) {
      Eigen::VectorXd ahead = problem.data().configurations[shot.configuration].q, behind = ahead;
      ahead[j] += kStep;
      behind[j] -= kStep;
      const double expected = shot.load == "none" ? 0.0 : (work_at(ahead) - work_at(behind)) / (2 * kStep);
      EXPECT_NEAR(torques(s, j), expected, 1e-4) << "shot " << s << ", joint " << j + 1;
    }
  }
}

}  // namespace
}  // namespace sagitta::gap_map_test
