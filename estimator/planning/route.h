// In which order poses are measured.
//
// Travel from one pose to the next is the largest joint motion, as a share of the joint's range: joints move together
// and the slowest decides; speeds are not known. A route starts at the pose nearest to the middle of all, goes to the
// nearest one that is left, and is improved by reversing stretches (2-opt; Croes, Operations Research 6, 1958) and by
// moving single poses (Or 1976) until neither helps. That is a heuristic: the shortest route is not looked for.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace sagitta {

// q: rad or m. kind: poses of one kind are measured one after the other (station and load change between kinds), kinds
// in ascending order. Returns the order.
std::vector<int> ShortRoute(const std::vector<Eigen::VectorXd>& q, const std::vector<int>& kind);
// Seeded: time does not go with the place.
std::vector<int> MixedRoute(int poses, std::uint64_t seed);

// Sum along an order.
double TravelOf(const std::vector<Eigen::VectorXd>& q, const std::vector<int>& order);

}  // namespace sagitta
