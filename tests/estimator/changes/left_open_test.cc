// An arm that was calibrated with its flange always the same way, and readings with the flange turned: the marker was
// not measured and is held elsewhere than it is. The points are off by decimetres, and no statement about the robot
// follows.
#include <gmock/gmock.h>

#include "estimator/report/inspection_known_words.h"
#include "estimator/sagitta.h"
#include "tests/support/constant_orientation.h"
#include "tests/support/random_vector.h"

namespace sagitta::left_open_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kSigma = 3e-5;  // m
const Eigen::Matrix3d kDown = test::Turn(Eigen::Vector3d::UnitY(), 0.5 * kPi);
const Eigen::Matrix3d kAhead = Eigen::Matrix3d::Identity();

// Measured by a robot whose first joint stands `off` (rad) from what is stated.
Measurements MeasuredWith(const Eigen::Matrix3d& flange, std::uint64_t seed, double off = 0.0) {
  Measurements data = test::ConstantOrientationGrid(flange, 40, seed, kSigma);
  Measurements real = data;
  for (size_t c = 0; c < real.configurations.size(); ++c) real.configurations[c].q[0] += (c % 2 == 0 ? off : -off);
  NormalNumbers normal(seed);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Vector3<double> noise = kSigma * test::RandomVector(normal);
    data.observations[i].point_in_station = test::ExactPoint(test::Kr270Truth(), real, real.observations[i]) + noise;
  }
  return data;
}

KnownRobot CalibratedOn(const Measurements& data) {
  Robot robot;
  robot.chain = test::Kr270Chain();
  const Calibration calibration = Calibrate(MakeCalibrationProblem(robot, data, Experiment()));
  EXPECT_TRUE(IsUsable(calibration.estimate.status)) << calibration.estimate.message;
  return KnownFrom(calibration);
}

TEST(LeftOpen, PosesThatNeedWhatWasNotMeasuredSayNothingOfTheRobot) {
  const KnownRobot known = CalibratedOn(MeasuredWith(kDown, 1));
  const Measurements turned = MeasuredWith(kAhead, 2);
  const Validation validation = Validate(known, turned);
  // Far enough to be another robot, were it not for the marker: suspicious is 5 % of the reach.
  ASSERT_GT(validation.after.distance_rms, 0.2);
  EXPECT_EQ(validation.contradiction, "");
  ASSERT_FALSE(validation.warnings.empty());
  EXPECT_THAT(validation.warnings.back(), HasSubstr("what the calibration did not measure (marker/P1/"));
  EXPECT_THAT(validation.warnings.back(), Not(HasSubstr("not this robot")));
  EXPECT_EQ(validation.warnings.back(), LeftOpenInWords(known, turned, Predict(known, turned)));
  EXPECT_NO_THROW(CheckReadings(known, turned, validation.predicted, ""));
}

TEST(LeftOpen, PosesLikeThoseOfTheCalibrationDoNot) {
  const KnownRobot known = CalibratedOn(MeasuredWith(kDown, 1));
  const Measurements same = MeasuredWith(kDown, 3);
  const Validation validation = Validate(known, same);
  EXPECT_LT(validation.after.distance_rms, 1e-3);
  EXPECT_EQ(LeftOpenInWords(known, same, Predict(known, same)), "");
  EXPECT_THAT(validation.warnings, Not(Contains(HasSubstr("did not measure"))));
}

// What the calibration left open explains no error that does not depend on it, nor one that is larger.
TEST(LeftOpen, AnotherRobotIsStillRefused) {
  const KnownRobot known = CalibratedOn(MeasuredWith(kDown, 1));
  for (const Eigen::Matrix3d& flange : {kDown, kAhead}) {
    const Measurements other = MeasuredWith(flange, 4, kPi / 2);
    EXPECT_THAT(Validate(known, other).contradiction, HasSubstr("cannot have made these readings"));
  }
}

// With the marker measured, readings of a marker 0.4 m away are contradicted as before.
TEST(LeftOpen, WhatWasMeasuredIsNotOpen) {
  Measurements both = MeasuredWith(kDown, 1);
  for (const Configuration& configuration : MeasuredWith(kAhead, 2).configurations) {
    Shot shot;
    shot.configuration = static_cast<int>(both.configurations.size());
    shot.station = 0;
    both.configurations.push_back(configuration);
    both.configurations.back().id += "b";
    test::AddShot(shot, 1, kSigma, &both);
    both.observations.back().point_in_station = test::ExactPoint(test::Kr270Truth(), both, both.observations.back());
  }
  const KnownRobot known = CalibratedOn(both);
  Measurements moved = MeasuredWith(kAhead, 3);
  for (Observation& row : moved.observations) row.point_in_station.x() += 0.4;
  EXPECT_THAT(Validate(known, moved).contradiction, HasSubstr("cannot have made these readings"));
}

}  // namespace
}  // namespace sagitta::left_open_test
