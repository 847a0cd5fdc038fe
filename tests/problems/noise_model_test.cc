#include "problems/noise_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "problems/calibration_problem.h"
#include "problems/input_error.h"
#include "problems/simulation.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::noise_model_test {
namespace {

using From = NoiseSpec::From;
using ::testing::HasSubstr;

NoiseSpec Tracker() {
  NoiseSpec noise;
  noise.from = From::kInstrument;
  noise.range = 10e-6;
  noise.range_per_m = 0.5e-6;
  noise.angle = 15e-6;
  noise.angle_per_m = 6e-6;
  return noise;
}

// Range and two angles turned into the frame by spherical unit vectors.
TEST(NoiseModel, InstrumentCovarianceIsThatOfRangeAndAngles) {
  test::RandomNumbers random(3);
  const Vector3<double> instrument(0.4, -0.2, 1.1);
  for (int trial = 0; trial < 20; ++trial) {
    const double r = random.Uniform(2, 8), azimuth = random.Uniform(-3, 3), elevation = random.Uniform(-1.2, 1.2);
    Eigen::Matrix3d frame;
    frame.col(0) << std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
        std::sin(elevation);
    frame.col(1) << -std::sin(azimuth), std::cos(azimuth), 0;
    frame.col(2) = frame.col(0).cross(frame.col(1));
    const Vector3<double> sigma(10e-6 + 0.5e-6 * r, 15e-6 + 6e-6 * r, 15e-6 + 6e-6 * r);
    const Eigen::Matrix3d expected = frame * sigma.cwiseAbs2().asDiagonal() * frame.transpose();
    const Matrix3<double> root = InstrumentRoot(Tracker(), instrument + r * frame.col(0), instrument);
    EXPECT_LT((root * root.transpose() - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.maxCoeff());
  }
}

Measurements Repeated() {
  test::Kr270Design design;
  design.configurations = 12;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), 0.0, 1, &data);
  Shot again = data.shots[0];
  again.repeat = "2";
  again.observations.clear();
  for (int m = 0; m < 3; ++m) {
    Observation observation = data.observations[m];
    observation.shot = static_cast<int>(data.shots.size());
    observation.point_in_station += Vector3<double>(2e-5, 4e-5, 6e-5);
    again.observations.push_back(static_cast<int>(data.observations.size()));
    data.observations.push_back(observation);
  }
  data.shots.push_back(again);
  return data;
}

CalibrationProblem Make(const Measurements& data, const Experiment& experiment) {
  Robot robot;
  robot.chain = test::Kr270Chain();
  return MakeCalibrationProblem(robot, data, experiment);
}

// The last shot of Repeated() that many times in all, each as far from the first.
Measurements RepeatedOften(int times) {
  Measurements data = Repeated();
  const Shot again = data.shots.back();
  for (int k = 1; k < times; ++k) {
    Shot shot = again;
    shot.repeat = std::to_string(k + 2);
    for (int& i : shot.observations) {
      Observation observation = data.observations[i];
      observation.shot = static_cast<int>(data.shots.size());
      i = static_cast<int>(data.observations.size());
      data.observations.push_back(observation);
    }
    data.shots.push_back(shot);
  }
  return data;
}

// n shots at d and one at 0: squares about their mean d^2 n / (n + 1), with n degrees of freedom per marker and axis.
// Of 12 degrees each axis has its own, with fewer all have one.
TEST(NoiseModel, AxesOfRepeatsArePooledWhereTheyAreFew) {
  for (const int n : {3, 4}) {
    const std::optional<RepeatScatter> scatter = PooledRepeats(RepeatedOften(n));
    ASSERT_TRUE(scatter.has_value());
    EXPECT_EQ(scatter->dof, 3 * n);
    EXPECT_EQ(scatter->axes_differ, n == 4);
    Vector3<double> variance = Vector3<double>(4e-10, 16e-10, 36e-10) / (n + 1.0);
    if (n == 3) variance.setConstant(variance.mean());
    EXPECT_LT((scatter->sigma - variance.cwiseSqrt()).cwiseAbs().maxCoeff(), 1e-12) << n;
    const std::vector<KnownSpread> spreads = SpreadsOf(*scatter);
    ASSERT_EQ(spreads.size(), n == 4 ? 3u : 1u);
    EXPECT_EQ(spreads[0].dof, n == 4 ? 12.0 : 27.0);
  }
}

// A mean over three axes that scatter alike, weighed by what repeats show of each: how often Student's interval with
// all their degrees of freedom holds the truth. By axes with 3 degrees each 81 %. Within 4 standard errors.
TEST(NoiseModel, AMeanOfAxesIsAsWellKnownAsFewRepeatsSay) {
  constexpr int kTrials = 4000;
  const double quantile = 2.262157;  // Student's 0.975 with 9
  NormalNumbers normal(17);
  Measurements data = Repeated();
  int inside = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    for (Observation& row : data.observations) {
      for (int axis = 0; axis < 3; ++axis) row.point_in_station[axis] = normal();
    }
    const RepeatScatter scatter = *PooledRepeats(data);
    ASSERT_EQ(scatter.dof, 3);
    double weights = 0.0, sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double weight = 1.0 / std::pow(scatter.sigma[axis], 2);
      weights += weight;
      sum += weight * normal();
    }
    inside += std::abs(sum / weights) * std::sqrt(weights) < quantile ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(inside) / kTrials, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / kTrials));
}

// Two shots d apart: variance d^2 / 2 with one degree of freedom per marker.
TEST(NoiseModel, RepeatsArePooled) {
  const std::optional<RepeatScatter> scatter = PooledRepeats(Repeated());
  ASSERT_TRUE(scatter.has_value());
  EXPECT_EQ(scatter->dof, 3);
  const Vector3<double> expected = Vector3<double>::Constant(std::sqrt((4e-10 + 16e-10 + 36e-10) / 3.0 / 2.0));
  EXPECT_LT((scatter->sigma - expected).cwiseAbs().maxCoeff(), 1e-12);
  Experiment experiment;
  experiment.noise.from = From::kRepeats;
  const CalibrationProblem problem = Make(Repeated(), experiment);
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    EXPECT_LT((problem.SqrtCovariance(static_cast<int>(i)).diagonal() - expected).cwiseAbs().maxCoeff(), 1e-12);
  }
}

// Another visit, load, station or marker is no repeat.
// Three axes with n degrees of freedom each; of two spreads by their shares (Satterthwaite 1946).
TEST(NoiseModel, DegreesOfFreedomOfRepeatsAreThoseOfTheirAxes) {
  EXPECT_TRUE(std::isinf(SigmaDof(std::nullopt)));
  RepeatScatter repeats;
  repeats.sigma.setConstant(1e-5);
  repeats.dof = 7;
  EXPECT_NEAR(SigmaDof(repeats), 21.0, 1e-12);
  repeats.rotation_sigma.setConstant(1e-4);
  repeats.rotation_dof = 5.0;
  repeats.rotation_share = 0.4;
  EXPECT_NEAR(SigmaDof(repeats), 1.0 / (0.6 * 0.6 / 21.0 + 0.4 * 0.4 / 5.0), 1e-12);
}

TEST(NoiseModel, AnotherArrivalIsNoRepeat) {
  Measurements data = Repeated();
  data.shots.back().visit = "2";
  EXPECT_FALSE(PooledRepeats(data).has_value());
  data.shots.back().visit = data.shots[0].visit;
  data.shots.back().load = "V250";
  EXPECT_FALSE(PooledRepeats(data).has_value());
}

// Where all that was repeated is held out the noise is known all the same.
TEST(NoiseModel, RepeatsOfAHeldOutPose) {
  Measurements data = Repeated();
  const RepeatScatter fitted = *PooledRepeats(data);
  EXPECT_TRUE(fitted.is_of_fitted);
  for (Configuration& configuration : data.configurations) configuration.is_validation = true;
  const RepeatScatter held_out = *PooledRepeats(data);
  EXPECT_FALSE(held_out.is_of_fitted);
  EXPECT_EQ(held_out.sigma, fitted.sigma);
}

std::string Refusal(const Measurements& data, const Experiment& experiment) {
  try {
    Make(data, experiment);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(NoiseModel, WhatCannotBeIsRefusedWithWords) {
  Measurements once = Repeated();
  once.shots.back().visit = "2";
  Experiment experiment;
  experiment.noise.from = From::kRepeats;
  EXPECT_NE(Refusal(once, experiment).find("no repeats"), std::string::npos);

  experiment.noise = Tracker();
  experiment.noise.range = experiment.noise.range_per_m = 0.0;
  EXPECT_NE(Refusal(once, experiment).find("line of sight"), std::string::npos);

  experiment.noise = NoiseSpec();
  experiment.noise.from = From::kResiduals;
  experiment.repeatability.angle.common = 1e-5;
  EXPECT_NE(Refusal(once, experiment).find("repeatability"), std::string::npos);

  experiment = Experiment();
  experiment.method.weights = Weights::kEq14;
  experiment.method.loss = LossKind::kHuber;
  EXPECT_NE(Refusal(once, experiment).find("loss"), std::string::npos);
  experiment.method.weights = Weights::kEqual;
  EXPECT_EQ(Refusal(once, experiment), "");  // alike in every row: the weights of the noise
  once.observations[0].sigma *= 2.0;
  EXPECT_NE(Refusal(once, experiment).find("loss"), std::string::npos);
  experiment.method.loss = LossKind::kNone;
  experiment.method.covariance = CovarianceKind::kProfile;
  EXPECT_NE(Refusal(once, experiment).find("profile"), std::string::npos);
  experiment.method.covariance = CovarianceKind::kModel;
  EXPECT_EQ(Refusal(once, experiment), "");
  experiment.repeatability.angle.common = 1e-5;
  EXPECT_NE(Refusal(once, experiment).find("repeatability"), std::string::npos);
  experiment.repeatability = RepeatabilitySpec();
  experiment.method.weights = Weights::kEq14;
  for (Observation& observation : once.observations) observation.sigma.setZero();
  EXPECT_NE(Refusal(once, experiment).find("nothing states"), std::string::npos);
  experiment = Experiment();
  experiment.noise.from = From::kRows;
  EXPECT_NE(Refusal(once, experiment).find("no row states"), std::string::npos);
}

// Points of the arm to the last digit that a display shows.
std::vector<std::string> WarningsOfRounded(double step, double sigma) {
  Measurements data = Repeated();
  for (Observation& row : data.observations) {
    row.point_in_station = step * (row.point_in_station / step).array().round().matrix();
    row.sigma.setConstant(sigma);
  }
  return Make(data, Experiment()).data().warnings;
}

TEST(NoiseModel, RoundingThatScattersByMoreThanIsStatedIsSaid) {
  const std::vector<std::string> warnings = WarningsOfRounded(1e-4, 2e-5);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("are rounded to 0.1 mm"));
  EXPECT_THAT(warnings[0], HasSubstr("state at least 0.0289 mm"));
  EXPECT_TRUE(WarningsOfRounded(1e-4, 3e-5).empty());
  EXPECT_TRUE(WarningsOfRounded(1e-7, 1e-9).empty());
}

TEST(NoiseModel, RowsWhoseStandardDeviationsAreReplacedAreCounted) {
  Measurements data = Repeated();
  for (Observation& row : data.observations) row.sigma.setZero();
  Experiment experiment;
  experiment.noise.from = From::kRepeats;
  EXPECT_TRUE(Make(data, experiment).data().warnings.empty());
  data.observations[1].sigma.setConstant(2e-5);
  data.observations[3].sigma.setConstant(2e-5);
  const std::vector<std::string> warnings = Make(data, experiment).data().warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("that 2 rows state are not used"));
  experiment.noise = NoiseSpec();
  experiment.noise.sigma = 1e-4;  // of rows that state none
  EXPECT_TRUE(Make(data, experiment).data().warnings.empty());
}

}  // namespace
}  // namespace sagitta::noise_model_test
