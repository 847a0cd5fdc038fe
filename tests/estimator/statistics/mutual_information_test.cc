// Information between explanations and readings, against integrals over the readings themselves.
#include "estimator/statistics/mutual_information.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace sagitta::mutual_information_test {
namespace {

// Explanations predict means of one reading of variance 1: information = entropy of the reading - that of its noise,
// decides = integral of sum_i (p_i N_i)^2 / sum_j p_j N_j, both over the reading.
struct OfReading {
  double information = 0.0, decides = 0.0;
};
OfReading Integrated(const Eigen::VectorXd& p, const Eigen::VectorXd& means) {
  OfReading of;
  const double step = 1e-3;
  for (double y = means.minCoeff() - 12.0; y < means.maxCoeff() + 12.0; y += step) {
    const Eigen::ArrayXd each = p.array() * (-0.5 * (y - means.array()).square()).exp() / std::sqrt(2.0 * M_PI);
    const double all = each.sum();
    if (all < 1e-300) continue;
    of.information -= step * all * std::log(all);
    of.decides += step * each.square().sum() / all;
  }
  of.information -= 0.5 * std::log(2.0 * M_PI * std::exp(1.0));
  return of;
}

// Each explanation has a name of its own.
std::vector<int> OwnNames(const Eigen::VectorXd& p) {
  std::vector<int> names(static_cast<size_t>(p.size()));
  std::iota(names.begin(), names.end(), 0);
  return names;
}

Eigen::MatrixXd ApartOf(const Eigen::VectorXd& means) {
  Eigen::MatrixXd apart(means.size(), means.size());
  for (Eigen::Index i = 0; i < means.size(); ++i) {
    for (Eigen::Index j = 0; j < means.size(); ++j) apart(i, j) = std::pow(means[i] - means[j], 2);
  }
  return apart;
}

TEST(MutualInformationTest, OfTwoIsTheIntegralOverTheReading) {
  for (const double distance : {0.0, 0.1, 1.0, 3.0, 8.0}) {
    for (const double first : {0.5, 0.9}) {
      const Eigen::Vector2d p(first, 1.0 - first), means(0.0, distance);
      const OfReading exact = Integrated(p, means);
      EXPECT_NEAR(MutualInformation(p, OwnNames(p), ApartOf(means)), exact.information, 1e-6) << distance;
      EXPECT_NEAR(ExpectedProbability(p, OwnNames(p), ApartOf(means)), exact.decides, 1e-6) << distance;
    }
    const TwoApart two = InformationOfTwo(distance * distance);
    const OfReading exact = Integrated(Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(0.0, distance));
    EXPECT_NEAR(two.information, exact.information, 1e-6);
    EXPECT_NEAR(two.decides, exact.decides, 1e-6);
  }
}

// Odds of three predictions on a line do not move together. Treated as if they did, the information errs by less than a
// tenth of all there is to know.
TEST(MutualInformationTest, OfThreeIsNearTheIntegral) {
  const Eigen::Vector3d p(0.5, 0.3, 0.2);
  const double all = -(p.array() * p.array().log()).sum();
  for (const double distance : {0.5, 2.0, 6.0}) {
    const Eigen::Vector3d means(0.0, distance, 2.0 * distance);
    EXPECT_NEAR(MutualInformation(p, OwnNames(p), ApartOf(means)), Integrated(p, means).information, 0.1 * all)
        << distance;
  }
  // Nothing distinguished: what was known before. All distinguished: the entropy.
  EXPECT_NEAR(ExpectedProbability(p, OwnNames(p), Eigen::Matrix3d::Zero()), p.squaredNorm(), 1e-12);
  EXPECT_NEAR(MutualInformation(p, OwnNames(p), Eigen::Matrix3d::Zero()), 0.0, 1e-12);
  Eigen::Matrix3d far = Eigen::Matrix3d::Constant(500.0);
  far.diagonal().setZero();
  EXPECT_NEAR(MutualInformation(p, OwnNames(p), 1e12 * far), all, 1e-9);
  EXPECT_NEAR(MutualInformation(p, OwnNames(p), far), all, 1e-9);
  EXPECT_NEAR(ExpectedProbability(p, OwnNames(p), far), 1.0, 1e-9);
}

// Two that are called alike and predict the same are one, whatever they are apart from each other.
TEST(MutualInformationTest, WhatIsCalledAlikeNeedNotBeToldApart) {
  const Eigen::Vector3d p(0.3, 0.3, 0.4), means(0.0, 0.0, 2.0);
  const Eigen::Vector2d merged(0.6, 0.4);
  Eigen::MatrixXd apart = ApartOf(means);
  apart(0, 1) = apart(1, 0) = 100.0;
  const OfReading exact = Integrated(merged, Eigen::Vector2d(0.0, 2.0));
  EXPECT_NEAR(MutualInformation(merged, {0, 1}, ApartOf(Eigen::Vector2d(0.0, 2.0))), exact.information, 1e-6);
  EXPECT_NEAR(MutualInformation(p, {7, 7, 1}, ApartOf(means)), exact.information, 1e-6);
  EXPECT_NEAR(ExpectedProbability(p, {7, 7, 1}, ApartOf(means)), exact.decides, 1e-6);
  EXPECT_GT(MutualInformation(p, {7, 8, 1}, apart), exact.information + 0.1);
}

TEST(MutualInformationTest, SlopeIsThatOfFiniteDifferencesAndFalls) {
  double last = 0.2;
  for (const double apart : {0.01, 0.3, 2.0, 7.0, 20.0, 60.0}) {
    const double step = 1e-3 * apart;
    const double rises = InformationOfTwo(apart + step).information - InformationOfTwo(apart - step).information;
    const TwoApart here = InformationOfTwo(apart);
    EXPECT_NEAR(here.slope, rises / (2.0 * step), 1e-4 * here.slope + 1e-7);
    EXPECT_LT(here.slope, last);  // concave
    EXPECT_GT(here.slope, 0.0);
    last = here.slope;
  }
  EXPECT_NEAR(InformationOfTwo(1e-9).slope, 0.125, 1e-6);  // s = 1/2: E s^2 / 2
}

}  // namespace
}  // namespace sagitta::mutual_information_test
