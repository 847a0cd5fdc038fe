// Axes that slide and arrive elsewhere every time: noise of the joints as that of axes that turn. Measured in closed
// form: p = p0 + R0 (x e_x + y e_y + z e_z + Rz(c) m).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/report/diagnosis_noise_words.h"
#include "estimator/sagitta.h"
#include "tests/support/random_numbers.h"
#include "tests/support/random_vector.h"

namespace sagitta::sliding_repeatability_test {
namespace {

constexpr double kSigma = 10e-6;  // m, of a coordinate
constexpr double kSlide = 25e-6;  // m, of X, Y and Z
constexpr double kTurn = 5e-6;    // rad, of C
constexpr int kPoses = 60, kAgain = 25;

// turns: C, which is on Z.
Robot Gantry(bool turns) {
  const std::string c = turns ? "  - {name: C, type: revolute}\n" : "";
  const std::string on_z = turns ? R"(    - {Tx_mm: 0, error: x_c}
    - {Rx_deg: 0, error: tilt_c}
    - {Rz: C}
)"
                                 : "";
  return ReadRobotText(R"(schema: sagitta/robot/1
name: gantry
joints:
  - {name: X, type: prismatic}
  - {name: Y, type: prismatic}
  - {name: Z, type: prismatic}
)" + c + R"(kinematics:
  chain:
    - {Tx: X}
    - {Rz_deg: 0, error: squareness_xy}
    - {Ty: Y}
    - {Rx_deg: 0, error: squareness_yz}
    - {Ry_deg: 0, error: squareness_xz}
    - {Tz: Z}
)" + on_z,
                       "gantry.yaml");
}

CalibrationProblem Scattering(bool turns) {
  test::RandomNumbers random(32);
  NormalNumbers normal(1039);
  Measurements data;
  data.files.resize(1);
  data.files[0].path = "gantry.csv";
  data.stations = {"S1"};
  data.markers = {"M1", "M2", "M3"};
  const Vector3<double> tools[3] = {{0.15, 0.0, 0.01}, {-0.14, 0.15, 0.0}, {-0.11, -0.16, 0.13}};
  const Matrix3<double> base = RotationFromVector(Vector3<double>(1e-3, 2e-3, 0.5));
  for (int c = 0; c < kPoses + kAgain; ++c) {
    Eigen::Vector4d q(3.0 * random.Uniform(0, 1), 2.0 * random.Uniform(0, 1), -0.8 * random.Uniform(0, 1),
                      random.Uniform(-3, 3));
    if (c >= kPoses) q.head(turns ? 4 : 3) = data.configurations[static_cast<size_t>(c - kPoses)].q;
    if (!turns) q[3] = 0.0;
    const Eigen::VectorXd commanded = q.head(turns ? 4 : 3);
    data.configurations.push_back({"C" + std::to_string(c), commanded, false});
    Eigen::Vector4d at = q;
    for (int j = 0; j < 4; ++j) at[j] += (j < 3 ? kSlide : turns ? kTurn : 0.0) * normal();
    Shot shot;
    shot.configuration = c;
    shot.station = 0;
    for (int m = 0; m < 3; ++m) {
      Observation row;
      row.shot = c;
      row.marker = m;
      row.sigma.setConstant(kSigma);
      row.file = 0;
      row.row = static_cast<int>(data.observations.size());
      const Vector3<double> turned = RotationFromVector(Vector3<double>(0, 0, at[3])) * tools[m];
      row.point_in_station =
          Vector3<double>(1.0, -2.0, 0.3) + base * (at.head<3>() + turned) + kSigma * test::RandomVector(normal);
      data.files[0].rows.push_back({row.row + 2, {}});
      shot.observations.push_back(row.row);
      data.observations.push_back(row);
    }
    data.shots.push_back(shot);
  }
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kNone;
  return MakeCalibrationProblem(Gantry(turns), data, experiment);
}

// Of 85 arrivals and three axes: the logarithm of the size is known to 1 / sqrt(2 · 240) = 5 %.
TEST(SlidingRepeatability, OfAGantryIsNoiseAndNoCauseWithoutAName) {
  const Diagnosis diagnosis = Diagnose(Scattering(true), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNoise);
  const NoiseFinding& noise = diagnosis.noise;
  EXPECT_FALSE(noise.scale_differs) << noise.scale;
  EXPECT_NEAR(std::log(noise.travel.sigma / kSlide), 0.0, 4.0 * 0.05);
  EXPECT_LT(noise.travel.low, kSlide);
  EXPECT_GT(noise.travel.high, kSlide);
  EXPECT_LT(noise.turn.low, kTurn);
  EXPECT_THAT(NoiseInWords(noise), testing::HasSubstr(" um (95 %: "));
}

TEST(SlidingRepeatability, NeedsNoJointThatTurns) {
  const Diagnosis diagnosis = Diagnose(Scattering(false), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNoise);
  const NoiseFinding& noise = diagnosis.noise;
  EXPECT_EQ(noise.turn.sigma, 0.0);
  EXPECT_NEAR(std::log(noise.travel.sigma / kSlide), 0.0, 4.0 * 0.05);
  EXPECT_LT(noise.travel.low, kSlide);
  EXPECT_GT(noise.travel.high, kSlide);
}

}  // namespace
}  // namespace sagitta::sliding_repeatability_test
