// What to measure next: poses at which the explanations that still share the probability say different things
// (pose_choice.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimator/evidence/evidence.h"

namespace sagitta {

struct ProposedPose {
  Eigen::VectorXd q;  // rad or m
  int like = 0;       // configuration of the data whose loads, stations and markers it is measured with
};

// What to measure next, and what it is expected to decide. decides, decided, needed: shares of what the rivals have
// together, if one of them is right.
struct NextPoses {
  bool again =
      false;  // poses of the data, visited once more (revisits.h): no rivals, nothing of what they have together
  std::vector<ProposedPose> poses;
  std::vector<NamedSet> rivals;  // that the poses are to decide between, most probable first
  double of_probability = 0.0;   // that they have together
  // Readings in which an effect is a piece of a cause without a name count as sets that hold both: no pose shows which
  // it is. Of such readings there are enough to be seen in the probabilities.
  bool counts_pieces = false;
  bool depends_on_when = false;  // time or temperature drives one of them, which poses measured at once do not change
  double decides = 0.0;          // that the right one is expected to have after measuring the poses
  double decided = 0.0;          // that it has now, expected in the same way: the sum of squared shares
  int needed = 0;                // poses like these, after which it is expected to be kWanted; 0: more than kMostNeeded
};

constexpr int kPosesProposed = 6;  // a tenth of a usual campaign
constexpr double kWanted = 0.9;    // of the right answer: nine in ten, a choice that docs/DIAGNOSIS.md states
constexpr int kMostNeeded = 60;    // as long as a usual campaign

// Shots that a proposed pose is measured with, among those of the configuration that it is like: of each station and
// load those of the first visit that has it, for a home pose is not visited ten times more.
std::vector<int> ShotsOfProposal(const Measurements& data, int configuration);

// None where one explanation has it all. problem, parameters: what the evidence was made of.
std::optional<NextPoses> ProposeNext(const Evidence& evidence, const CalibrationProblem& problem,
                                     const ParameterSet& parameters);

}  // namespace sagitta
