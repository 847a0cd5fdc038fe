// Outliers that no model gives are left out of every figure that is compared.
#include "estimator/diagnosis/set_aside.h"

#include <gtest/gtest.h>

#include "estimator/diagnosis/gap.h"
#include "estimator/diagnosis/noise_finding.h"
#include "models/constants.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::set_aside_test {
namespace {

constexpr double kSigma = 2e-5;  // m

CalibrationProblem WithOneHeldOutReadingOff() {
  Measurements data = test::MeasuredAfter(test::CampaignOf(30, 1, 2e-5, 7), 107, [](Eigen::VectorXd*) {});
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.25;
  CalibrationProblem problem = MakeCalibrationProblem(test::Kr270Robot(), data, experiment);
  const int off = problem.ValidationObservations().front();
  problem.mutable_data()->observations[off].point_in_station.x() += 5e-3;
  return problem;
}

TEST(SetAside, NoModelThatIsComparedCountsAHeldOutOutlier) {
  const DiagnosedModel fitted = FitFully(WithOneHeldOutReadingOff(), {});
  const double with = HoldoutRms(fitted);
  DiagnosedModel baseline = fitted, final = fitted, lacking = fitted;
  std::vector<DiagnosedModel> prefixes = {fitted, fitted};
  SetAside aside(0.01, {});
  aside.FromHeldOut(false, false, &baseline, &final, &lacking, &prefixes);
  ASSERT_EQ(aside.held_out(), 1);
  for (const DiagnosedModel* model : {&baseline, &final, &lacking, &prefixes[0], &prefixes[1]}) {
    EXPECT_LT(HoldoutRms(*model), 3.0 * 2e-5);
  }
  EXPECT_EQ(HoldoutRms(fitted), with);  // models share problems: others keep theirs
}

// 40 configurations, of which `spoil` is given the fitted ones in the order of the rows.
template <typename Spoil>
SetAside AsideOf(const Spoil& spoil, DiagnosedModel* model) {
  Measurements data = test::MeasuredAfter(test::CampaignOf(40, 1, kSigma, 7), 107, [](Eigen::VectorXd*) {});
  std::vector<int> fitted;
  for (int c = 0; c < 40; ++c) {
    data.configurations[c].is_validation = c % 4 == 1;
    if (c % 4 != 1) fitted.push_back(c);
  }
  spoil(fitted, &data);
  *model = FitFully(MakeCalibrationProblem(test::Kr270Robot(), data, Experiment()), {});
  SetAside aside(0.01, {});
  aside.FromFitted(model);
  return aside;
}

// 60 sigma, of one marker, in the fitted configurations at these places.
DiagnosedModel MarkerOffAt(const std::vector<int>& places, std::vector<int>* outliers) {
  DiagnosedModel model;
  const SetAside aside = AsideOf(
      [&](const std::vector<int>& fitted, Measurements* data) {
        for (const int place : places) {
          const Shot& shot = data->shots[fitted[place < 0 ? fitted.size() + place : place]];
          data->observations[shot.observations[1]].point_in_station.z() += 60.0 * kSigma;
        }
      },
      &model);
  *outliers = aside.outliers();
  return model;
}

TEST(SetAside, AMarkerThatIsOffFromAMomentOnIsNoOutlier) {
  std::vector<int> outliers;
  MarkerOffAt({-4, -3, -2, -1}, &outliers);
  EXPECT_TRUE(outliers.empty());
  MarkerOffAt({0, 1, 2}, &outliers);
  EXPECT_TRUE(outliers.empty());
  MarkerOffAt({3, 11, 19, 28}, &outliers);
  EXPECT_EQ(outliers.size(), 4u);
  MarkerOffAt({-1}, &outliers);
  EXPECT_EQ(outliers.size(), 1u);
}

TEST(SetAside, AWrongPoseIsFoundByAllItsReadings) {
  DiagnosedModel model;
  const SetAside aside = AsideOf(
      [](const std::vector<int>& fitted, Measurements* data) {
        data->configurations[fitted[12]].q[1] += 0.5 * kDegree;
        data->configurations[fitted[20]].q[2] -= 0.5 * kDegree;
      },
      &model);
  NoiseFinding noise;
  NameLeftOut(model, aside.outliers(), &noise);
  ASSERT_EQ(noise.arrivals.size(), 2u);
  EXPECT_EQ(noise.SingleOutliers(), 0);
  EXPECT_EQ(noise.arrivals[0].configuration, "C16");
  EXPECT_EQ(noise.arrivals[1].configuration, "C27");
  EXPECT_GT(noise.arrivals[0].off, 5e-3);  // 0.5 deg of 1.5 m and more are 13 mm
}

// Two configurations alone were approached from the other side, and both are off: its doing, and no mistake of theirs.
TEST(SetAside, WhatMostReadingsOfAConditionDoIsNoOutlier) {
  DiagnosedModel model;
  const SetAside aside = AsideOf(
      [](const std::vector<int>& fitted, Measurements* data) {
        for (Shot& shot : data->shots) shot.approach = std::vector<int>(6, 1);
        for (const int place : {12, 20}) {
          Shot& shot = data->shots[fitted[place]];
          shot.approach[1] = -1;
          for (const int i : shot.observations) data->observations[i].point_in_station.z() -= 3e-3;
        }
      },
      &model);
  EXPECT_TRUE(aside.outliers().empty());
}

}  // namespace
}  // namespace sagitta::set_aside_test
