// Which effects of a posterior are named, and what more is missing: by hand.
#include "estimator/evidence/posterior.h"

#include <gtest/gtest.h>

namespace sagitta::posterior_test {
namespace {

NameSet Set(std::vector<int> names, double probability) {
  NameSet set;
  set.names = set.effects = std::move(names);
  set.probability = probability;
  return set;
}

TEST(SetPrior, ThePriorIsThatOfDrawsInAnyOrder) {
  const SetPrior prior{0.5, 0.3};
  EXPECT_NEAR(prior.Log({}), std::log(0.5), 1e-12);
  EXPECT_NEAR(prior.Log({0.1}), std::log(0.5 * 0.1), 1e-12);
  EXPECT_NEAR(prior.Log({0.1, 0.2}), std::log(0.5 * 0.3 * 2.0 * 0.1 * 0.2), 1e-12);
}

TEST(Posterior, NamesWhatHasEvenOddsOrMoreThanWhatHasNoName) {
  Posterior posterior;
  posterior.unnamed = 0.2;
  EXPECT_TRUE(posterior.IsNamed(0.3));  // another name has its place with 0.5
  EXPECT_FALSE(posterior.IsNamed(0.1));
  posterior.unnamed = 0.95;  // in addition to what has a name
  EXPECT_TRUE(posterior.IsNamed(0.6));
  EXPECT_FALSE(posterior.IsNamed(0.4));
}

TEST(Posterior, CountsTheSetsThatHoldMoreThanIsNamed) {
  Posterior posterior;
  posterior.nothing = 0.01;
  posterior.sets = {Set({1}, 0.4), Set({1, 2}, 0.3), Set({3}, 0.09), Set({1, 2, 3}, 0.2)};
  EXPECT_NEAR(posterior.MoreThan(0), 0.99, 1e-12);
  EXPECT_NEAR(posterior.MoreThan(1), 0.5, 1e-12);
  EXPECT_NEAR(posterior.MoreThan(2), 0.2, 1e-12);
  EXPECT_EQ(posterior.MoreThan(3), 0.0);
}

NameSet Nameless(int function, double probability) {
  NameSet set = Set({function}, probability);
  set.effects.clear();
  set.has_unnamed = true;
  return set;
}

// Many sets share the probability, most hold the first effect: it is named. What is more probable to be added than the
// gate asks is; what each alone holds is not, where the first effect alone may be enough.
TEST(Posterior, TheLeadingSetHoldsWhatMostSetsHold) {
  Posterior posterior;
  posterior.sets = {Nameless(50, 0.2), Set({1, 2}, 0.19), Set({1, 3}, 0.18), Set({1}, 0.09)};
  for (int other = 4; other < 14; ++other) posterior.sets.push_back(Set({1, other}, 0.034));
  EXPECT_EQ(posterior.sets[posterior.Leading(0.9)].effects, (std::vector<int>{1}));
  posterior.sets[3].probability = 0.07;
  EXPECT_EQ(posterior.sets[posterior.Leading(0.9)].effects, (std::vector<int>{1, 2}));
}

// Two effects do the same: one is named, although either has even odds.
TEST(Posterior, TheLeadingSetHoldsOneOfTwoThatDoTheSame) {
  Posterior posterior;
  posterior.sets = {Set({1, 2}, 0.49), Set({1, 3}, 0.48), Set({1, 2, 3}, 0.03)};
  EXPECT_EQ(posterior.sets[posterior.Leading(0.9)].effects, (std::vector<int>{1, 2}));
  posterior.sets = {Set({2}, 0.4), Set({3}, 0.35), Set({1}, 0.15), Nameless(50, 0.1)};
  EXPECT_EQ(posterior.Leading(0.9), 0u);
}

// Given the first effect something more is there: with a name, if that is more probable than that it has none.
TEST(Posterior, TheLeadingSetHoldsWhatMoreThanTheFirstHasAName) {
  Posterior posterior;
  NameSet with_function = Set({1}, 0.4);
  with_function.has_unnamed = true;
  posterior.sets = {Set({1, 2, 3}, 0.55), with_function, Set({1}, 0.05)};
  EXPECT_EQ(posterior.sets[posterior.Leading(0.9)].effects, (std::vector<int>{1, 2, 3}));
  posterior.sets = {Set({1, 2, 3}, 0.4), with_function, Set({1}, 0.2)};  // nothing more, perhaps
  EXPECT_EQ(posterior.sets[posterior.Leading(0.9)].effects, (std::vector<int>{1}));
  posterior.sets[0].probability = 0.35;
  posterior.sets[1].probability = 0.6;
  posterior.sets[2].probability = 0.05;
  EXPECT_EQ(posterior.Leading(0.9), 1u);
}

// What has no name is more probable than any effect.
TEST(Posterior, TheLeadingSetMayHaveNoName) {
  Posterior posterior;
  posterior.sets = {Set({2}, 0.3), Nameless(50, 0.25), Nameless(51, 0.25), Set({3}, 0.2)};
  EXPECT_EQ(posterior.Leading(0.9), 1u);
}

}  // namespace
}  // namespace sagitta::posterior_test
