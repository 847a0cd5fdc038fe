// What to measure next: poses at which the explanations that still share the probability say different things.
//
// Explanation i predicts new whitened rows as N(m_i, V_i), V_i = I + R N_i^-1 R' with what is known so far. A reading
// tells i from j by
//
//   D_ij = (m_i - m_j)' ((V_i + V_j) / 2)^-1 (m_i - m_j)
//
// (twice the expected log Bayes factor for small differences). Poses are taken one after the other, each the one of
// many drawn that makes the mutual information between the explanation and the readings largest
// (statistics/mutual_information.h), which is what `plan --discriminate` goes by too.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimator/diagnosis/posterior.h"

namespace sagitta {

struct ProposedPose {
  Eigen::VectorXd q;  // rad or m
  int like = 0;       // configuration of the data whose loads, stations and markers it is measured with
};

// What to measure next, and what it is expected to decide.
struct NextPoses {
  std::vector<ProposedPose> poses;
  double decides = 0.0;  // probability that the right explanation is expected to have after measuring them
  double decided = 0.0;  // that it has now, expected in the same way: the sum of squared probabilities
  int needed = 0;        // poses like these, after which it is expected to be kWanted; 0: more than kMostNeeded
};

constexpr int kPosesProposed = 6;
constexpr double kWanted = 0.9;
constexpr int kMostNeeded = 60;  // as long as a usual campaign

// None where one explanation has it all. problem, parameters: what the evidence was made of.
std::optional<NextPoses> ProposeNext(const Evidence& evidence, const Posterior& posterior,
                                     const CalibrationProblem& problem, const ParameterSet& parameters,
                                     unsigned long long seed);

}  // namespace sagitta
