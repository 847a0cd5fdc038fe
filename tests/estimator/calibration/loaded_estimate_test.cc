// Geometry, compliances and gravity compensator in one solve, against the
// generator of tests/support/loaded_kr270.h.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "estimator/baselines/compare_methods.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/paths.h"

namespace sagitta::loaded_estimate_test {
namespace {

using test::LoadedDesign;
using test::LoadedTruth;
using ::testing::AllOf;
using ::testing::HasSubstr;

LoadedTruth WithoutSpring() {
  LoadedTruth truth = test::Everything();
  truth.spring.reset();
  truth.link_markers.clear();
  return truth;
}

struct Simulated {
  Simulated(const LoadedTruth& truth_in, const LoadedDesign& design_in, const test::LoadedSetup& setup)
      : truth(truth_in), design(design_in), exact(), problem(Make(setup)) {}
  Simulated(const LoadedTruth& truth_in, const LoadedDesign& design_in)
      : Simulated(truth_in, design_in, test::SetupFor(truth_in)) {}

  CalibrationProblem Make(const test::LoadedSetup& setup) {
    Measurements data = test::LoadedRows(design, truth);
    exact = test::ExactPoints(truth, data);
    test::Measure(exact, 0.0, 1, &data);
    return MakeCalibrationProblem(setup.robot, data, setup.experiment);
  }
  Estimate Solve(std::uint64_t seed) {
    test::Measure(exact, design.sigma, seed, problem.mutable_data());
    return EstimateJointly(problem);
  }
  Estimate SolveExact() {
    test::Measure(exact, 0.0, 1, problem.mutable_data());
    return EstimateJointly(problem);
  }

  LoadedTruth truth;
  LoadedDesign design;
  std::vector<Vector3<double>> exact;
  CalibrationProblem problem;
};

const ParameterEstimate& Row(const Estimate& estimate, const std::string& name) {
  return estimate.table.at(estimate.parameters.FindCoordinate(name));
}

void ExpectTruth(const Estimate& estimate, const LoadedTruth& truth) {
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  for (const int i : estimate.estimated) {
    const ParameterEstimate& row = estimate.table[i];
    const double size = std::max(std::abs(row.value), TraitsOf(row.quantity).si_per_unit);
    EXPECT_LT(std::abs(test::ErrorOf(estimate, truth, i)), 1e-9 * size) << row.name;
  }
}

void ExpectWithinCovariance(const Estimate& estimate, const LoadedTruth& truth) {
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  EXPECT_GT(ChiSquareSurvival(test::SquaredDistanceToTruth(estimate, truth), estimate.estimated.size()), 1e-5);
  EXPECT_GT(estimate.sigma.p_value, 1e-5);
}

TEST(LoadedEstimate, RecoversExactDataToRoundOff) {
  Simulated data(test::Everything(), test::WithPulls());
  const Estimate estimate = data.SolveExact();
  EXPECT_EQ(estimate.estimated.size(), 55u);
  ExpectTruth(estimate, data.truth);
}

TEST(LoadedEstimate, RecoversEverythingWithinItsCovariance) {
  Simulated data(test::Everything(), test::WithPulls());
  for (int seed = 1; seed <= 20; ++seed) ExpectWithinCovariance(data.Solve(seed), data.truth);
}

TEST(LoadedEstimate, TwoStepReachesTheJointOptimum) {
  test::LoadedSetup setup = test::SetupFor(test::Everything());
  setup.experiment.priors["compliance/A6"] = {2.2, 0.1};
  Simulated data(test::Everything(), test::WithPulls(), setup);
  const Estimate joint = data.Solve(3);
  ASSERT_EQ(joint.status, Status::kConverged) << joint.message;
  const MethodResult two_step = RunMethod(data.problem, Method::kTwoStep, joint);
  EXPECT_EQ(two_step.estimate.estimated, joint.estimated);
  EXPECT_LT(two_step.max_deviation_sigma, 1e-6);
  EXPECT_NEAR(two_step.rate_measured, two_step.rate_predicted, 2e-3);
}

struct Variant {
  std::string name;
  std::function<void(LoadedTruth*, LoadedDesign*)> change;
};
void PrintTo(const Variant& variant, std::ostream* stream) { *stream << variant.name; }

std::vector<Variant> Variants() {
  return {
      {"Plain", [](LoadedTruth*, LoadedDesign*) {}},
      {"Coupling", [](LoadedTruth* t, LoadedDesign*) { t->coupling = 1.0; }},
      {"ToolWeight", [](LoadedTruth* t, LoadedDesign*) { t->tool_mass = 80.0; }},
      {"SeveralLoadsWithTheirPoints",
       [](LoadedTruth* t, LoadedDesign* d) {
         t->loads["V100"] = {{0, 0, -1000}, {0, 0, 0}, {0.1, -0.3, 0.2}};
         d->loads.push_back("V100");
       }},
      {"FlangeFrame", [](LoadedTruth* t, LoadedDesign*) { t->loads["V250"].frame = WrenchFrame::kFlange; }},
      {"BaseFrame", [](LoadedTruth* t, LoadedDesign*) { t->loads["V250"].frame = WrenchFrame::kBase; }},
      {"Moment",
       [](LoadedTruth* t, LoadedDesign*) {
         t->loads["V250"].moment = {300, -200, 500};
       }},
      {"SpringWithoutPreload",
       [](LoadedTruth* t, LoadedDesign* d) {
         t->spring = test::SpringTruth();
         t->spring->preload = false;
         d->sigma = 1e-6;  // its stiffness alone determines little
       }},
  };
}

class LoadVariantTest : public ::testing::TestWithParam<Variant> {};

TEST_P(LoadVariantTest, IsRecovered) {
  LoadedTruth truth = WithoutSpring();
  LoadedDesign design = test::WithPulls();
  GetParam().change(&truth, &design);
  Simulated data(truth, design);
  ExpectTruth(data.SolveExact(), truth);
  for (int seed = 1; seed <= 3; ++seed) ExpectWithinCovariance(data.Solve(seed), truth);
}

INSTANTIATE_TEST_SUITE_P(Kr270, LoadVariantTest, ::testing::ValuesIn(Variants()),
                         [](const auto& param_info) { return param_info.param.name; });

// The one direction that is held, and its words.
void ExpectHeld(const Estimate& estimate, const std::string& name, const std::string& remedy) {
  ASSERT_EQ(estimate.status, Status::kConvergedWithHeldParameters) << estimate.message;
  ASSERT_EQ(estimate.identifiability.unidentifiable.size(), 1u);
  const Direction& direction = estimate.identifiability.unidentifiable[0];
  EXPECT_FALSE(Row(estimate, name).identifiable);
  EXPECT_THAT(direction.words, HasSubstr(name));
  EXPECT_THAT(direction.remedy, HasSubstr(remedy));
}

TEST(LoadedEstimate, TheSpringsScaleGaugeHoldsLWithWords) {
  const LoadedTruth truth = test::Everything();
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.experiment.estimate.gravity_compensator = {Selection::Kind::kAll, {}};
  Simulated data(truth, test::WithPulls(), setup);
  const Estimate estimate = data.Solve(5);
  ExpectHeld(estimate, "compensator/L", "measure L with markers on the links, or hold it");
  const auto& components = estimate.identifiability.unidentifiable[0].components;
  std::vector<std::string> names;
  for (const auto& [name, value] : components) names.push_back(name);
  EXPECT_THAT(names, ::testing::UnorderedElementsAre("compensator/L", "compensator/a_x", "compensator/a_y",
                                                     "compensator/s0", "compensator/Kc"));
  EXPECT_EQ(Row(estimate, "compensator/L").value, truth.spring->L);
  EXPECT_GT(ChiSquareSurvival(test::SquaredDistanceToTruth(estimate, truth), estimate.estimated.size()), 1e-5);
}

// Where the file is off, all of the triangle scales with the length that the file has.
TEST(LoadedEstimate, ASpringsLengthRestsAsStated) {
  const LoadedTruth truth = test::Everything();
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.experiment.estimate.gravity_compensator = {Selection::Kind::kAll, {}};
  setup.robot.gravity_compensator->L *= 1.01;
  setup.robot.gravity_compensator->s0 *= 0.99;
  const Estimate estimate = Simulated(truth, test::WithPulls(), setup).Solve(5);
  EXPECT_EQ(Row(estimate, "compensator/L").value, setup.robot.gravity_compensator->L);
}

// Torques alone hardly determine a spring's shape. Held where it is stated, what is estimated along would be as certain
// as if that were exact.
TEST(LoadedEstimate, ASpringThatIsHardlyKnownIsAsUncertainAsItsPriorsSay) {
  LoadedTruth truth = test::Everything();
  truth.link_markers.clear();
  LoadedDesign design = test::WithPulls();
  design.sigma = 5e-4;
  test::LoadedSetup setup = test::SetupFor(truth);
  const Estimate held = Simulated(truth, design, setup).Solve(5);
  ASSERT_FALSE(Row(held, "compensator/a_x").free && Row(held, "compensator/a_y").free);
  setup.robot.gravity_compensator->prior_sigmas = {0.0, 0.3, 0.3, 0.25, 0.0};
  Simulated data(truth, design, setup);
  const Estimate estimate = data.Solve(5);
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  for (const char* name : {"compensator/a_x", "compensator/a_y", "compensator/s0"}) {
    const ParameterEstimate& part = Row(estimate, name);
    ASSERT_TRUE(part.free) << name;
    EXPECT_NEAR(part.value, test::TrueLoadedValue(truth, name), 3.0 * part.sigma) << name;
    EXPECT_GT(part.sigma, Row(held, name).free ? Row(held, name).sigma : 4e-3) << name;
  }
  const Robot calibrated = data.problem.RobotWith(estimate.parameters);
  EXPECT_EQ(calibrated.gravity_compensator->prior_sigmas, setup.robot.gravity_compensator->prior_sigmas);
}

TEST(LoadedEstimate, VerticalLoadOnVerticalAxisHoldsK1) {
  LoadedTruth truth = WithoutSpring();
  truth.base_rotvec = {{0, 0, 0.3}, {0, 0, -1.0}};
  LoadedDesign design;  // no pulls
  Simulated data(truth, design);
  const Estimate estimate = data.Solve(1);
  ExpectHeld(estimate, "compliance/A1", "pull sideways with 500 N in three configurations, e.g. C");
  EXPECT_EQ(Row(estimate, "compliance/A1").value, 0.0);
  EXPECT_NEAR(Row(estimate, "compliance/A2").value, truth.k[1], 5 * Row(estimate, "compliance/A2").sigma);
}

TEST(LoadedEstimate, LoadOnAxisSixHoldsK6) {
  LoadedTruth truth = WithoutSpring();
  truth.loads["V250"].point = {0.28, 0, 0};
  Simulated data(truth, LoadedDesign());
  ExpectHeld(data.Solve(1), "compliance/A6", "off the axis");
}

TEST(LoadedEstimate, CompliancesStayPositiveAndTheirIntervalsSayWhereTheyEnd) {
  LoadedTruth truth = WithoutSpring();
  truth.k[5] = 0.0;
  Simulated data(truth, test::WithPulls());
  int at_zero = 0;
  constexpr int kSeeds = 12;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Estimate estimate = data.Solve(seed);
    ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
    const ParameterEstimate& k6 = Row(estimate, "compliance/A6");
    EXPECT_GE(k6.value, 0.0);
    EXPECT_EQ(k6.ci95.low, 0.0);
    EXPECT_TRUE(k6.at_bound);
    EXPECT_FALSE(Row(estimate, "compliance/A2").at_bound);
    at_zero += k6.value == 0.0;
    EXPECT_NEAR(Row(estimate, "compliance/A5").value, truth.k[4], 5 * Row(estimate, "compliance/A5").sigma);
  }
  EXPECT_GT(at_zero, 0);  // half of them would be negative
  EXPECT_LT(at_zero, kSeeds);
}

// A linear model's posterior: x + C e d / (s^2 + C_ee), C - C e e'C / (s^2 + C_ee).
TEST(LoadedEstimate, PriorsPullAsTheClosedFormSays) {
  const LoadedTruth truth = WithoutSpring();
  Simulated plain(truth, test::WithPulls());
  const Estimate without = plain.Solve(2);
  ASSERT_EQ(without.status, Status::kConverged) << without.message;
  const int k6 = without.parameters.FindCoordinate("compliance/A6");
  const int c = std::find(without.estimated.begin(), without.estimated.end(), k6) - without.estimated.begin();
  const double sigma = without.table[k6].sigma;
  for (const double share : {1e-4, 0.5, 3.0}) {
    const double prior_sigma = share * sigma;
    const double shift = -0.8 * sigma;
    test::LoadedSetup setup = test::SetupFor(truth);
    setup.experiment.priors["compliance/A6"] = {(without.table[k6].value + shift) / 1e-6, prior_sigma / 1e-6};
    Simulated data(truth, test::WithPulls(), setup);
    const Estimate with = data.Solve(2);
    ASSERT_EQ(with.status, Status::kConverged) << with.message;
    const Eigen::VectorXd column = without.covariance.col(c);
    const double denominator = prior_sigma * prior_sigma + column[c];
    const Eigen::VectorXd moved = TangentDifference(with.parameters, without.parameters);
    for (int i = 0; i < column.size(); ++i) {
      const ParameterEstimate& before = without.table[without.estimated[i]];
      const ParameterEstimate& after = with.table[with.estimated[i]];
      const double variance = before.sigma * before.sigma - column[i] * column[i] / denominator;
      EXPECT_NEAR(moved[with.estimated[i]], column[i] * shift / denominator, 2e-3 * before.sigma) << after.name;
      EXPECT_NEAR(after.sigma, std::sqrt(variance), 2e-3 * before.sigma) << after.name << " " << share;
    }
  }
}

// The 15 configurations of paper 000, Table II.
void AsPublished(std::vector<Configuration>* configurations) {
  std::ifstream file(test::SourceFolder() + "/problems/published/kr270/elastostatic_configurations.csv");
  std::string line, cell;
  std::map<std::string, int> seen;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::getline(cells, cell, ',');
    if (cell[0] != 'E' || !seen.emplace(cell, seen.size()).second) continue;
    Configuration& configuration = configurations->at(seen[cell]);
    for (int skipped = 0; skipped < 2; ++skipped) std::getline(cells, cell, ',');
    for (int j = 0; j < 6 && std::getline(cells, cell, ','); ++j) configuration.q[j] = std::stod(cell) * kDegree;
  }
  EXPECT_EQ(seen.size(), 15u);
}

// Paper 002's own limitation: no k1, on a base tilted by 52.8 mrad (paper 000, Table III).
TEST(LoadedEstimate, LeavingOutK1OnATiltedBaseLeavesASidewaysResidual) {
  LoadedTruth truth = WithoutSpring();
  truth.base_rotvec = {{52.8e-3, 2.2e-3, -15.6e-3}};
  truth.base_xyz = {{-34.4e-3, -31.9e-3, -97.8e-3}};
  LoadedDesign design;
  design.stations = 1;
  design.configurations = 15;
  design.change = AsPublished;
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.experiment.estimate.compliance = {Selection::Kind::kList, {"A2", "A3", "A4", "A5", "A6"}};
  Simulated without(truth, design, setup);
  const Estimate left = without.SolveExact();
  const ResidualSize& d = left.deflection_after;
  // 0.12 mm per axis, 0.17 mm as horizontal distance; PUBLISHED.md: 0.14.
  const double sideways = std::hypot(d.rms_axis.x(), d.rms_axis.y());
  EXPECT_NEAR(sideways, 0.17e-3, 0.01e-3);
  EXPECT_NEAR(sideways / std::sqrt(2.0), 0.12e-3, 0.01e-3);
  EXPECT_LT(d.rms_axis.z(), 0.2 * sideways);
  Simulated with(truth, design);
  EXPECT_LT(with.SolveExact().deflection_after.rms, 1e-9);
}

}  // namespace
}  // namespace sagitta::loaded_estimate_test
