// The order of poses: short routes against the shortest one of all, found by trying every order.
#include "estimator/planning/route.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace sagitta::route_test {
namespace {

std::vector<Eigen::VectorXd> RandomPoses(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Eigen::VectorXd> poses(count, Eigen::VectorXd(3));
  for (Eigen::VectorXd& q : poses) {
    for (double& value : q) value = static_cast<double>(random() >> 11) * 0x1.0p-53;
  }
  return poses;
}

TEST(RouteTest, IsNearTheShortestOfAllOrders) {
  double longest = 0.0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const std::vector<Eigen::VectorXd> q = RandomPoses(8, seed);
    std::vector<int> order(8);
    std::iota(order.begin(), order.end(), 0);
    double least = 1e9;
    do {
      least = std::min(least, TravelOf(q, order));
    } while (std::next_permutation(order.begin(), order.end()));
    const std::vector<int> route = ShortRoute(q, std::vector<int>(8, 0));
    EXPECT_GE(TravelOf(q, route), least - 1e-12);
    longest = std::max(longest, TravelOf(q, route) / least);
    std::vector<int> sorted = route;
    std::sort(sorted.begin(), sorted.end());
    for (int i = 0; i < 8; ++i) EXPECT_EQ(sorted[i], i);
  }
  EXPECT_LT(longest, 1.15);
}

TEST(RouteTest, StationsAndLoadsChangeOnce) {
  const std::vector<Eigen::VectorXd> q = RandomPoses(30, 3);
  std::vector<int> kind(30);
  for (int i = 0; i < 30; ++i) kind[i] = i % 3;
  const std::vector<int> route = ShortRoute(q, kind);
  ASSERT_EQ(route.size(), 30u);
  for (int k = 1; k < 30; ++k) EXPECT_GE(kind[route[k]], kind[route[k - 1]]);
}

TEST(RouteTest, AMixedOneIsAPermutation) {
  std::vector<int> order = MixedRoute(50, 7);
  EXPECT_NE(order, MixedRoute(50, 8));
  std::sort(order.begin(), order.end());
  for (int i = 0; i < 50; ++i) EXPECT_EQ(order[i], i);
}

}  // namespace
}  // namespace sagitta::route_test
