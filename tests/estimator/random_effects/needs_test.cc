// Explanations that do nothing without another one: sets hold both, by enumeration of all sets that do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "estimator/random_effects/set_search.h"

namespace sagitta::needs_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Columns and a residual of 60 rows; the first two columns are in it.
ProjectedNormal NormalOf(unsigned seed, double first, double second) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(60, 8, [&] { return normal(random); });
  a.col(2) = a.col(1) + 0.5 * a.col(2);
  a.col(7) = a.col(1) + first / second * a.col(0) + 1.0 * a.col(7);  // imitates both
  Eigen::VectorXd r = Eigen::VectorXd::NullaryExpr(60, [&] { return normal(random); });
  r += first * a.col(0) + second * a.col(1);
  return {Eigen::MatrixXd(a.transpose() * a), a.transpose() * r, r.squaredNorm(), 60.0};
}

// The second and the third do nothing without the first, nor the fifth without one that is not listed.
std::vector<Explanation> List() {
  std::vector<Explanation> list;
  for (int k = 0; k < 9; ++k) list.push_back({{{k}, {}}, 0.125, 10 + k});
  list[1].needs = list[2].needs = 0;
  list[4].needs = 8;
  return WithTheirColumns(list, {0, 1, 2, 3, 4, 5, 6, 7}).explanations;
}

bool HasWhatItNeeds(const std::vector<int>& members) {
  const std::set<int> all(members.begin(), members.end());
  return all.count(4) == 0 && ((all.count(1) == 0 && all.count(2) == 0) || all.count(0) == 1);
}

// That has what it needs.
std::vector<std::vector<int>> EverySet(size_t size) {
  std::vector<std::vector<int>> sets;
  for (int bits = 0; bits < 1 << size; ++bits) {
    std::vector<int> members;
    for (size_t k = 0; k < size; ++k) {
      if ((bits >> k & 1) != 0) members.push_back(static_cast<int>(k));
    }
    if (HasWhatItNeeds(members)) sets.push_back(members);
  }
  return sets;
}

TEST(Needs, SetsHoldWhatTheirMembersNeed) {
  int pairs = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const ProjectedNormal normal = NormalOf(seed, 0.8, -0.9);
    const std::vector<Explanation> list = List();
    SetSearch search(normal, list, {0.5, 0.3}, ResidualLikelihood(normal.dof, kInfinity, 0.05));
    search.ClimbFrom();
    const std::vector<WeightedSet> found = search.Explore();
    double most = -kInfinity, sum = 0.0, kept = 0.0;
    for (const std::vector<int>& members : EverySet(list.size())) {
      const double weight = search.Evaluate(members).log_weight;
      most = std::max(most, weight);
      sum += std::exp(weight);
    }
    for (const WeightedSet& set : found) {
      EXPECT_TRUE(HasWhatItNeeds(set.members)) << "seed " << seed;
      kept += std::exp(set.log_weight);
    }
    EXPECT_NEAR(search.Evaluate(found[0].members).log_weight, most, 1e-9) << "seed " << seed;
    EXPECT_GT(kept, 0.95 * sum) << "seed " << seed;
    EXPECT_LT(kept, 1.05 * sum) << "seed " << seed;
    pairs += found[0].members == std::vector<int>{0, 1};
  }
  EXPECT_GE(pairs, 10);
}

// What comes to a set and lacks what it needs is two causes of the prior; what goes is both.
TEST(Needs, ComeAndGoTogether) {
  const ProjectedNormal normal = NormalOf(3, 3.0, -3.0);
  const std::vector<Explanation> list = List();
  const SetSearch search(normal, list, {0.5, 0.3}, ResidualLikelihood(normal.dof, kInfinity, 0.0));
  const std::vector<double> to_nothing = search.Additions(search.Evaluate({}));
  EXPECT_EQ(to_nothing[4], -kInfinity);
  // One scale for both in place of all combinations of two.
  std::vector<double> logs;
  const std::vector<const ColumnGroup*> both = GroupsOf(list, {0, 1});
  for (const double scale : kScales) {
    const Members members(normal, both, {scale, scale});
    logs.push_back(-0.5 * members.residual() - 0.5 * members.log_det());
  }
  const SetPrior prior{0.5, 0.3};
  EXPECT_NEAR(to_nothing[1], LogMean(logs) + prior.Log({0.125, 0.125}), 1e-9);
  const WeightedSet whole = search.Evaluate({0, 1, 3});
  const std::vector<double> losses = search.LossesOf(whole);
  EXPECT_NEAR(losses[0], whole.log_weight - search.Evaluate({3}).log_weight, 1e-9);
  EXPECT_NEAR(losses[1], whole.log_weight - search.Evaluate({0, 3}).log_weight, 1e-9);
  EXPECT_NEAR(losses[2], whole.log_weight - search.Evaluate({0, 1}).log_weight, 1e-9);
}

// Where every set is to hold a weight, the best is the best of those that do, and no other is kept but that of nothing.
TEST(Needs, SetsHoldAWeightWhereThatIsBeyondDoubt) {
  int others = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ProjectedNormal normal = NormalOf(seed, 0.8, -0.9);
    std::vector<Explanation> list = List();
    list[3].is_weight = list[7].is_weight = true;
    const auto holds = [](const std::vector<int>& members) {
      return std::any_of(members.begin(), members.end(), [](int m) { return m == 3 || m == 7; });
    };
    const ResidualLikelihood likelihood(normal.dof, kInfinity, 0.05);
    SetSearch search(normal, list, {0.5, 0.3, true}, likelihood);
    const SetSearch free(normal, list, {0.5, 0.3}, likelihood);
    search.ClimbFrom();
    const std::vector<WeightedSet> found = search.Explore();
    double most = -kInfinity, most_of_all = -kInfinity, sum = 0.0, kept = 0.0;
    for (const std::vector<int>& members : EverySet(list.size())) {
      const double weight = free.Evaluate(members).log_weight;
      most_of_all = std::max(most_of_all, weight);
      if (!holds(members)) continue;
      EXPECT_NEAR(search.Evaluate(members).log_weight, weight, 1e-9);
      most = std::max(most, weight);
      sum += std::exp(weight);
    }
    for (const WeightedSet& set : found) {
      EXPECT_TRUE(set.members.empty() || holds(set.members)) << "seed " << seed;
      kept += std::exp(set.log_weight);
    }
    EXPECT_NEAR(search.Evaluate(found[0].members).log_weight, most, 1e-9) << "seed " << seed;
    EXPECT_NEAR(kept, sum, 0.05 * sum) << "seed " << seed;
    others += most_of_all > most + 1.0;
    const std::vector<double> losses = search.LossesOf(search.Evaluate({0, 3}));
    EXPECT_GT(losses[1], 1e5) << "seed " << seed;
  }
  EXPECT_GE(others, 5);  // the weight is not what the rows ask for
}

TEST(Needs, GoLastFirst) {
  const std::vector<Explanation> list = List();
  EXPECT_EQ(list[1].needs, 0);
  EXPECT_EQ(list[3].needs, kNoExplanation);
  EXPECT_EQ(list[4].share, 0.0);
  EXPECT_EQ(GoingWith(list, {3, 0, 5, 2}, 1), (std::vector<size_t>{3, 1}));
  EXPECT_EQ(GoingWith(list, {3, 0, 5, 2}, 3), (std::vector<size_t>{3}));
  // Among others it has another place.
  EXPECT_EQ(WithTheirColumns(list, {3, 0, 2}).explanations[2].needs, 1);
}

}  // namespace
}  // namespace sagitta::needs_test
