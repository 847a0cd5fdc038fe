// What no machine has less than nothing of, its prior, and what is said of a value that a machine does not show.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/diagnosis/physical_bounds.h"
#include "estimator/random_effects/set_search.h"
#include "estimator/report/diagnosis_words.h"
#include "estimator/statistics/distributions.h"
#include "models/effects/catalogue.h"
#include "tests/support/moved_kr270.h"
#include "tests/support/small_evidence.h"

namespace sagitta::signs_test {
namespace {

using test::Integrate;
using test::kInfinity;
using test::Small;
using ::testing::HasSubstr;

// The residual is predicted minus measured: a column that is there with a > 0 makes it -a times the column.
Small WithOne(double value) {
  Small small(12, 4, 1, 5);
  small.residual -= value * small.columns.col(0);
  return small;
}

// The half of the normal prior, by quadrature over what the coefficient may be.
TEST(Signs, TheEvidenceIsThatOfHalfThePrior) {
  for (const double value : {-0.4, 0.0, 0.4}) {
    const Small small = WithOne(value);
    const ProjectedNormal normal = small.Normal();
    for (const double scale : {0.3, 1.0}) {
      const auto density = [&](double a) {
        Small left = small;
        left.residual += a * small.columns.col(0);
        return 2.0 * std::exp(-0.5 * a * a / (scale * scale)) / (scale * std::sqrt(2.0 * M_PI)) *
               std::exp(left.LogDensity(Eigen::MatrixXd::Zero(1, 1)));
      };
      const GivenOthers given{test::AllOf(normal), normal.gradient, normal.residual, 0.0, kNumScales, {0}};
      const double whole = small.LogDensity(Eigen::MatrixXd::Constant(1, 1, scale));
      EXPECT_NEAR(LogOfSigns({normal.dof, kInfinity, 0.0}, given, scale),
                  std::log(Integrate(density, 0.0, 12.0 * scale)) - whole, 1e-6)
          << value << " at " << scale;
    }
  }
}

// Where nothing states sigma: by quadrature over its factor, too, even in the logarithm. Sigma as assumed is three
// times too large, or too small.
TEST(Signs, WhereSigmaIsOpenTheyAreAveragedOverItsFactor) {
  for (const double noise : {1.0 / 3.0, 3.0}) {
    Small small = WithOne(-0.5);
    small.residual *= noise;
    const ProjectedNormal normal = small.Normal();
    const double scale = 0.3;
    // log of the integral over f of  f^-n exp(-(R - g a) / 2 f^2) P(a > 0 | r, f)  over the same without P
    const double t = 1.0 / (scale * scale) + test::AllOf(normal)(0, 0), value = -normal.gradient[0] / t;
    const double residual = normal.residual + normal.gradient[0] * value;
    const auto weight = [&](double log_f) {
      return std::exp(-normal.dof * log_f - 0.5 * residual * std::exp(-2.0 * log_f));
    };
    const auto of_positive = [&](double log_f) {
      return weight(log_f) * std::erfc(-value * std::sqrt(0.5 * t) * std::exp(-log_f));  // 2 P
    };
    const GivenOthers given{test::AllOf(normal), normal.gradient, normal.residual, 0.0, kNumScales, {0}};
    EXPECT_NEAR(LogOfSigns({normal.dof, 0.0, 1.0}, given, scale),
                std::log(Integrate(of_positive, -6.0, 6.0) / Integrate(weight, -6.0, 6.0)), 1e-6)
        << noise;
  }
}

TEST(Signs, NothingIsSaidOfWhatMayHaveEither) {
  const ProjectedNormal normal = WithOne(-3.0).Normal();
  EXPECT_EQ(LogOfSigns({normal.dof, kInfinity, 0.0}, {test::AllOf(normal), normal.gradient, normal.residual}, 1.0),
            0.0);
}

TEST(Signs, TheNormalDistributionKeepsItsLogarithmFarOut) {
  EXPECT_NEAR(LogNormalCdf(0.0), std::log(0.5), 1e-15);
  EXPECT_NEAR(LogNormalCdf(1.959964), std::log(0.975), 1e-8);
  // -x^2/2 - log(-x sqrt(2 pi)) - 1/x^2, an asymptotic series.
  EXPECT_NEAR(LogNormalCdf(-20.0), -200.0 - std::log(20.0 * std::sqrt(2.0 * M_PI)) - 1.0 / 400.0, 1e-4);
  EXPECT_TRUE(std::isfinite(LogNormalCdf(-1e9)));
}

// Two columns nearly alike, one of which has one sign only.
std::vector<int> FoundAt(double value) {
  Small small(60, 3, 2, 11);
  small.columns.col(1) = small.columns.col(0) + 0.3 * small.columns.col(1);
  small.residual -= value * small.columns.col(0);
  std::vector<Explanation> list = {{{{0}, {}}, 0.5, 0}, {{{1}, {}}, 0.5, 1}};
  list[0].group.not_negative = {0};
  const ProjectedNormal normal = small.Normal();
  SetSearch search(normal, list, {0.5, 0.3}, ResidualLikelihood(normal.dof, kInfinity, 0.05));
  search.ClimbFrom();
  search.Explore();
  return search.Best().members;
}

TEST(Signs, TheWrongOneGivesWayToWhatDoesTheSame) {
  EXPECT_EQ(FoundAt(1.5), std::vector<int>{0});
  EXPECT_EQ(FoundAt(-1.5), std::vector<int>{1});
}

// In a set, too, and where it comes with what it needs.
TEST(Signs, OfASetTheyAreThoseOfItsMembers) {
  Small small(40, 3, 3, 21);
  small.residual += 0.3 * small.columns.col(1);
  const ProjectedNormal normal = small.Normal();
  std::vector<Explanation> list = {{{{0}, {}}, 0.3, 0}, {{{1}, {}}, 0.3, 1}, {{{2}, {}}, 0.4, 2}};
  const ResidualLikelihood known(normal.dof, kInfinity, 0.0);
  const SetPrior prior{0.5, 0.3};
  const WeightedSet without = SetSearch(normal, list, prior, known).Evaluate({0, 1, 2});
  std::vector<Explanation> with = list;
  with[1].group.not_negative = {0};
  const WeightedSet signed_set = SetSearch(normal, with, prior, known).Evaluate({0, 1, 2});
  const std::vector<const ColumnGroup*> groups = GroupsOf(list, {0, 1, 2});
  const GroupValues own = ValuesOf(normal, groups, without.scales).Of(1, groups);
  const double z = own.values[0] / std::sqrt(own.covariance(0, 0));
  EXPECT_GT(std::abs(z), 0.1);
  EXPECT_NEAR(signed_set.log_weight - without.log_weight, std::log(2.0) + LogNormalCdf(z), 1e-9);
  EXPECT_EQ(Joined(list[0].group, with[1].group).not_negative, std::vector<int>{1});
}

// The effects whose parameters they are; a compliance that corrects a stated one may be less.
TEST(Signs, OfTheCatalogueAreThoseOfMassesGapsAndWhatGivesWayOrGrows) {
  Robot robot = test::Kr270Robot();
  const auto one_sided = [&](const EffectDefinition& definition, const std::string& target) {
    std::vector<std::string> names;
    for (const EffectParameter& own : definition.parameters(robot, {definition.name, target, {}, {}})) {
      if (own.not_negative) names.push_back(own.name);
    }
    return names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(one_sided(TransverseCompliance(), "A2"), (Names{"ku", "kv"}));
  EXPECT_EQ(one_sided(BaseCompliance(), ""), (Names{"kx", "ky"}));
  EXPECT_EQ(one_sided(LinkGravity(), "A2"), Names{"mass"});
  EXPECT_EQ(one_sided(Backlash(), "A2"), Names{"half_gap"});
  EXPECT_EQ(one_sided(ThermalGrowth(), ""), Names{"growth"});
  EXPECT_EQ(one_sided(JointHarmonic(), "A2"), Names{});
  robot.compliances.clear();
  EXPECT_EQ(one_sided(JointComplianceEffect(), "A2"), Names{"k"});
  robot.compliances = {{1, {{0.0, 2.1e-6}}, false}};
  EXPECT_EQ(one_sided(JointComplianceEffect(), "A2"), Names{});
}

}  // namespace
}  // namespace sagitta::signs_test
