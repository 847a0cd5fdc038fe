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

std::unique_ptr<Evidence> Weigh(const Measurements& data) {
  const CalibrationProblem problem = MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
  const ParameterSet parameters = FitFully(problem, JointOptions()).estimate.parameters;
  return std::make_unique<Evidence>(problem, parameters, ListCandidates(problem, parameters), PriorMasses(),
                                    std::numeric_limits<double>::infinity(), nullptr);
}

// Joints 3 and 5 off by harmonics.
std::unique_ptr<Evidence> Weigh(int configurations) {
  const auto move = [](Eigen::VectorXd* q) {
    (*q)[2] += kStrong * std::cos(2.0 * (*q)[2]);
    (*q)[4] += kWeak * std::sin(3.0 * (*q)[4]);
  };
  return Weigh(test::MeasuredAfter(test::CampaignOf(configurations, 1, kSigma, 11), 111, move));
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
  EXPECT_GT(bagged.Of(strong), 0.9);
  EXPECT_GT(whole.Of(weak), 0.8);
  EXPECT_LT(bagged.Of(weak), 0.7);
}

// The poses as they are count as one resample: in addition to them each of these has one share, however many sets it
// has.
TEST(BaggedModels, EveryResampleHasOneShare) {
  const std::unique_ptr<Evidence> evidence = Weigh(40);
  const std::vector<WeightedModel> models = Bagged(*evidence);
  const size_t own = evidence->models().size();
  ASSERT_GE(models.size(), own + kResamples);
  EXPECT_NEAR(Sum(models), 1.0, 1e-12);
  const Posterior whole = PosteriorOf(*evidence, evidence->models()), bagged = PosteriorOf(*evidence, models);
  int between = 0;
  for (const NamedProbability& entry : bagged.explanations) {
    const double of_resamples = (kResamples + 1) * entry.probability - whole.Of(entry.name);
    EXPECT_GE(of_resamples, -1e-9) << entry.name;
    EXPECT_LE(of_resamples, kResamples + 1e-9) << entry.name;
    between += of_resamples > 0.5 && of_resamples < kResamples - 0.5 ? 1 : 0;
  }
  EXPECT_GT(between, 0);
}

// On a lattice of 45 degrees cos(6 q) = cos(2 q) and sin(6 q) = -sin(2 q): neither order is more probable, on whichever
// poses.
TEST(BaggedModels, WhatIsTheSameSharesOnEveryResample) {
  Measurements data = test::DesignMeasurements(test::CampaignOf(40, 1, kSigma, 11));
  for (Configuration& configuration : data.configurations) {
    configuration.q[2] = 0.25 * M_PI * std::round(configuration.q[2] / (0.25 * M_PI));
  }
  Measurements moved = data;
  for (Configuration& configuration : moved.configurations) {
    configuration.q[2] += kStrong * std::cos(2.0 * configuration.q[2]);
  }
  test::MeasureKr270(test::Kr270Truth(), kSigma, 111, &moved);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    data.observations[i].point_in_station = moved.observations[i].point_in_station;
  }
  const std::unique_ptr<Evidence> evidence = Weigh(data);
  const Posterior whole = PosteriorOf(*evidence, evidence->models());
  const Posterior bagged = PosteriorOf(*evidence, Bagged(*evidence));
  for (const char* order : {"2", "6"}) {
    SCOPED_TRACE(order);
    double of_all = 0.0, of_resamples = 0.0;
    for (const NamedProbability& entry : whole.explanations) {
      if (entry.name.find("[order=" + std::string(order) + "]/") != std::string::npos) {
        of_all = std::max(of_all, entry.probability);
        of_resamples = std::max(of_resamples, bagged.Of(entry.name));
      }
    }
    EXPECT_GT(of_all, 0.3);
    EXPECT_NEAR(of_resamples, of_all, 0.1);
  }
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
