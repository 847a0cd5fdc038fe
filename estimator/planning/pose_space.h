// Candidates of a plan: poses in the joint limits, each with the shots that the experiment takes of a configuration.
//
// Joint values are a Halton sequence in as many prime bases as joints (Halton 1960), rotated by a seeded shift: they
// fill the limits evenly and are the same on every machine. Feasible means within the joint limits and with an
// equilibrium under the load. Collisions, line of sight and reflector acceptance are not checked.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/chain.h"
#include "problems/measurements.h"

namespace sagitta {

// `count` joint vectors, rad or m. Throws InputError for a joint without limits.
std::vector<Eigen::VectorXd> PosesInLimits(const Chain& chain, int count, std::uint64_t seed);

// Empty, or which joint of the configuration is outside its limits, in words.
std::string OutsideLimits(const Chain& chain, const Eigen::VectorXd& q);

// What is measured at a configuration: station, load and markers of each of its shots. One configuration of the data
// stands for all that are measured alike; the most frequent ones first, at most `most`.
struct ShotPatterns {
  std::vector<int> configurations;  // of the data
  int left_out = 0;                 // patterns beyond `most`
};
ShotPatterns PatternsOf(const Measurements& data, int most);

// Appends a configuration of `from` with its shots and observations; q and id in place of its own where q is not empty.
// Stations and markers are found by name; throws InputError for one that `to` lacks. Returns its index in `to`.
int AppendConfiguration(const Measurements& from, int configuration, const Eigen::VectorXd& q, const std::string& id,
                        Measurements* to);

// Observations of each configuration.
std::vector<std::vector<int>> ObservationsByConfiguration(const Measurements& data);

}  // namespace sagitta
