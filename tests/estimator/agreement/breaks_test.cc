// What moved for good while the points were measured: made by a generator of its own
// (tests/support/kr270_experiment.h).
#include "estimator/agreement/breaks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/diagnosis/cautions.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/statistics/distributions.h"
#include "estimator/validation/trust.h"
#include "tests/support/judged.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::breaks_test {
namespace {

using test::Kr270Truth;
using ::testing::HasSubstr;

constexpr int kConfigurations = 60, kAt = 36;

// One station; from configuration kAt on the world is `after`.
CalibrationProblem Measured(const Kr270Truth& after, std::uint64_t seed = 1) {
  test::Kr270Design design;
  design.configurations = kConfigurations;
  design.stations = 1;
  design.seed = seed;
  design.sigma = 5e-5;
  Measurements data = test::DesignMeasurements(design), later = data;
  test::MeasureKr270(Kr270Truth(), design.sigma, 500 + seed, &data);
  test::MeasureKr270(after, design.sigma, 900 + seed, &later);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    if (data.shots[data.observations[i].shot].configuration >= kAt) data.observations[i] = later.observations[i];
  }
  return test::Kr270ProblemOf(data, Experiment());
}

void ExpectBreak(const CalibrationProblem& problem, BreakOf of, int index, double moved) {
  Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status));
  const std::optional<Break> found = FindBreak(problem, estimate);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->of, of);
  EXPECT_EQ(found->index, index);
  const auto configuration = [&](int i) {
    return problem.data().shots[problem.data().observations[i].shot].configuration;
  };
  EXPECT_EQ(configuration(found->last), kAt - 1);
  EXPECT_EQ(configuration(found->first), kAt);
  EXPECT_NEAR(found->moved / moved, 1.0, 0.15);
  EXPECT_LT(found->p_value, 1e-6);
  const Trust trust = test::JudgeTrust(problem, 1, &estimate);
  EXPECT_FALSE(trust.verdict.trusted);
  EXPECT_THAT(trust.verdict.words, HasSubstr(problem.data().SourceOf(problem.data().observations[found->first])));
}

// The reasons against rest on rows that are held out at random: these have moved too.
TEST(Breaks, AStationThatMovedIsNamedWithItsRows) {
  Kr270Truth after;
  after.base_xyz[0] += Vector3<double>(0.3e-3, 0.0, -0.4e-3);
  ExpectBreak(Measured(after), BreakOf::kStation, 0, 0.5e-3);
}

TEST(Breaks, AMarkerThatWasSeatedAnewIsNamed) {
  Kr270Truth after;
  after.tools[1] += Vector3<double>(0.0, 0.6e-3, 0.0);
  ExpectBreak(Measured(after), BreakOf::kMarker, 1, 0.6e-3);
}

// One body: all markers by one motion, here a shift of 0.3 mm and a turn of 12 mrad about the flange's x.
TEST(Breaks, AToolThatWasExchangedIsNamed) {
  Kr270Truth after;
  double squares = 0.0;
  for (Vector3<double>& marker : after.tools) {
    const Vector3<double> moved(0.0, 3e-4 - 12e-3 * marker.z(), 12e-3 * marker.y());
    marker += moved;
    squares += moved.squaredNorm() / 3.0;
  }
  ExpectBreak(Measured(after), BreakOf::kTool, 0, std::sqrt(squares));
  const CalibrationProblem problem = Measured(after);
  const std::optional<Break> found = FindBreak(problem, EstimateJointly(problem));
  ASSERT_TRUE(found);
  EXPECT_GT(found->share, 0.98);  // what is left is the readings' noise
  const std::vector<std::string> cautions = FindCautions(problem, FitFully(problem, JointOptions()));
  EXPECT_THAT(cautions, ::testing::Contains(HasSubstr("the tool with all markers moved")));
}

TEST(Breaks, AJointWhoseZeroJumpedIsNamed) {
  Kr270Truth after;
  after.errors[7] += 0.5e-3;  // dq3; the markers are about 1.5 m from the axis
  const CalibrationProblem problem = Measured(after);
  double squares = 0.0;
  int rows = 0;
  for (const Observation& row : problem.data().observations) {
    if (problem.data().shots[row.shot].configuration < kAt) continue;
    squares += (test::ExactPoint(after, problem.data(), row) - test::ExactPoint(Kr270Truth(), problem.data(), row))
                   .squaredNorm();
    ++rows;
  }
  ExpectBreak(problem, BreakOf::kJoint, 2, std::sqrt(squares / rows));
}

// At significance 0.01, of 20 more than two are one in a thousand.
TEST(Breaks, NothingIsFoundWhereNothingMoved) {
  int found = 0;
  for (std::uint64_t seed = 40; seed < 60; ++seed) {
    const CalibrationProblem problem = Measured(Kr270Truth(), seed);
    found += FindBreak(problem, EstimateJointly(problem)).has_value();
  }
  EXPECT_LE(found, 2);
}

// Geometry that is believed although it is wrong is wrong all the time.
TEST(Breaks, AnErrorThatIsNotEstimatedIsNone) {
  int found = 0;
  for (std::uint64_t seed = 60; seed < 90; ++seed) {
    test::Kr270Design design;
    design.configurations = 45;
    design.stations = 1;
    design.seed = seed;
    design.sigma = 2e-5;
    Measurements data = test::DesignMeasurements(design);
    Kr270Truth truth;
    NormalNumbers normal(700 + seed);
    for (double& error : truth.errors) error = 5e-4 * normal();  // m or rad
    test::MeasureKr270(truth, design.sigma, 500 + seed, &data);
    Experiment experiment;
    experiment.estimate.geometry.kind = Selection::Kind::kNone;
    const CalibrationProblem problem = test::Kr270ProblemOf(data, experiment);
    found += FindBreak(problem, EstimateJointly(problem)).has_value();
  }
  EXPECT_LE(found, 2);  // at significance 0.01, of 30 more than two are one in three hundred
}

// Share of the squared residuals that a step of the only station explains from configuration `at` on: two dense least
// squares, all columns at once.
double ShareOfStep(const Linearization& rows, const Measurements& data, const std::vector<int>& station, int at) {
  const Eigen::Index known = rows.num_columns();
  const Eigen::MatrixXd& own = rows.jacobian;
  Eigen::MatrixXd both(rows.num_rows(), known + 6);
  both << own, own(Eigen::all, station);
  for (size_t k = 0; k < rows.observations.size(); ++k) {
    const Observation& row = data.observations[rows.observations[k]];
    if (data.shots[row.shot].configuration < at) both.block(3 * static_cast<Eigen::Index>(k), known, 3, 6).setZero();
  }
  const auto left = [&rows](const Eigen::MatrixXd& columns) {
    const Eigen::VectorXd scale = columns.colwise().norm().cwiseInverse();
    const Eigen::MatrixXd scaled = columns * scale.asDiagonal();
    const Eigen::VectorXd best = scaled.colPivHouseholderQr().solve(rows.residual);
    return (rows.residual - scaled * best).squaredNorm();
  };
  return 1.0 - left(both) / left(own);
}

// Tried were a station, three markers and six joints, at the 51 places that have five of the sixty configurations on
// either side. A configuration is one alone.
TEST(Breaks, PIsOfTheLikeliestOfAllPlaces) {
  Kr270Truth after;
  after.base_xyz[0] += Vector3<double>(0.2e-3, 0.0, -0.2e-3);
  const CalibrationProblem problem = Measured(after);
  const Estimate estimate = EstimateJointly(problem);
  const std::optional<Break> found = FindBreak(problem, estimate);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->of, BreakOf::kStation);
  const std::vector<int>& columns = estimate.estimated;
  std::vector<int> station;  // its place in the columns: its base is estimated
  for (size_t c = 0; c < columns.size(); ++c) {
    if (estimate.parameters.coordinates()[columns[c]].name.rfind("base/S1/", 0) == 0)
      station.push_back(static_cast<int>(c));
  }
  ASSERT_EQ(station.size(), 6u);
  const std::vector<int> fitted = problem.CalibrationObservations();
  NoiseRoots roots;
  for (const int i : fitted) roots.push_back(estimate.scatter[i]);
  const Linearization rows = Linearize(problem, estimate.parameters, fitted, columns, roots, LatentTreatment::kIgnore);
  double share = 0.0;
  int best = -1;
  for (int at = 5; at <= kConfigurations - 5; ++at) {
    const double here = ShareOfStep(rows, problem.data(), station, at);
    if (here > share) share = here, best = at;
  }
  EXPECT_EQ(problem.data().shots[problem.data().observations[found->first].shot].configuration, best);
  EXPECT_NEAR(found->share, share, 1e-6);
  const double freedom = kConfigurations - 6, f = share / 6 / ((1.0 - share) / freedom);
  const double p = 51 * (1 + 3 + 1 + 6) * FSurvival(f, 6, freedom);  // station, markers, tool, joints
  EXPECT_LT(p, 0.01);
  EXPECT_NEAR(std::log(found->p_value), std::log(p), 1e-4);
}

// An arm that is folded first, then stretched: what the zero of A2 does to the markers is more, the farther they are.
TEST(Breaks, WhatMovedIsWhatComesAfter) {
  Kr270Truth after;
  after.errors[3] += 0.3e-3;  // dq2
  test::Kr270Design design;
  design.configurations = kConfigurations;
  design.stations = 1;
  design.sigma = 5e-5;
  Measurements data = test::DesignMeasurements(design);
  for (size_t c = 0; c < data.configurations.size(); ++c) {
    double& q3 = data.configurations[c].q[2];
    q3 = (static_cast<int>(c) < kAt ? 120.0 : 10.0) * kDegree + 0.2 * q3;
  }
  Measurements later = data;
  test::MeasureKr270(Kr270Truth(), design.sigma, 501, &data);
  test::MeasureKr270(after, design.sigma, 901, &later);
  double squares[2] = {0.0, 0.0};
  int rows[2] = {0, 0};
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& row = data.observations[i];
    const bool is_after = data.shots[row.shot].configuration >= kAt;
    squares[is_after] += (test::ExactPoint(after, data, row) - test::ExactPoint(Kr270Truth(), data, row)).squaredNorm();
    ++rows[is_after];
    if (is_after) data.observations[i] = later.observations[i];
  }
  const double before = std::sqrt(squares[0] / rows[0]), moved = std::sqrt(squares[1] / rows[1]);
  ASSERT_GT(moved, 1.5 * before);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const std::optional<Break> found = FindBreak(problem, EstimateJointly(problem));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->of, BreakOf::kJoint);
  EXPECT_EQ(found->index, 1);
  EXPECT_NEAR(found->moved / moved, 1.0, 0.15);
}

// The eccentric encoder of A2 while poses go from one end of its range to the other: most of it is like a jump in the
// middle of the campaign, and all of it follows the angle. A zero that jumps in the same poses is named.
TEST(Breaks, WhatFollowsTheAngleIsNone) {
  test::Kr270Design design;
  design.configurations = kConfigurations;
  design.stations = 1;
  design.sigma = 5e-5;
  Measurements data = test::DesignMeasurements(design);
  std::sort(data.configurations.begin(), data.configurations.end(),
            [](const Configuration& a, const Configuration& b) { return a.q[1] < b.q[1]; });
  const auto found_with = [&](const std::function<double(int configuration, double q2)>& deviation) {
    Measurements measured = data, turned = data;
    for (size_t c = 0; c < data.configurations.size(); ++c) {
      double& q2 = turned.configurations[c].q[1];
      q2 += deviation(static_cast<int>(c), q2);
    }
    test::MeasureKr270(Kr270Truth(), design.sigma, 502, &turned);
    measured.observations = turned.observations;
    const CalibrationProblem problem = test::Kr270ProblemOf(measured, Experiment());
    return FindBreak(problem, EstimateJointly(problem));
  };
  EXPECT_FALSE(found_with([](int, double q2) { return 4e-4 * std::cos(q2); }));
  const std::optional<Break> jumped = found_with([](int c, double) { return c < kAt ? 0.0 : 4e-4; });
  ASSERT_TRUE(jumped);
  EXPECT_EQ(jumped->of, BreakOf::kJoint);
  EXPECT_EQ(jumped->index, 1);
}

// What else a verdict needs: rows that are held out but have been seen.
TEST(Verdict, HeldOutRowsThatWereFittedAreNoCheck) {
  CalibrationProblem problem = Measured(Kr270Truth());
  Measurements data = problem.data();
  for (int c = 0; c < 20; ++c) {
    Configuration twin = data.configurations[c];
    twin.id += "-again";
    twin.q.array() += 1e-5;
    Shot shot;
    shot.configuration = static_cast<int>(data.configurations.size());
    shot.station = 0;
    data.configurations.push_back(twin);
    const int first = static_cast<int>(data.observations.size());
    test::AddShot(shot, 3, 5e-5, &data);
    for (int i = first; i < static_cast<int>(data.observations.size()); ++i) {
      data.observations[i].point_in_station = data.observations[3 * c + i - first].point_in_station;
    }
  }
  const auto verdict_with = [&](const std::function<bool(size_t)>& held_out) {
    Measurements split = data;
    for (size_t c = 0; c < split.configurations.size(); ++c) split.configurations[c].is_validation = held_out(c);
    CalibrationProblem whole = test::Kr270ProblemOf(data, Experiment());
    whole.set_data(split);
    Estimate estimate = EstimateJointly(whole);
    return test::JudgeTrust(whole, 1, &estimate).verdict;
  };
  const Verdict seen = verdict_with([](size_t c) { return c >= kConfigurations; });
  EXPECT_FALSE(seen.trusted);
  EXPECT_THAT(seen.words, HasSubstr("20 of the 20 configurations held out have the joint values of fitted ones"));
  EXPECT_TRUE(verdict_with([](size_t c) { return c >= 30 && c < kConfigurations; }).trusted);
}

// Every second configuration states a thousandth of its standard deviation, as where metres and millimetres are mixed.
TEST(Verdict, StandardDeviationsThatContradictEachOtherAreSaid) {
  const auto verdict_with = [](double factor) {
    CalibrationProblem problem = Measured(Kr270Truth());
    Measurements data = problem.data();
    for (Observation& row : data.observations) {
      if (data.shots[row.shot].configuration < 12) row.sigma *= factor;
      // What no model has, so that few rows alone do not fit the others.
      row.point_in_station[2] += 3e-4 * std::sin(3.0 * data.ConfigurationOf(row).q[1]);
    }
    const CalibrationProblem changed = test::Kr270ProblemOf(data, Experiment());
    Estimate estimate = EstimateJointly(changed);
    return test::JudgeTrust(changed, 1, &estimate).verdict.words;
  };
  EXPECT_THAT(verdict_with(1e-3), HasSubstr("the stated standard deviations contradict each other"));
  EXPECT_THAT(verdict_with(0.5), ::testing::Not(HasSubstr("contradict each other")));
}

// The same rows by time, shuffled: stated times go before the order of rows.
TEST(Breaks, TimesGoBeforeTheOrderOfRows) {
  Kr270Truth after;
  after.base_xyz[0] += Vector3<double>(0.3e-3, 0.0, -0.4e-3);
  CalibrationProblem problem = Measured(after);
  for (Shot& shot : problem.mutable_data()->shots) {
    shot.has_time = true;
    shot.time = 60.0 * ((shot.configuration * 17) % kConfigurations);  // 17 and 60 have no common factor
  }
  EXPECT_FALSE(FindBreak(problem, EstimateJointly(problem)));
}

// Loads change from shot to shot, or once: none, 250 kg and two sideways pulls, one station, by the
// generator of tests/support/loaded_kr270.h.
test::LoadedTruth LoadedArm() {
  test::LoadedTruth truth = test::Everything();
  truth.spring.reset();
  truth.link_markers.clear();
  return truth;
}

const std::vector<std::string> kLoads = {"none", "V250", "PX", "PY"};

struct LoadedCampaign {
  test::LoadedTruth truth = LoadedArm();
  Measurements data;

  // Each configuration under one of the loads: in turn, or one load after the other.
  LoadedCampaign(const std::vector<std::string>& loads, bool in_turn) {
    test::LoadedDesign design;
    design.configurations = kConfigurations;
    design.stations = 1;
    design.sigma = 5e-5;
    data = test::DesignMeasurements(design);
    for (size_t s = 0; s < data.shots.size(); ++s) {
      Shot& shot = data.shots[s];
      shot.load = loads[in_turn ? s % loads.size() : s * loads.size() / kConfigurations];
      if (shot.load != "none") shot.wrench.force = truth.loads.at(shot.load).force;
    }
  }
  // From the shot `at` on the world is `after`.
  void Measure(const test::LoadedTruth& after, int at) {
    std::vector<Vector3<double>> points = test::ExactPoints(truth, data), later = test::ExactPoints(after, data);
    for (size_t i = 0; i < points.size(); ++i) {
      if (data.observations[i].shot >= at) points[i] = later[i];
    }
    test::Measure(points, 5e-5, 501, &data);
  }
  CalibrationProblem Problem() const {
    const test::LoadedSetup setup = test::SetupFor(truth);
    return MakeCalibrationProblem(setup.robot, data, setup.experiment);
  }
};

// A zero that jumps by 0.15 mrad, 0.2 mm at the markers, four times the noise: no load alone has enough of the squared
// residuals to show it.
TEST(Breaks, AreSeenWhereLoadsAlternate) {
  LoadedCampaign campaign(kLoads, true);
  test::LoadedTruth after = campaign.truth;
  after.errors[7] += 0.15e-3;
  campaign.Measure(after, kAt);
  const CalibrationProblem problem = campaign.Problem();
  const std::optional<Break> found = FindBreak(problem, EstimateJointly(problem));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->of, BreakOf::kJoint);
  EXPECT_EQ(found->index, 2);
  EXPECT_NEAR(problem.data().observations[found->first].shot, kAt, 3);
  EXPECT_LT(found->p_value, 1e-4);
}

// First none, then 250 kg, and what loads do is not in the model: where it begins an arm that reaches forward sinks by
// millimetres, as if the zero of A2 had jumped.
TEST(Breaks, ALoadThatBeginsIsNone) {
  LoadedCampaign campaign({"none", "V250"}, false);
  for (Configuration& configuration : campaign.data.configurations) configuration.q.segment(1, 2) *= 0.3;
  campaign.Measure(campaign.truth, 0);
  test::LoadedSetup setup = test::SetupFor(campaign.truth);
  setup.experiment.estimate.compliance.kind = Selection::Kind::kNone;
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, campaign.data, setup.experiment);
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status));
  EXPECT_GT(estimate.fit.distance_rms, 0.5e-3);
  EXPECT_FALSE(FindBreak(problem, estimate));
}

// All forces reversed: compliances want to be negative, which no choice of weights makes up for.
TEST(Verdict, LoadsOfTheWrongSignAreNamed) {
  const auto verdict_with = [](double sign, double factor) {
    LoadedCampaign campaign(kLoads, true);
    campaign.Measure(campaign.truth, 0);
    for (Shot& shot : campaign.data.shots) shot.wrench.force *= sign;
    for (Observation& row : campaign.data.observations) {
      if (row.shot < kAt) row.sigma *= factor;
    }
    const CalibrationProblem problem = campaign.Problem();
    Estimate estimate = EstimateJointly(problem);
    return test::JudgeTrust(problem, 1, &estimate).verdict;
  };
  for (const double factor : {1.0, 0.3}) {
    const Verdict reversed = verdict_with(-1.0, factor);
    EXPECT_FALSE(reversed.trusted);
    EXPECT_THAT(reversed.words, ::testing::ContainsRegex("compliance/A[1-6] comes out negative"));
    EXPECT_THAT(reversed.words, ::testing::Not(HasSubstr("contradict each other"))) << factor;
  }
  EXPECT_TRUE(verdict_with(1.0, 1.0).trusted);
}

}  // namespace
}  // namespace sagitta::breaks_test
