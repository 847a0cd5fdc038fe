#include "estimator/noise/rigid_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimator/calibration/joint_estimator.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::rigid_bodies_test {
namespace {

using Kind = ReadingGroup::Kind;

// Two stations; the joints stand elsewhere than the rows say by `off`, rad, in poses that only the second one measures.
CalibrationProblem Campaign(double off, std::uint64_t seed) {
  const test::Kr270Design design = test::CampaignOf(60, 2, 2e-5, seed);
  Measurements data = test::DesignMeasurements(design), moved = data;
  for (size_t c = 0; c < moved.configurations.size(); ++c) {
    Eigen::VectorXd& q = moved.configurations[c].q;
    q[1] += off * std::sin(7.0 * static_cast<double>(c));
    q[3] += off * std::cos(5.0 * static_cast<double>(c));
  }
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 40 + seed, &moved);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    data.observations[i].point_in_station = moved.observations[i].point_in_station;
  }
  return MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
}

std::vector<ReadingGroup> GroupsAmong(const std::vector<GroupOfOwnNoise>& found) {
  std::vector<ReadingGroup> groups;
  for (const GroupOfOwnNoise& own : found) groups.push_back(own.scaled.group);
  return groups;
}

// Three markers leave three degrees of freedom in each of 60 shots, their distances: twice the noise is beyond doubt.
TEST(RigidBodies, AGroupOfOwnNoiseIsListed) {
  for (const ReadingGroup& group :
       {ReadingGroup{Kind::kStation, 1}, ReadingGroup{Kind::kMarker, 2}, ReadingGroup{Kind::kAxis, 0}}) {
    CalibrationProblem problem = Campaign(0.0, 3);
    for (Observation& row : problem.mutable_data()->observations) {
      const bool of_station = problem.data().shots[row.shot].station == 1;
      if (group.kind == Kind::kStation && of_station) row.sigma /= 2.0;
      if (group.kind == Kind::kMarker && row.marker == 2) row.sigma /= 2.0;
      if (group.kind == Kind::kAxis) row.sigma.x() /= 2.0;
    }
    const ParameterSet parameters = EstimateJointly(problem).parameters;
    const auto found = GroupsOfOwnNoise(problem, parameters, GroupsOfReadings(problem));
    const auto own = std::find_if(found.begin(), found.end(),
                                  [&group](const GroupOfOwnNoise& each) { return each.scaled.group == group; });
    ASSERT_NE(own, found.end()) << WordOf(group.kind);
    EXPECT_NEAR(own->scaled.factor, 2.0, 0.4) << WordOf(group.kind);  // three times 2 / sqrt(2 · 115)
    EXPECT_NEAR(own->gain / found[0].gain, 1.0, 1e-3)
        << WordOf(group.kind);  // of two stations the other one reads half as well, too
    // Nothing is left where the factor is known.
    const CalibrationProblem known = WithScaledGroups(problem, {own->scaled});
    const std::vector<ReadingGroup> rest = GroupsAmong(GroupsOfOwnNoise(known, parameters, GroupsOfReadings(problem)));
    EXPECT_EQ(std::count(rest.begin(), rest.end(), group), 0) << WordOf(group.kind);
  }
}

// One marker of three with a factor between two octaves, at both of which 1.4 is less likely than 1. Of the three
// distances of a shot its noise has the shares 0.51 and 0.22 (eigenvalues): of 1000 shots the gain is 17 in the mean,
// and the logarithm of the factor is known to 0.07.
TEST(RigidBodies, AFactorBetweenTwoOctavesIsFound) {
  for (const double factor : {1.4, 0.72}) {
    const test::Kr270Design design = test::CampaignOf(1000, 1, 2e-5, 11);
    CalibrationProblem problem = MakeCalibrationProblem(
        test::Kr270Robot(), test::MeasuredAfter(design, 111, [](Eigen::VectorXd*) {}), Experiment());
    for (Observation& row : problem.mutable_data()->observations)
      if (row.marker == 2) row.sigma /= factor;
    const auto found = GroupsOfOwnNoise(problem, EstimateJointly(problem).parameters, GroupsOfReadings(problem));
    const auto own = std::find_if(found.begin(), found.end(), [](const GroupOfOwnNoise& each) {
      return each.scaled.group == ReadingGroup{Kind::kMarker, 2};
    });
    ASSERT_NE(own, found.end()) << factor;
    EXPECT_NEAR(own->scaled.factor / factor, 1.0, 0.25);
    EXPECT_GT(own->gain, kLeastGain);
  }
}

// Residuals 20 times the noise that move bodies as a whole: no group of them.
TEST(RigidBodies, WhatMovesBodiesIsNoNoise) {
  const CalibrationProblem healthy = Campaign(0.0, 3), moved = Campaign(4e-4, 3);
  const std::vector<ReadingGroup> all = GroupsOfReadings(healthy);
  ASSERT_EQ(all.size(), 9u);
  const Estimate estimate = EstimateJointly(moved);
  ASSERT_GT(estimate.chi2, 25.0 * estimate.dof);
  EXPECT_EQ(GroupsAmong(GroupsOfOwnNoise(moved, estimate.parameters, all)),
            GroupsAmong(GroupsOfOwnNoise(healthy, EstimateJointly(healthy).parameters, all)));
}

// One marker on the flange, or two: nothing, or one distance.
TEST(RigidBodies, AMarkerAloneShowsNothing) {
  CalibrationProblem problem = Campaign(0.0, 4);
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    if (problem.data().observations[i].marker > 0) problem.mutable_data()->ExcludeRow(static_cast<int>(i));
  }
  for (Observation& row : problem.mutable_data()->observations) row.sigma.x() /= 5.0;
  EXPECT_TRUE(GroupsOfOwnNoise(problem, problem.parameters, GroupsOfReadings(problem)).empty());
}

}  // namespace
}  // namespace sagitta::rigid_bodies_test
