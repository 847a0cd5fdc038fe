// What moved for good while the points were measured: made by a generator of its own
// (tests/support/kr270_experiment.h).
#include "estimator/agreement/breaks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/validation/trust.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta {
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
  const Trust trust = JudgeTrust(problem, 1, &estimate);
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

// What a verdict needs besides: rows that are held out but have been seen.
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
    return JudgeTrust(whole, 1, &estimate).verdict;
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
    return JudgeTrust(changed, 1, &estimate).verdict.words;
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

}  // namespace
}  // namespace sagitta
