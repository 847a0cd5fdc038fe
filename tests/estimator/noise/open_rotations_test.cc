// Poses whose rows state no noise of their rotations: what is found of it, by whichever way of finding noise, and what
// one more reading is said to scatter by.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/calibration/noise_loop.h"
#include "estimator/noise/repeat_spread.h"
#include "estimator/noise/rotation_noise.h"
#include "estimator/noise/variance_components.h"
#include "estimator/results/prediction_noise.h"
#include "estimator/sagitta.h"
#include "tests/support/kr270_poses.h"
#include "tests/support/noise_experiment.h"

namespace sagitta::open_rotations_test {
namespace {

constexpr double kPoint = 5e-5, kRotation = 6e-4;  // m, rad: 0.05 mm with 0.6 mrad, 12 rad per m
constexpr int kConfigurations = 60;

Measurements Poses(double point, double rotation, double scatter_of_point = kPoint) {
  return test::NoisyPoses(kConfigurations, {point, rotation}, {scatter_of_point, kRotation}, 29);
}

// The first `pairs` configurations are shot once more, with noise of its own.
Measurements WithRepeats(Measurements data, int pairs) {
  NormalNumbers normal(31);
  for (int c = 0; c < pairs; ++c) {
    const int point = test::AppendRepeat(c, &data);
    Observation &moved = data.observations[point], &turned = data.observations[point + 1];
    for (int i = 0; i < 3; ++i) moved.point_in_station[i] += std::sqrt(2.0) * kPoint * normal();
    turned.point_in_station = moved.point_in_station;
    Vector3<double> turn;
    for (int i = 0; i < 3; ++i) turn[i] = std::sqrt(2.0) * kRotation * normal();
    turned.mutable_rotation()->in_station = RotationFromVector(turn) * turned.rotation().in_station;
  }
  return data;
}

Experiment Asking(NoiseSpec::From from, LossKind loss = LossKind::kNone) {
  Experiment experiment;
  experiment.noise.from = from;
  experiment.method.loss = loss;
  return experiment;
}

ResolvedEstimate Found(const Measurements& data, const Experiment& experiment) {
  return EstimateWithNoise(test::Kr270ProblemOf(data, experiment));
}

// Sizes from some 160 degrees of freedom: 5.6 % each.
constexpr double kKnownTo = 0.056;

void ExpectRatio(const ResolvedEstimate& found) {
  ASSERT_EQ(found.estimate.status, Status::kConverged) << found.estimate.message;
  const VarianceComponent* rotation = RotationComponent(found.estimate.noise_report);
  ASSERT_TRUE(rotation);
  EXPECT_NEAR(rotation->value, kRotation, 4.0 * kKnownTo * kRotation);
  EXPECT_LT(rotation->low, rotation->value);
  EXPECT_GT(rotation->high, rotation->value);
  EXPECT_NEAR(found.estimate.noise_report.components[0].value, kPoint, 5.0 * kKnownTo * kPoint);
  // They are weighed by it, and one more of them is said to scatter by it.
  const double ratio = rotation->value / found.estimate.noise_report.components[0].value;
  const Matrix3<double> point = found.problem.SqrtCovariance(0), turned = found.problem.SqrtCovariance(1);
  EXPECT_NEAR(turned(0, 0) / point(0, 0), ratio, 1e-3 * ratio);
  const auto json = PredictionNoiseToJson(found.problem, found.estimate);
  EXPECT_NEAR(json["sigma_rot_urad"].get<double>(), 1e6 * rotation->value, 1e-6);
}

TEST(OpenRotations, ALossFindsWhatTheyScatterBy) {
  for (const LossKind loss : {LossKind::kHuber, LossKind::kCauchy}) {
    Measurements data = Poses(0.0, 0.0);
    for (const int i : {6, 30, 62}) data.observations[i].point_in_station.x() += 4e-3;  // points without their rotation
    const ResolvedEstimate found = Found(data, Asking(NoiseSpec::From::kDefault, loss));
    ExpectRatio(found);
    EXPECT_EQ(found.estimate.noise_report.outliers.size(), 3u);
    EXPECT_TRUE(found.estimate.noise_report.converged);
  }
}

// A row is one outlier, whose point is off by mm and whose rotation by mrad.
TEST(OpenRotations, ARowIsOneOutlier) {
  Measurements data = Poses(kPoint, kRotation);
  const auto turn = [&data](int rotation) {
    data.observations[rotation].mutable_rotation()->in_station =
        RotationFromVector<double>({0.0, 0.014, 0.0}) * data.observations[rotation].rotation().in_station;
  };
  turn(7), turn(31);
  data.observations[30].point_in_station.x() += 4e-3;
  const ResolvedEstimate found = Found(data, Asking(NoiseSpec::From::kDefault, LossKind::kHuber));
  const auto json = EstimateToJson(found.problem, found.estimate, {})["noise"]["outliers"];
  ASSERT_EQ(json.size(), 2u);
  for (const auto& row : json) {
    const bool both = row["row"] == data.SourceOf(data.observations[30]);
    EXPECT_EQ(row["distance_mm"].is_null(), !both);
    EXPECT_NEAR(row["angle_mrad"].get<double>(), 14.0, 4.0 * 1e3 * kRotation * std::sqrt(3.0));
  }
  EXPECT_NE(found.estimate.noise_report.words.back().find(" mrad)"), std::string::npos)
      << found.estimate.noise_report.words.back();
}

TEST(OpenRotations, VarianceComponentsHaveOneOfTheirs) {
  Experiment repeatability;
  repeatability.repeatability.angle.estimate = true;
  for (const Experiment& experiment : {Asking(NoiseSpec::From::kVarianceComponents), repeatability}) {
    const ResolvedEstimate found = Found(Poses(0.0, 0.0), experiment);
    ExpectRatio(found);
    EXPECT_FALSE(HasTwoNoises(found.estimate.noise_report));
    EXPECT_EQ(found.estimate.noise_report.components[2].joints.size(), 6u);
  }
}

TEST(OpenRotations, TwoEqualVariancesAreOne) {
  const CalibrationProblem problem = test::Kr270ProblemOf(Poses(kPoint, kRotation), Experiment());
  const Estimate estimate = EstimateJointly(problem);
  const RestrictedLikelihood one(problem, estimate.parameters), two(problem, estimate.parameters, true);
  const std::vector<DeviationGroup> joints = {{{0, 1, 2, 3, 4, 5}, 1e-10, false}};
  EXPECT_NEAR(one.Deviance(1.0, joints), two.Deviance(1.0, joints), 1e-6);
  const RemlFit fit = two.Maximise(true, joints);
  ASSERT_TRUE(fit.converged);
  EXPECT_NEAR(fit.variances[0], 1.0, 8.0 * kKnownTo);
  EXPECT_NEAR(fit.variances[1], 1.0, 8.0 * kKnownTo);
}

// Too few readings to separate two: 8 poses are 48 numbers, with some 30 unknowns.
TEST(OpenRotations, WhatIsAssumedIsSaid) {
  test::Kr270Design design;
  design.configurations = 10;
  design.stations = 1;
  for (const LossKind loss : {LossKind::kNone, LossKind::kHuber}) {
    Measurements data = Poses(0.0, 0.0);
    for (size_t i = 20; i < data.observations.size(); ++i) data.observations[i].excluded = true;
    const ResolvedEstimate found = Found(data, Asking(NoiseSpec::From::kDefault, loss));
    ASSERT_TRUE(IsUsable(found.estimate.status));
    EXPECT_FALSE(RotationComponent(found.estimate.noise_report));
    const std::string& last = found.estimate.warnings.back();
    EXPECT_NE(last.find("1 mrad is assumed where points scatter by 1 mm"), std::string::npos) << last;
    const auto json = PredictionNoiseToJson(found.problem, found.estimate);
    EXPECT_NEAR(json["sigma_rot_urad"].get<double>(), 1e3 * json["sigma_mm"].get<double>(), 1e-9);
  }
}

// Rotations stated a hundredth of what they scatter by, points right: the first spread follows weights that are far too
// large, and is too small.
TEST(OpenRotations, RoundsEndWhereTheSpreadStandsStill) {
  const ResolvedEstimate known = Found(Poses(kPoint, kRotation), Experiment());
  const ResolvedEstimate found = Found(Poses(kPoint, 1e-2 * kRotation), Experiment());
  EXPECT_NEAR(found.problem.SqrtCovariance(1)(0, 0), kRotation, 4.0 * kKnownTo * kRotation);
  EXPECT_FALSE(found.estimate.sigma.scaled);
  for (size_t i = 0; i < known.estimate.table.size(); ++i) {
    const ParameterEstimate &a = known.estimate.table[i], &b = found.estimate.table[i];
    if (a.free) {
      EXPECT_NEAR(b.sigma, a.sigma, 0.15 * a.sigma) << a.name;
    }
  }
}

// 1, 4 and 12 poses shot twice: 3, 12 and 36 degrees of freedom of all axes.
TEST(OpenRotations, RepeatsOfRotationsCountAsManyAsTheyAre) {
  const auto scatter = [](int pairs) { return *PooledRepeats(WithRepeats(Poses(0.0, 0.0), pairs)); };
  EXPECT_TRUE(scatter(1).rotation_sigma.isZero(0.0));
  EXPECT_EQ(scatter(1).rotation_dof, 3.0);
  EXPECT_EQ(scatter(1).dof, 1);
  const RepeatScatter four = scatter(4), twelve = scatter(12);
  EXPECT_FALSE(four.rotation_axes_differ);
  EXPECT_EQ(four.rotation_sigma.x(), four.rotation_sigma.z());
  EXPECT_TRUE(twelve.rotation_axes_differ);
  EXPECT_NE(twelve.rotation_sigma.x(), twelve.rotation_sigma.z());
  EXPECT_DOUBLE_EQ(twelve.rotation_share, 0.5);
  // sum w^2 / nu: three axes of points with 12 each, and of rotations.
  EXPECT_NEAR(SigmaDof(twelve), 1.0 / (6.0 / 36.0 / 12.0), 1e-9);
  EXPECT_NEAR(SigmaDof(four), 1.0 / (3.0 / 36.0 / 4.0 + 0.25 / 12.0), 1e-9);
}

TEST(OpenRotations, RepeatsThatLeaveThemOpenDoNotDecide) {
  const ResolvedEstimate found = Found(WithRepeats(Poses(0.0, 0.0), 1), Asking(NoiseSpec::From::kRepeats));
  ASSERT_TRUE(found.problem.repeat_scatter);
  const RepeatScatter& repeats = *found.problem.repeat_scatter;
  EXPECT_TRUE(repeats.rotation_is_estimated);
  EXPECT_GT(repeats.rotation_dof, 100.0);
  // In units of the points' spread, which one pair gives.
  const double unit = found.problem.SqrtCovariance(1)(0, 0) / repeats.rotation_sigma.x();
  EXPECT_NEAR(unit, 1.0, 1e-9);
  const auto json = CalibrationToJson(
      Calibrate(test::Kr270ProblemOf(WithRepeats(Poses(0.0, 0.0), 1), Asking(NoiseSpec::From::kRepeats))), {});
  EXPECT_EQ(json["noise"]["repeats"]["rotation_from"], "residuals");
}

// What is written of repeats is read back in rad for rotations, in metres for points.
TEST(OpenRotations, APredictedPoseScattersByRadians) {
  const Measurements data = WithRepeats(Poses(0.0, 0.0), 14);
  const Calibration calibration = Calibrate(test::Kr270ProblemOf(data, Asking(NoiseSpec::From::kRepeats)));
  const auto json = CalibrationToJson(calibration, {});
  EXPECT_EQ(json["noise"]["repeats"]["rotation_dof"], 42.0);
  EXPECT_EQ(json["noise"]["repeats"]["rotation_from"], "repeats");
  const Vector3<double> sigma = calibration.problem.repeat_scatter->rotation_sigma;
  const CalibrationProblem known = PredictionProblem(KnownFrom(calibration), data);
  for (size_t i = 0; i < 6; ++i) {
    const bool is_point = known.data().observations[i].is_point();
    const Vector3<double> expected = is_point ? calibration.problem.repeat_scatter->sigma : sigma;
    EXPECT_LT((known.SqrtCovariance(static_cast<int>(i)).diagonal() - expected).norm(), 1e-9 * expected.norm()) << i;
  }
  EXPECT_GT(sigma.minCoeff(), 3e-4);
}

// Stations of 20 and 80 um: the next reading of one is no mean of both; of one that was not there it is.
TEST(OpenRotations, AReadingToComeHasTheSpreadOfItsStation) {
  test::Kr270Design design;
  design.configurations = kConfigurations;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), 2e-5, 4, &data);
  NormalNumbers normal(11);
  for (Observation& row : data.observations) {
    row.sigma.setZero();
    if (data.shots[row.shot].station == 0) continue;
    for (int i = 0; i < 3; ++i) row.point_in_station[i] += std::sqrt(15.0) * 2e-5 * normal();
  }
  for (const ResidualGroup group : {ResidualGroup::kStationAxis, ResidualGroup::kAxis}) {
    Experiment experiment = Asking(NoiseSpec::From::kResiduals);
    experiment.noise.group = group;
    const Calibration calibration = Calibrate(test::Kr270ProblemOf(data, experiment));
    const CalibrationProblem known = PredictionProblem(KnownFrom(calibration), data);
    double least = 1.0, most = 0.0;
    for (size_t i = 0; i < data.observations.size(); ++i) {
      const double sigma = known.SqrtCovariance(static_cast<int>(i))(0, 0);
      least = std::min(least, sigma);
      most = std::max(most, sigma);
      if (group == ResidualGroup::kStationAxis) {
        const double expected = calibration.problem.SqrtCovariance(static_cast<int>(i))(0, 0);
        EXPECT_NEAR(sigma, expected, 1e-9 * expected);
      }
    }
    EXPECT_NEAR(most / least, group == ResidualGroup::kAxis ? 1.0 : 4.0, 1.0);
  }
}

// Two poses among many points: what is known of the target's rotation rests on three readings of an angle.
TEST(OpenRotations, FewOfThemHaveFewDegreesOfFreedom) {
  Measurements data = Poses(0.0, 0.0);
  int kept = 0;
  for (Observation& row : data.observations) {
    if (!row.is_point()) row.excluded = ++kept > 2;
  }
  const ResolvedEstimate found = Found(data, Experiment());
  ASSERT_TRUE(HasTwoNoises(found.estimate.noise_report));
  int turned = 0;
  for (const ParameterEstimate& row : found.estimate.table) {
    if (row.name.rfind("marker/T/r", 0) == 0) {
      EXPECT_LT(row.dof, 4.5) << row.name;
      EXPECT_GT(row.dof, 1.5) << row.name;
      ++turned;
    } else if (row.name.rfind("marker/T/", 0) == 0) {
      EXPECT_GT(row.dof, 50.0) << row.name;
    }
  }
  EXPECT_EQ(turned, 3);
}

// Sums of squares over three spreads of eight degrees of freedom each: beyond the quantile of one in a hundred are as
// many, within 4 standard errors and a quarter for what the first two moments leave.
TEST(OpenRotations, SquaresOverRepeatsExceedAsOftenAsStated) {
  RepeatScatter repeats;
  repeats.sigma.setOnes();
  repeats.axes_differ = true;
  constexpr int kDraws = 20000, kSquares = 30;
  constexpr double kLevel = 0.01;
  NormalNumbers normal(7);
  const auto chi2 = [&](int n) {
    double sum = 0.0;
    for (int i = 0; i < n; ++i) sum += std::pow(normal(), 2);
    return sum;
  };
  for (const int dof : {8, 20}) {
    repeats.dof = dof;
    int beyond = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      double sum = 0.0;
      for (int axis = 0; axis < 3; ++axis) sum += chi2(kSquares / 3) / (chi2(dof) / dof);
      beyond += ChanceOfSquares(repeats, sum, kSquares) < kLevel ? 1 : 0;
    }
    const double share = static_cast<double>(beyond) / kDraws;
    EXPECT_NEAR(share, kLevel, 4.0 * std::sqrt(kLevel / kDraws) + 0.25 * kLevel) << dof;
  }
}

// Readings of one value of three axes, groups of which are shot three times: what is left of their mean is tested by
// repeats that are among them.
TEST(RepeatSpread, RepeatsAreNotHeldAgainstThemselves) {
  constexpr int kDraws = 4000, kRepeats = 3;
  constexpr double kLevel = 0.1;
  CalibrationProblem problem = test::Kr270ProblemOf(Poses(kPoint, kRotation), Experiment());
  problem.noise_origin = NoiseOrigin::kRepeats;
  NormalNumbers normal(11);
  for (const int groups : {10, 40}) {
    const int single = 20, readings = groups * kRepeats + single;
    int beyond = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      RepeatScatter scatter;
      scatter.dof = groups * (kRepeats - 1);
      scatter.axes_differ = true;
      double chi2 = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        Eigen::VectorXd values(readings);
        for (double& value : values) value = normal();
        double within = 0.0;
        for (int g = 0; g < groups; ++g) {
          const auto own = values.segment<kRepeats>(g * kRepeats);
          within += (own.array() - own.mean()).square().sum();
        }
        scatter.sigma[axis] = std::sqrt(within / scatter.dof);
        chi2 += (values.array() - values.mean()).square().sum() * scatter.dof / within;
      }
      problem.repeat_scatter = scatter;
      beyond += ChanceOfResiduals(problem, chi2, 3.0 * (readings - 1)) < kLevel ? 1 : 0;
    }
    const double share = static_cast<double>(beyond) / kDraws;
    EXPECT_NEAR(share, kLevel, 4.0 * std::sqrt(kLevel / kDraws) + 0.1 * kLevel) << groups;
  }
}

}  // namespace
}  // namespace sagitta::open_rotations_test
