// AP and RP of ISO 9283:1998 against figures worked out by hand from 7.2.1 and 7.2.2.
#include "estimator/validation/pose_accuracy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/kr270_experiment.h"

namespace sagitta::pose_accuracy_test {
namespace {

// One marker, one configuration per entry, an arrival per point.
CalibrationProblem Arrivals(const std::vector<std::vector<Vector3<double>>>& poses) {
  test::Kr270Design design;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  data.shots.clear();
  data.observations.clear();
  data.files[0].rows.clear();
  for (size_t c = 0; c < poses.size(); ++c) {
    for (size_t visit = 0; visit < poses[c].size(); ++visit) {
      Shot shot;
      shot.configuration = static_cast<int>(c);
      shot.station = 0;
      shot.visit = std::to_string(visit);
      test::AddShot(shot, 1, 1e-4, &data);
      data.observations.back().point_in_station = poses[c][visit];
    }
  }
  data.markers = {"P1"};
  Robot robot;
  robot.chain = test::Kr270Chain();
  return MakeKnownProblem(robot, data, Experiment(), {});
}

TEST(PoseAccuracy, RepeatabilityIsTheMeanDistanceAndThreeOfItsStandardDeviations) {
  // Barycentre (1, 2, 3); distances 1, 1, 2, 2 mm: mean 1.5, S = sqrt(4 * 0.25 / 3).
  const Vector3<double> b(1, 2, 3);
  const CalibrationProblem problem = Arrivals({{b + Vector3<double>(1e-3, 0, 0), b - Vector3<double>(1e-3, 0, 0),
                                                b + Vector3<double>(0, 2e-3, 0), b - Vector3<double>(0, 2e-3, 0)},
                                               {b, b, b + Vector3<double>(0, 0, 3e-4)},
                                               {b, b + Vector3<double>(0, 0, 4e-4)},
                                               {b}});
  const PoseRepeatability repeatability = MeasurePoseRepeatability(problem);
  // Of three 0, 0 and 0.3 mm: distances 0.1, 0.1, 0.2, S = sqrt(0.02 / 3 / 2) mm. Two show no scatter: not counted.
  const double first = 1.5e-3 + 3.0 * std::sqrt(1.0 / 3.0) * 1e-3;
  const double second = 4e-4 / 3.0 + 3.0 * std::sqrt(0.01 / 3.0) * 1e-3;
  EXPECT_EQ(repeatability.poses, 2);
  EXPECT_EQ(repeatability.fewest, 3);
  EXPECT_EQ(repeatability.most, 4);
  EXPECT_NEAR(repeatability.largest, first, 1e-12);
  EXPECT_NEAR(repeatability.mean, 0.5 * (first + second), 1e-12);
}

TEST(PoseAccuracy, TwoArrivalsShowNoRepeatability) {
  const Vector3<double> b(1, 2, 3);
  const PoseRepeatability twice = MeasurePoseRepeatability(Arrivals({{b, b + Vector3<double>(0, 0, 4e-4)}, {b}}));
  EXPECT_EQ(twice.poses, 0);
  EXPECT_EQ(twice.most, 2);
  EXPECT_EQ(twice.largest, 0.0);
}

TEST(PoseAccuracy, AccuracyIsTheDistanceOfTheBarycentreNotTheMeanDistance) {
  const Vector3<double> b(1, 2, 3);
  const CalibrationProblem problem = Arrivals({{b, b}, {b}});
  Eigen::Matrix3Xd errors(3, 3);
  errors.col(0) << 1e-3, 2e-3, 0;  // barycentre (0, 2, 0) mm
  errors.col(1) << -1e-3, 2e-3, 0;
  errors.col(2) << 3e-3, 0, 4e-3;  // 5 mm
  const PoseAccuracy accuracy = MeasurePoseAccuracy(problem, {0, 1, 2}, errors);
  EXPECT_EQ(accuracy.poses, 2);
  EXPECT_NEAR(accuracy.largest, 5e-3, 1e-12);
  EXPECT_NEAR(accuracy.mean, 3.5e-3, 1e-12);
}

// Two markers, each with its own commanded position, and under one load more: one pose.
TEST(PoseAccuracy, MarkersAndLoadsAreNoPoses) {
  CalibrationProblem problem =
      Arrivals({{Vector3<double>(0, 0, 0), Vector3<double>(0, 0, 0), Vector3<double>(0, 0, 0)}});
  Measurements& data = *problem.mutable_data();
  for (Shot& shot : data.shots) shot.visit = "1";
  data.markers.push_back("P2");
  data.observations[1].marker = 1;
  data.shots[2].load = "V250";
  Eigen::Matrix3Xd errors = Eigen::Matrix3Xd::Zero(3, 3);
  errors.row(0) << 1e-3, 2e-3, 6e-3;
  const PoseAccuracy accuracy = MeasurePoseAccuracy(problem, {0, 1, 2}, errors);
  EXPECT_EQ(accuracy.poses, 1);
  EXPECT_EQ(accuracy.positions, 3);
  EXPECT_NEAR(accuracy.mean, 3e-3, 1e-12);
  EXPECT_EQ(accuracy.scatter, 0.0);
}

// Three targets under one name: their mean may be right where each is far off.
TEST(PoseAccuracy, ReadingsOfOneArrivalThatScatterAreSaid) {
  CalibrationProblem problem = Arrivals({{Vector3<double>(0, 0, 0), Vector3<double>(0, 0, 0)}});
  for (Shot& shot : problem.mutable_data()->shots) shot.visit = "1";
  Eigen::Matrix3Xd errors = Eigen::Matrix3Xd::Zero(3, 2);
  errors.row(0) << 0.05, -0.05;
  const PoseAccuracy accuracy = MeasurePoseAccuracy(problem, {0, 1}, errors);
  EXPECT_NEAR(accuracy.mean, 0.0, 1e-12);
  EXPECT_NEAR(accuracy.scatter, 0.05, 1e-12);
}

// Repeated readings of one arrival are one attained position: the instrument's noise is no arrival.
TEST(PoseAccuracy, RepeatedReadingsAreOneArrival) {
  CalibrationProblem problem = Arrivals({{Vector3<double>(0, 0, 0), Vector3<double>(0, 0, 2e-3)}});
  for (Shot& shot : problem.mutable_data()->shots) shot.visit = "1";
  EXPECT_EQ(MeasurePoseRepeatability(problem).poses, 0);
}

}  // namespace
}  // namespace sagitta::pose_accuracy_test
