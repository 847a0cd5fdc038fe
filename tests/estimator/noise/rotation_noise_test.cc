// Poses whose rotations scatter by another size than their points, against an estimate to which both are stated.
#include "estimator/noise/rotation_noise.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "estimator/calibration/noise_loop.h"
#include "estimator/diagnosis/diagnose.h"
#include "estimator/inspection/inspect.h"
#include "estimator/sagitta.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/kr270_poses.h"

namespace sagitta::rotation_noise_test {
namespace {

constexpr double kPoint = 5e-5, kRotation = 6e-4;  // m, rad: 0.05 mm with 0.6 mrad
constexpr int kConfigurations = 60;

// Sixty poses with that noise; `point` and `rotation`: what the rows state; `turned`: what rotations scatter by.
Measurements NoisyPoses(double point, double rotation, double turned = kRotation) {
  return test::NoisyPoses(kConfigurations, {point, rotation}, {kPoint, turned}, 83);
}

Estimate EstimateOf(double point, double rotation) {
  return EstimateWithNoise(test::Kr270ProblemOf(NoisyPoses(point, rotation), Experiment())).estimate;
}

// Values within 0.3 of the standard deviations of the estimate that knows both, these within 15 %: the sizes are known
// to 6 % from 160 degrees of freedom each.
void ExpectLike(const Estimate& known, const Estimate& found) {
  ASSERT_EQ(known.status, Status::kConverged) << known.message;
  ASSERT_EQ(found.status, Status::kConverged) << found.message;
  int compared = 0;
  for (size_t i = 0; i < known.table.size(); ++i) {
    const ParameterEstimate &a = known.table[i], &b = found.table[i];
    if (!a.free) continue;
    EXPECT_NEAR(b.value, a.value, 0.3 * a.sigma) << a.name;
    EXPECT_NEAR(b.sigma, a.sigma, 0.15 * a.sigma) << a.name;
    ++compared;
  }
  EXPECT_GT(compared, 30);
}

TEST(RotationNoise, EachKindHasItsOwnWhereNothingIsStated) {
  const Estimate known = EstimateOf(kPoint, kRotation), found = EstimateOf(0.0, 0.0);
  ExpectLike(known, found);
  EXPECT_FALSE(RotationComponent(known.noise_report));
  const VarianceComponent* rotation = RotationComponent(found.noise_report);
  ASSERT_TRUE(rotation);
  const VarianceComponent& point = found.noise_report.components[0];
  // f s^2 / sigma^2 is chi-square: f = 3 x 60 less half of the unknowns; 4 standard deviations.
  const double f = 3.0 * kConfigurations - 0.5 * static_cast<double>(found.estimated.size());
  EXPECT_NEAR(point.value, kPoint, 4.0 * kPoint / std::sqrt(2.0 * f));
  EXPECT_NEAR(rotation->value, kRotation, 4.0 * kRotation / std::sqrt(2.0 * f));
  EXPECT_LT(point.low, kPoint);
  EXPECT_GT(point.high, kPoint);
  EXPECT_EQ(found.noise_report.source, "estimated");
  // Both variances come from these rows: Student's interval, with the degrees of freedom of the variances that a
  // coordinate rests on, of one of them (some 160) or of both.
  for (const ParameterEstimate& row : found.table) {
    if (!row.free || row.conditional || row.at_bound) continue;
    EXPECT_NEAR((row.ci95.high - row.value) / row.sigma, StudentQuantile(0.975, row.dof), 1e-6) << row.name;
    EXPECT_GT(row.dof, 0.7 * f) << row.name;
    EXPECT_LT(row.dof, 1.3 * 2.0 * f) << row.name;
  }
}

// An instrument's sigmas far below what the robot leaves, at another ratio: points stay the unit of chi-square.
TEST(RotationNoise, WhatIsStatedFarTooSmallIsNotTheRatio) {
  const Estimate known = EstimateOf(kPoint, kRotation), found = EstimateOf(kPoint / 10, kRotation / 100);
  ExpectLike(known, found);
  EXPECT_TRUE(found.sigma.scaled);
  EXPECT_NEAR(found.sigma.a_posteriori, 10.0, 10.0 * 4.0 * 0.06) << "of points";
}

TEST(RotationNoise, WhatIsStatedRightStays) {
  const ResolvedEstimate right = EstimateWithNoise(test::Kr270ProblemOf(NoisyPoses(kPoint, kRotation), Experiment()));
  EXPECT_TRUE(right.problem.resolved_noise.empty());
  EXPECT_TRUE(right.estimate.noise_report.words.empty());
}

// Rotations that are fifty times as good as the 1 mrad that is assumed of them, with points that state their noise or
// do not: nothing is missing.
TEST(RotationNoise, WhatRotationsDoNotStateIsNoMissingEffect) {
  for (const double point : {kPoint, 0.0}) {
    Measurements data = NoisyPoses(point, 0.0, 2e-5);
    for (size_t c = 0; c < data.configurations.size(); c += 4) data.configurations[c].is_validation = true;
    const Diagnosis diagnosis = Diagnose(test::Kr270ProblemOf(data, Experiment()), DiagnosisOptions());
    EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kConsistent) << point;
    EXPECT_TRUE(diagnosis.effects.empty()) << point;
  }
}

// Stated 0.05 mm and 1 mrad, scattering by 0.05 mm and 0.6 mrad: neither figure is a mean of both, and a target whose
// rotation is read needs no three markers.
TEST(RotationNoise, AnInspectionHasLengthsAndAnglesApart) {
  const Inspection inspection = Inspect(test::Kr270ProblemOf(NoisyPoses(kPoint, 1e-3), Experiment()));
  EXPECT_NEAR(inspection.stated.point, kPoint, 1e-12);
  EXPECT_NEAR(inspection.stated.rotation, 1e-3, 1e-12);
  // 180 coordinates of each, some 40 unknowns: within 4 standard deviations of what these leave.
  EXPECT_NEAR(inspection.linear.point, kPoint, 0.25 * kPoint);
  EXPECT_NEAR(inspection.linear.rotation, kRotation, 0.25 * kRotation);
  EXPECT_FALSE(inspection.sigma_differs);
  for (const Finding& finding : inspection.findings) EXPECT_NE(finding.code, "few_markers");
}

TEST(RotationNoise, TheFileSaysThatNoneWasStated) {
  const Calibration calibration = Calibrate(test::Kr270ProblemOf(NoisyPoses(0.0, 0.0), Experiment()));
  const nlohmann::ordered_json sigma = CalibrationToJson(calibration, {})["sigma"];
  EXPECT_FALSE(sigma["stated"].get<bool>());
  EXPECT_NEAR(sigma["estimated_mm"].get<double>(), 1e3 * kPoint, 0.25 * 1e3 * kPoint);
  EXPECT_NEAR(sigma["estimated_rotation_mrad"].get<double>(), 1e3 * kRotation, 0.25 * 1e3 * kRotation);
}

}  // namespace
}  // namespace sagitta::rotation_noise_test
