// What is weighed, averaged over resamples of the poses: what every resample shows stays, and each has one share.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/diagnosis/effect_checks.h"
#include "estimator/evidence/pose_groups.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::bagged_models_test {
namespace {

constexpr double kSigma = 2e-5;  // m
constexpr double kStrong = 80e-6, kWeak = 30e-6;

// Joints 3 and 5 off by harmonics.
std::unique_ptr<Evidence> Weigh(int configurations) {
  const auto move = [](Eigen::VectorXd* q) {
    (*q)[2] += kStrong * std::cos(2.0 * (*q)[2]);
    (*q)[4] += kWeak * std::sin(3.0 * (*q)[4]);
  };
  const Measurements data = test::MeasuredAfter(test::CampaignOf(configurations, 1, kSigma, 11), 111, move);
  const CalibrationProblem problem = MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
  const ParameterSet parameters = FitFully(problem, JointOptions()).estimate.parameters;
  return std::make_unique<Evidence>(problem, parameters, ListCandidates(problem, parameters), PriorMasses(),
                                    std::numeric_limits<double>::infinity(), nullptr);
}

std::vector<WeightedModel> Bagged(const Evidence& evidence) {
  const WeightedModel& leading = evidence.models()[0];
  return BaggedModels(evidence, leading, PoseGroups(evidence, leading, InPlaces(evidence, leading)));
}

double Sum(const std::vector<WeightedModel>& models) {
  double sum = 0.0;
  for (const WeightedModel& model : models) sum += model.probability;
  return sum;
}

TEST(BaggedModels, WhatEveryResampleShowsStays) {
  const std::unique_ptr<Evidence> evidence = Weigh(40);
  const Posterior whole = PosteriorOf(*evidence, evidence->models());
  const std::vector<WeightedModel> models = Bagged(*evidence);
  const Posterior bagged = PosteriorOf(*evidence, models);
  EXPECT_NEAR(Sum(models), 1.0, 1e-12);
  ASSERT_GE(whole.explanations.size(), 2u);
  const std::string& strong = whole.explanations[0].name;
  const std::string& weak = whole.explanations[1].name;
  EXPECT_NE(strong.find("joint_harmonic[order=2]/"), std::string::npos) << strong;
  EXPECT_NE(weak.find("joint_harmonic[order=3]/"), std::string::npos) << weak;
  EXPECT_GT(bagged.Of(strong), 0.999);
  EXPECT_GT(whole.Of(weak), 0.8);
  EXPECT_LT(bagged.Of(weak), 0.7);
}

// The poses as they are count as one resample: in addition to them each of these holds a name or does not.
TEST(BaggedModels, EveryResampleHasOneShare) {
  const std::unique_ptr<Evidence> evidence = Weigh(40);
  const Posterior whole = PosteriorOf(*evidence, evidence->models());
  const Posterior bagged = PosteriorOf(*evidence, Bagged(*evidence));
  int between = 0;
  for (const NamedProbability& entry : bagged.explanations) {
    const double resamples = (kResamples + 1) * entry.probability - whole.Of(entry.name);
    EXPECT_NEAR(resamples, std::round(resamples), 1e-9) << entry.name;
    EXPECT_GE(std::round(resamples), 0.0);
    EXPECT_LE(std::round(resamples), kResamples);
    between += std::round(resamples) > 0.0 && std::round(resamples) < kResamples ? 1 : 0;
  }
  EXPECT_GT(between, 0);
}

TEST(BaggedModels, TooFewPosesAreNotResampled) {
  const std::unique_ptr<Evidence> evidence = Weigh(19);
  const std::vector<WeightedModel> models = Bagged(*evidence);
  ASSERT_EQ(models.size(), evidence->models().size());
  for (size_t k = 0; k < models.size(); ++k) {
    EXPECT_EQ(models[k].set.members, evidence->models()[k].set.members);
    EXPECT_EQ(models[k].probability, evidence->models()[k].probability);
  }
}

}  // namespace
}  // namespace sagitta::bagged_models_test
