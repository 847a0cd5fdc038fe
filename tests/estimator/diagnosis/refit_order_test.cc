// Refits go on as far as they move the evidence.
#include "estimator/diagnosis/refit_order.h"

#include <gtest/gtest.h>

#include <limits>

namespace sagitta::refit_order_test {
namespace {

NameSet SetOf(const std::vector<int>& names, double probability) {
  NameSet set;
  set.names = set.effects = names;
  set.probability = probability;
  return set;
}

TEST(RefitOrder, WhereRefitsChangeNothingSetsOfATwentiethFollow) {
  Posterior posterior;
  posterior.sets = {SetOf({1}, 0.80), SetOf({2}, 0.16), SetOf({3}, 0.03), SetOf({4}, 0.01)};
  RefitOrder order(posterior);
  order.Add(0, 0.0);
  EXPECT_EQ(order.Next(), 1u);
  order.Add(1, 0.0);
  EXPECT_EQ(order.Next(), 4u);  // 0.03 is less than 0.05 of 0.80
}

// The leading set loses e^3: the third may then lead by 0.03 / (0.80 e^-3), and by what its own evidence may be off.
TEST(RefitOrder, WhatARefitMovesOthersMayBeOffBy) {
  Posterior posterior;
  posterior.sets = {SetOf({1}, 0.80), SetOf({1, 5}, 0.03), SetOf({3}, 1e-4), SetOf({4}, 1e-7)};
  RefitOrder order(posterior);
  order.Add(0, -3.0);
  // {1, 5} holds {1} and loses with it: 0.03 e^-3 is less than 0.05 * 0.80 e^-3. {3}: 1e-4 e^3 is 0.05 * 0.80 e^-3 at
  // least.
  EXPECT_EQ(order.Next(), 2u);
  order.Add(2, 0.5);
  EXPECT_EQ(order.Next(), 4u);
  EXPECT_EQ(order.CorrectionOf(1), -3.0);
  EXPECT_EQ(order.CorrectionOf(2), 0.5);
  EXPECT_EQ(order.CorrectionOf(3), 0.0);
}

TEST(RefitOrder, WhatHasNoNameIsNotRefitted) {
  Posterior posterior;
  posterior.sets = {SetOf({1}, 0.5), SetOf({2}, 0.5)};
  posterior.sets[1].has_unnamed = true;
  RefitOrder order(posterior);
  order.Add(0, -5.0);
  EXPECT_EQ(order.Next(), 2u);
}

// Half of it is nameless and the full model says nothing of that; what it says of a piece counts.
TEST(RefitOrder, ANamelessCauseIsAsWrongAsItsPieces) {
  Posterior posterior;
  posterior.sets = {SetOf({7}, 0.6), SetOf({1}, 0.3), SetOf({2}, 0.1)};
  posterior.sets[0].has_unnamed = true;
  posterior.sets[0].pieces = {1};
  RefitOrder order(posterior);
  order.Add(0, std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(order.CorrectionOf(0), 0.0);
  EXPECT_EQ(order.Next(), 1u);
  order.Add(1, -8.0);
  EXPECT_EQ(order.CorrectionOf(0), -8.0);
  EXPECT_EQ(order.Next(), 2u);
}

}  // namespace
}  // namespace sagitta::refit_order_test
