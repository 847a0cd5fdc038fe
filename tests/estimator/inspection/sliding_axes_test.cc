// Machines of sliding axes have no lengths but their travel: what a calibration can be asked to explain is measured by
// it. Measured in closed form: p = p0 + R0 (x e_x + y e_y + z e_z + R m), the axes not square to each other.
#include <gtest/gtest.h>

#include "estimator/inspection/reading_lint.h"
#include "estimator/sagitta.h"
#include "tests/support/random_numbers.h"
#include "tests/support/random_vector.h"

namespace sagitta::sliding_axes_test {
namespace {

constexpr double kNotSquare[3] = {4e-4, -3e-4, 2.5e-4};  // rad: x to y, y to z, x to z
constexpr double kTravel[3] = {3.0, 2.0, 0.8};           // m

Robot Gantry(bool has_limits) {
  Robot robot = ReadRobotText(R"(schema: sagitta/robot/1
name: gantry
joints:
  - {name: X, type: prismatic, min_mm: 0, max_mm: 3000}
  - {name: Y, type: prismatic, min_mm: 0, max_mm: 2000}
  - {name: Z, type: prismatic, min_mm: -800, max_mm: 0}
kinematics:
  chain:
    - {Tx: X}
    - {Rz_deg: 0, error: squareness_xy}
    - {Ty: Y}
    - {Rx_deg: 0, error: squareness_yz}
    - {Ry_deg: 0, error: squareness_xz}
    - {Tz: Z}
)",
                              "gantry.yaml");
  for (Joint& joint : robot.chain.joints) {
    if (!has_limits) joint.min = joint.max = std::nullopt;
  }
  return robot;
}

// sign: of Y's travel in the truth.
CalibrationProblem Measured(bool has_limits, double scale = 1.0, double sign = 1.0) {
  test::RandomNumbers random(3);
  NormalNumbers normal(4);
  Measurements data;
  data.files.resize(1);
  data.files[0].path = "gantry.csv";
  data.stations = {"S1"};
  data.markers = {"M1", "M2", "M3"};
  const Vector3<double> tools[3] = {{0.0, 0.0, 0.01}, {-0.14, 0.05, 0.0}, {-0.11, -0.11, 0.03}};
  const Matrix3<double> base = RotationFromVector(Vector3<double>(1e-3, 2e-3, 0.5));
  const Matrix3<double> after_x = RotationFromVector(Vector3<double>(0, 0, kNotSquare[0]));
  const Matrix3<double> after_y = RotationFromVector(Vector3<double>(kNotSquare[1], 0, 0)) *
                                  RotationFromVector(Vector3<double>(0, kNotSquare[2], 0));
  for (int c = 0; c < 40; ++c) {
    const Eigen::Vector3d q =
        scale * Eigen::Vector3d(kTravel[0] * random.Uniform(0, 1), kTravel[1] * random.Uniform(0, 1),
                                -kTravel[2] * random.Uniform(0, 1));
    data.configurations.push_back({"C" + std::to_string(c), q, false});
    Shot shot;
    shot.configuration = c;
    shot.station = 0;
    for (int m = 0; m < 3; ++m) {
      Observation row;
      row.shot = c;
      row.marker = m;
      row.sigma.setConstant(5e-5);
      row.file = 0;
      row.row = static_cast<int>(data.observations.size());
      const Vector3<double> on_z = after_y * (Vector3<double>(0, 0, q[2]) + tools[m]);
      const Vector3<double> in_base =
          Vector3<double>(q[0], 0, 0) + after_x * (Vector3<double>(0, sign * q[1], 0) + on_z);
      row.point_in_station = Vector3<double>(-1.5, -1.0, -1.7) + base * in_base + 5e-5 * test::RandomVector(normal);
      data.files[0].rows.push_back({row.row + 2, {}});
      shot.observations.push_back(row.row);
      data.observations.push_back(row);
    }
    data.shots.push_back(shot);
  }
  return MakeCalibrationProblem(Gantry(has_limits), data, Experiment());
}

TEST(SlidingAxes, AGantryIsCalibratedAndTrusted) {
  for (const bool has_limits : {true, false}) {
    const CalibrationProblem problem = Measured(has_limits);
    EXPECT_FALSE(LintReadings(problem).is_suspicious);
    const Calibration calibration = Calibrate(problem);
    EXPECT_TRUE(calibration.trust.verdict.trusted) << calibration.trust.verdict.words;
    const ParameterSet& found = calibration.estimate.parameters;
    const char* names[3] = {"geometry/squareness_xy", "geometry/squareness_yz", "geometry/squareness_xz"};
    // 0.05 mm over metres and forty poses: some 10 urad.
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(found.Value(found.FindCoordinate(names[i])), kNotSquare[i], 5e-5);
  }
}

// An axis that counts the other way misses by its travel.
TEST(SlidingAxes, AnAxisThatCountsTheOtherWayIsNamed) {
  for (const bool has_limits : {true, false}) {
    const ReadingLint lint = LintReadings(Measured(has_limits, 1.0, -1.0));
    EXPECT_TRUE(lint.is_suspicious);
    EXPECT_TRUE(lint.is_explained);
  }
}

// Of a stage of centimetres without limits, as far as it was measured.
TEST(SlidingAxes, WithoutLimitsTheTravelIsThatOfTheRows) {
  const CalibrationProblem stage = Measured(false, 0.02);
  double travel = 0.0;
  for (int j = 0; j < 3; ++j) travel += 0.02 * kTravel[j];
  EXPECT_LT(SuspiciousMisfit(stage), 0.005 * travel + 1e-12);
  EXPECT_GT(SuspiciousMisfit(stage), 0.9 * 0.005 * travel);
}

}  // namespace
}  // namespace sagitta::sliding_axes_test
