#include "problems/reading_group.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <set>

#include "problems/noise_model.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::reading_group_test {
namespace {

using Kind = ReadingGroup::Kind;

CalibrationProblem Campaign(int stations = 2) {
  const test::Kr270Design design = test::CampaignOf(12, stations, 2e-5, 1);
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 11, &data);
  return MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
}

// A root that is neither diagonal nor isotropic.
Matrix3<double> SkewedRoot() {
  Matrix3<double> root;
  root << 3e-5, 0.0, 0.0, 1e-5, 2e-5, 0.0, -1e-5, 5e-6, 4e-5;
  return root;
}

Matrix3<double> CovarianceOf(const Matrix3<double>& root) { return root * root.transpose(); }

// Sigma + (f^2 - 1) d d' / (d' Sigma^-1 d): of the instrument's angles and range, where the root is theirs, another
// range.
TEST(ReadingGroup, AFactorAlongADirectionAddsVarianceThereAlone) {
  const CalibrationProblem problem = Campaign();
  ReadingWithRoot reading = ReadingOf(problem, 4);
  reading.root = SkewedRoot();
  for (const ReadingGroup& group : {ReadingGroup{Kind::kAxis, 1}, ReadingGroup{Kind::kSight, 0}}) {
    const Vector3<double> along = group.kind == Kind::kAxis ? Vector3<double>::UnitY().eval() : reading.point;
    const Matrix3<double> before = CovarianceOf(reading.root);
    const double known = 1.0 / along.dot(before.inverse() * along);
    for (const double factor : {0.3, 3.0}) {
      const Matrix3<double> expected = before + (factor * factor - 1.0) * known * along * along.transpose();
      const Matrix3<double> root = ScaledRoot(reading, {{group, factor}});
      EXPECT_LT((CovarianceOf(root) - expected).norm(), 1e-12 * expected.norm());
      EXPECT_TRUE(root.isLowerTriangular(1e-12 * root.norm()));
    }
  }
  NoiseSpec tracker;
  tracker.range = 1e-5;
  tracker.angle_per_m = 6e-6;
  reading.root = InstrumentRoot(tracker, reading.point, Vector3<double>::Zero());
  tracker.range *= 4.0;
  const Matrix3<double> expected = CovarianceOf(InstrumentRoot(tracker, reading.point, Vector3<double>::Zero()));
  const Matrix3<double> scaled = CovarianceOf(ScaledRoot(reading, {{{Kind::kSight, 0}, 4.0}}));
  EXPECT_LT((scaled - expected).norm(), 1e-10 * expected.norm());
}

TEST(ReadingGroup, FactorsOfStationsAndMarkersMultiply) {
  const CalibrationProblem problem = Campaign();
  std::set<double> seen;
  for (const int i : problem.CalibrationObservations()) {
    const ReadingWithRoot reading = ReadingOf(problem, i);
    const bool of_station = problem.data().shots[reading.observation.shot].station == 1;
    const double factor = (of_station ? 3.0 : 1.0) * (reading.observation.marker == 2 ? 0.25 : 1.0);
    const Matrix3<double> root = ScaledRoot(reading, {{{Kind::kStation, 1}, 3.0}, {{Kind::kMarker, 2}, 0.25}});
    EXPECT_LT((root - factor * reading.root).norm(), 1e-12 * root.norm());
    seen.insert(factor);
  }
  EXPECT_EQ(seen, (std::set<double>{0.25, 0.75, 1.0, 3.0}));
}

// A row without noise, or without a point, is in no group; what has no rotations has no group of them.
TEST(ReadingGroup, WhatIsNotTheGroupsStaysAsItIs) {
  const CalibrationProblem problem = Campaign();
  ReadingWithRoot reading = ReadingOf(problem, 0);
  EXPECT_EQ(DirectionsOf(reading, {Kind::kRotations, 0}).cols(), 0);
  EXPECT_EQ(DirectionsOf(reading, {Kind::kStation, 1}).cols(), 0);
  EXPECT_EQ(DirectionsOf(reading, {Kind::kStation, 0}).cols(), 3);
  EXPECT_EQ(DirectionsOf(reading, {Kind::kSight, 0}).cols(), 1);
  reading.root.setZero();
  EXPECT_EQ(DirectionsOf(reading, {Kind::kStation, 0}).cols(), 0);
  EXPECT_TRUE(ScaledRoot(reading, {{{Kind::kStation, 0}, 3.0}}).isZero(0.0));
  ReadingWithRoot without_point = ReadingOf(problem, 0);
  without_point.point.setConstant(std::nan(""));
  EXPECT_EQ(DirectionsOf(without_point, {Kind::kSight, 0}).cols(), 0);
}

TEST(ReadingGroup, ANameIsThatOfItsGroup) {
  const CalibrationProblem problem = Campaign();
  const Measurements& data = problem.data();
  const std::vector<ReadingGroup> groups = GroupsOfReadings(problem);
  EXPECT_EQ(groups.size(), 9u);  // two stations, three markers, three axes, the line of sight
  for (const ReadingGroup& group : groups) {
    const auto found = FindGroup(WordOf(group.kind), NameOf(group, data), data);
    ASSERT_TRUE(found) << WordOf(group.kind);
    EXPECT_TRUE(*found == group);
  }
  EXPECT_EQ(NameOf({Kind::kStation, 1}, data), data.stations[1]);
  EXPECT_EQ(NameOf({Kind::kAxis, 2}, data), "z");
  EXPECT_FALSE(FindGroup("station", "elsewhere", data));
  EXPECT_FALSE(FindGroup("weekday", "", data));
}

// One station is all readings: its factor is that of the noise.
TEST(ReadingGroup, AGroupLeavesReadingsToOthers) {
  for (const ReadingGroup& group : GroupsOfReadings(Campaign(1))) EXPECT_NE(group.kind, Kind::kStation);
}

}  // namespace
}  // namespace sagitta::reading_group_test
