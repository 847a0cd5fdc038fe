// Poses that a plan may choose from, each with the shots that the experiment has of a configuration.
//
// Joint values are a Halton sequence in as many prime bases as joints (Halton 1960), rotated by a seeded shift: they
// fill their ranges evenly and are the same on every machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/chain.h"
#include "problems/cell.h"
#include "problems/measurements.h"

namespace sagitta {

// The ranges that poses are drawn in: the joints' limits, narrowed by the cell's (null: none).
// Throws InputError for a joint without limits, or one whose range is empty.
std::vector<JointRange> DrawingRanges(const Chain& chain, const Cell* cell);

// Joint vectors, rad or m, one after the other; with each a sign per joint, as often -1 as +1: from which side it is
// approached, where that matters.
class PoseSequence {
 public:
  struct Drawn {
    Eigen::VectorXd q;
    std::vector<int> approach;
  };
  PoseSequence(std::vector<JointRange> ranges, std::uint64_t seed);
  Drawn Next();

 private:
  double Share(int dimension) const;  // 0 to 1

  std::vector<JointRange> ranges_;
  Eigen::VectorXd shift_;
  int drawn_ = 0;
};

// What is measured at a configuration: station, load and markers of each of its shots, and which shots share a visit.
// One calibration configuration of the data stands for all that are measured alike; the most frequent ones first, at
// most `most`.
struct ShotPatterns {
  std::vector<int> configurations;      // of the data
  std::vector<std::vector<int>> alike;  // of each: all that are measured like it, itself the first
  int left_out = 0;                     // patterns beyond `most`
};
ShotPatterns PatternsOf(const Measurements& data, int most);

// Shots of each configuration, observations of each configuration.
std::vector<std::vector<int>> ShotsByConfiguration(const Measurements& data);
std::vector<std::vector<int>> ObservationsByConfiguration(const Measurements& data);

// Appends a configuration of `from` with the listed shots, which are its own, and their observations; q and id in place
// of its own where q is not empty: then its rows are of no file, because the cells of one say where it was measured.
// Stations and markers are found by name; throws InputError for one that `to` lacks. Returns its index in `to`.
int AppendConfiguration(const Measurements& from, int configuration, const std::vector<int>& shots,
                        const Eigen::VectorXd& q, const std::string& id, Measurements* to);

}  // namespace sagitta
