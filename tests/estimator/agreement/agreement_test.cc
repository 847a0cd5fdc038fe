// Do parts of the data agree: where the model is right they do, as often as the level says; where it is not they do
// not, by as much as refits of the parts differ.
#include "estimator/agreement/agreement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/least_squares/sandwich.h"
#include "tests/support/agreement.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/noise_experiment.h"

namespace sagitta::agreement_test {
namespace {

using ::testing::HasSubstr;

test::Kr270Design ManyConfigurations() {
  test::Kr270Design design;
  design.configurations = 60;
  design.stations = 1;
  return design;
}

AgreementReport AgreementOf(const CalibrationProblem& problem, Estimate* estimate, int random_halves = 4) {
  *estimate = EstimateWithNoise(problem).estimate;
  EXPECT_TRUE(IsUsable(estimate->status)) << estimate->message;
  CheckAgreement(problem, {1, random_halves}, estimate);
  return estimate->agreement;
}

const PartComparison& SplitOf(const AgreementReport& report, const std::string& key) {
  for (const PartComparison& split : report.splits) {
    if (split.key == key) return split;
  }
  ADD_FAILURE() << "no split by " << key;
  return report.splits.front();
}

// One split of each trial counts: those of one trial share the data.
void ExpectNominal(const std::string& covariance, bool stated, const std::string& key = "A1", int compared = 33) {
  constexpr int kTrials = 60;
  const test::Kr270Truth truth;
  const test::Kr270Design design = ManyConfigurations();
  Measurements data = test::DesignMeasurements(design);
  Experiment experiment;
  experiment.method.covariance = *FindChoice<CovarianceKind>(covariance);
  if (!stated) experiment.method.weights = Weights::kEqual;
  int below_tenth = 0;
  double share = 0.0;
  for (int t = 0; t < kTrials; ++t) {
    test::MeasureKr270(truth, design.sigma, 500 + t, &data);
    Estimate estimate;
    const AgreementReport report = AgreementOf(test::Kr270ProblemOf(data, experiment), &estimate, 0);
    ASSERT_EQ(report.covariance, experiment.method.covariance);
    const PartComparison& split = SplitOf(report, key);
    EXPECT_EQ(split.compared, compared);
    share += split.share() / kTrials;
    below_tenth += split.p_value < 0.1;
  }
  // 33 differences of one trial count as 8: sqrt(0.95 * 0.05 / (8 * 60)) = 1 %.
  EXPECT_NEAR(share, 0.95, 4 * 0.01) << covariance;
  // Hotelling's F is exact for the model's covariance; with the sandwich's 27 degrees of freedom for 33 differences
  // nothing can be tested at once.
  const double chance = covariance == "model" ? 0.1 : 0.0;
  EXPECT_NEAR(below_tenth / static_cast<double>(kTrials), chance, 4 * std::sqrt(0.09 / kTrials)) << covariance;
}

TEST(Agreement, IsNominalWhereTheModelIsRightAndTheNoiseStated) { ExpectNominal("model", true); }
TEST(Agreement, IsNominalWhereTheModelIsRightAndTheNoiseEstimated) { ExpectNominal("model", false); }
TEST(Agreement, IsNominalWithTheSandwich) { ExpectNominal("sandwich", true); }
// One marker determines no rotation of the last axis: what the others hold apart is held in both.
TEST(Agreement, IsNominalBetweenMarkers) { ExpectNominal("model", true, "P1 and the others", 24); }
TEST(Agreement, IsNominalBetweenMarkersWhereTheNoiseIsEstimated) {
  ExpectNominal("model", false, "P1 and the others", 24);
}

// Joints that arrive 40 times as far off as the tracker reads, which nothing states: the markers of one arrival share
// that, and do not contradict each other more often than the level says.
TEST(Agreement, WhatMarkersShareIsNoContradiction) {
  const test::Kr270Truth truth;
  test::RepeatDesign design;
  design.configurations = 60;
  design.repeats = 1;
  Measurements data = test::RepeatRows(design);
  int contradictions = 0;
  constexpr int kTrials = 20;
  for (int t = 0; t < kTrials; ++t) {
    test::MeasureRepeated(truth, design, 900 + t, &data);
    Estimate estimate;
    const AgreementReport report = AgreementOf(test::Kr270ProblemOf(data, Experiment()), &estimate, 0);
    for (const char* marker : {"P1", "P2", "P3"})
      contradictions += SplitOf(report, std::string(marker) + " and the others").p_value < 0.1;
  }
  EXPECT_LE(contradictions, 0.1 * 3 * kTrials);
}

// The mount of a marker gives way along the flange's own gravity: the same in every half of the workspace.
TEST(Agreement, SeesAMarkerWhoseMountGivesWay) {
  const test::Kr270Truth truth;
  test::Kr270Design design = ManyConfigurations();
  design.sigma = 4e-5;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, design.sigma, 5, &data);
  for (Observation& observation : data.observations) {
    const Eigen::VectorXd& q = data.ConfigurationOf(observation).q;
    const double down = std::sin(q[1] + q[2]) * std::cos(q[4]);  // how the flange lies, roughly
    if (observation.marker == 0) observation.point_in_station.z() -= 6e-4 * down;
  }
  Estimate estimate;
  const AgreementReport report = AgreementOf(test::Kr270ProblemOf(data, Experiment()), &estimate);
  EXPECT_TRUE(report.disagrees);
  EXPECT_LT(SplitOf(report, "P1 and the others").p_value, 1e-4);
  EXPECT_THAT(report.words.back(), HasSubstr("P1 and the others"));
  const BetweenParts between = CheckAgreement(test::Kr270ProblemOf(data, Experiment()), {1, 0}, &estimate);
  ASSERT_EQ(between.covariance.rows(), estimate.covariance.rows());  // predictions carry it
  EXPECT_GT(between.covariance.diagonal().maxCoeff(), 0.0);
}

// A once-per-turn error of axis 3 that the model does not have.
struct Misfit {
  test::Kr270Truth truth;
  CalibrationProblem problem;

  Misfit() : problem(Make(truth)) {}
  static CalibrationProblem Make(const test::Kr270Truth& truth) {
    const test::Kr270Design design = ManyConfigurations();
    Measurements data = test::DesignMeasurements(design);
    const std::vector<Configuration> commanded = data.configurations;
    for (Configuration& c : data.configurations) c.q[2] += 400e-6 * std::cos(2.0 * c.q[2]);
    test::MeasureKr270(truth, design.sigma, 7, &data);
    data.configurations = commanded;
    return test::Kr270ProblemOf(data, Experiment());
  }
};

TEST(Agreement, SeesWhatTheModelLacksAndByHowMuch) {
  const Misfit misfit;
  Estimate estimate;
  const AgreementReport report = AgreementOf(misfit.problem, &estimate);
  EXPECT_TRUE(report.disagrees);
  EXPECT_GT(report.inflation, 1.2);
  EXPECT_LT(SplitOf(report, "A3").p_value, 1e-6);
  const BetweenParts between = CheckAgreement(misfit.problem, {1, 0}, &estimate);
  ASSERT_EQ(between.variance.size(), estimate.covariance.rows());
  const int at = estimate.parameters.FindCoordinate("geometry/dq3");
  const auto p = std::find(estimate.estimated.begin(), estimate.estimated.end(), at) - estimate.estimated.begin();
  ASSERT_LT(p, between.variance.size());
  EXPECT_GT(between.variance[p], estimate.covariance(p, p));  // where the error is, more than noise
  EXPECT_THAT(report.words.back(), HasSubstr("contradict each other"));
  // The same halves refitted from scratch, by another route to the same figure.
  std::vector<double> q3;
  for (const Configuration& c : misfit.problem.data().configurations) q3.push_back(c.q[2]);
  std::nth_element(q3.begin(), q3.begin() + q3.size() / 2, q3.end());
  const double median = q3[q3.size() / 2];
  const auto half = [&](bool below) {
    return test::EstimatePart(misfit.problem, estimate.parameters, [&](const Observation& observation) {
      return (misfit.problem.data().ConfigurationOf(observation).q[2] < median) == below;
    });
  };
  test::Agreement refits;
  test::Compare(half(true), half(false), "", &refits);
  const PartComparison& split = SplitOf(report, "A3");
  ASSERT_EQ(split.compared, refits.compared);
  EXPECT_NEAR(split.inflation / refits.Inflation(), 1.0, 0.02);
  EXPECT_LE(std::abs(split.inside - refits.inside), 1);
}

TEST(Agreement, SmallDataSetsSayThatTheyAreTooSmall) {
  const test::Kr270Truth truth;
  test::Kr270Design design;
  design.configurations = 8;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, design.sigma, 3, &data);
  Estimate estimate;
  const AgreementReport report = AgreementOf(test::Kr270ProblemOf(data, Experiment()), &estimate);
  EXPECT_FALSE(report.known);
  EXPECT_FALSE(CheckAgreement(test::Kr270ProblemOf(data, Experiment()), {1, 0}, &estimate).known());
  EXPECT_FALSE(report.disagrees);
  EXPECT_THAT(report.words.back(), HasSubstr("Too few"));
}

// Repeats that share the arrival's joint deviations: F about 1 + 9 (60 um / 10 um)^2 where each configuration has
// 9 degrees of freedom and 3.8 of them hold the deviations of six joints.
TEST(Agreement, RepeatsOfOneArrivalAreNotIndependent) {
  const test::Kr270Truth truth;
  test::RepeatDesign design;
  Measurements data = test::RepeatRows(design);
  test::MeasureRepeated(truth, design, 11, &data);
  Estimate estimate;
  const AgreementReport independent = AgreementOf(test::Kr270ProblemOf(data, Experiment()), &estimate);
  ASSERT_TRUE(independent.repeats.known);
  EXPECT_EQ(independent.repeats.between_dof, 18 * 9 - 33);
  EXPECT_EQ(independent.repeats.within_dof, 18 * 9 * 8);
  EXPECT_GT(independent.repeats.ratio, 50.0);
  EXPECT_LT(independent.repeats.p_value, 1e-10);
  EXPECT_TRUE(independent.sandwich_advised);
  EXPECT_THAT(independent.words.front(), HasSubstr("repeatability_urad: estimate"));
  Experiment stated;
  stated.repeatability.angle.common = design.joint;
  const AgreementReport latent = AgreementOf(test::Kr270ProblemOf(data, stated), &estimate);
  ASSERT_TRUE(latent.repeats.known);
  // F with 129 and 1296 degrees of freedom: standard deviation 13 %.
  EXPECT_NEAR(latent.repeats.ratio, 1.0, 4 * 0.13);
  EXPECT_FALSE(latent.sandwich_advised);
}

// Two stations that see every pose; the second one's scale is 200 ppm off about its instrument.
TEST(Agreement, StationsOfTheSamePosesAreCompared) {
  const test::Kr270Truth truth;
  test::Kr270Design design = ManyConfigurations();
  design.sigma = 4e-5;
  Measurements data = test::SeenFromBothStations(design);
  for (const double scale : {0.0, 2e-4}) {
    test::MeasureKr270(truth, design.sigma, 5, &data);
    for (Observation& observation : data.observations) {
      if (data.shots[observation.shot].station == 1) observation.point_in_station *= 1.0 + scale;
    }
    Estimate estimate;
    const AgreementReport report = AgreementOf(test::Kr270ProblemOf(data, Experiment()), &estimate);
    EXPECT_EQ(report.disagrees, scale > 0.0);
    EXPECT_EQ(SplitOf(report, "S1 and S2").p_value<1e-4, scale> 0.0);
  }
}

// Two loads under which every pose is measured; one of them weighs 6 % more than is stated.
TEST(Agreement, LoadsAreCompared) {
  test::LoadedTruth truth;
  truth.loads["V150"] = {{0, 0, -150 * 9.80665}};
  test::LoadedDesign design;
  design.configurations = 30;
  design.stations = 1;
  design.loads = {"V150", "V250"};
  const Measurements rows = test::LoadedRows(design, truth);
  for (const double more : {0.0, 0.06}) {
    test::LoadedTruth heavier = truth;
    heavier.loads["V150"].force *= 1.0 + more;
    Measurements data = rows;
    test::Measure(test::ExactPoints(heavier, data), design.sigma, 7, &data);
    const test::LoadedSetup setup = test::SetupFor(truth);
    Estimate estimate;
    const AgreementReport report = AgreementOf(MakeCalibrationProblem(setup.robot, data, setup.experiment), &estimate);
    EXPECT_EQ(report.disagrees, more > 0.0);
    EXPECT_EQ(SplitOf(report, "V150 and the others").p_value<1e-4, more> 0.0);
  }
}

}  // namespace
}  // namespace sagitta::agreement_test
