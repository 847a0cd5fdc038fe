// Which of many candidates to measure, and how good any choice can be. Numbers only: rows of a whitened Jacobian.
//
// A candidate i brings information A_i' A_i; N of them, given what is known already (M0), M = M0 + sum n_i A_i' A_i.
// The approximate design lets n_i = N w_i be any share. It is solved by the multiplicative algorithm (Silvey,
// Titterington and Torsney 1978; Yu, Annals of Statistics 38, 2010), w_i <- w_i d_i^p / sum, d_i = tr(G A_i' A_i) with
// G = -d cost / d M, p as large as still descends, on those candidates alone that have gained most so far (column
// generation). By convexity, for any plan of N of the candidates (general equivalence theorem, Kiefer 1974),
//
//   cost(plan) >= cost(w) - N (max_i d_i - sum_i w_i d_i)
//
// over all of them, which is the certificate. The exact plan comes from greedy growth and draws from w, improved by
// exchange with block updates of C (Fedorov 1972; Mitchell 1974), each by every candidate that d_i does not rule out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "estimator/planning/criterion.h"

namespace sagitta {

struct CandidateSet {
  Eigen::MatrixXd rows;    // of all candidates, one below the other; a column per parameter
  std::vector<int> first;  // row of each candidate, and one more: the number of rows
  int size() const { return static_cast<int>(first.size()) - 1; }
  int count(int i) const { return first[i + 1] - first[i]; }
  auto of(int i) const { return rows.middleRows(first[i], count(i)); }

  CandidateSet Subset(const std::vector<int>& candidates) const;
  void Append(const std::vector<Eigen::MatrixXd>& candidates);
};

// d_i = tr(A_i G A_i') of every candidate.
Eigen::VectorXd GainsOf(const CandidateSet& set, const Eigen::MatrixXd& slope);

// Weights of the candidates, and the bound that they prove.
struct ApproximateDesign {
  Eigen::VectorXd weights;  // sum 1
  double cost = 0.0;        // at N times the weights
  double bound = 0.0;       // no plan of N candidates costs less
  Eigen::VectorXd gain;     // d_i at the end
  Eigen::MatrixXd slope;    // G at the end
  int iterations = 0;
};

// known: M0, positive definite. tolerance: of the bound, relative to the cost's scale; the search ends there.
// start: weights to begin with, null: even ones.
ApproximateDesign SolveApproximate(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion,
                                   double poses, double tolerance, int max_iterations = 3000,
                                   const Eigen::VectorXd* start = nullptr);

// A list of candidates to measure.
struct ExactDesign {
  std::vector<int> picks;      // candidates, in the order of the list; some may come twice
  Eigen::MatrixXd covariance;  // scaled
  double cost = 0.0;
};

// How the exchange searches.
struct ExactOptions {
  int starts = 3;
  int rounds = 20;       // of exchange, at most
  bool repeats = true;   // a pose may be chosen again
  int max_trials = 300;  // candidates that an exchange tries: those of the largest d_i
  std::uint64_t seed = 1;
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const ExactOptions& options);

// From the approximate design by exchange; known: M0, positive definite.
ExactDesign SolveExact(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion, int poses,
                       const ApproximateDesign& approximate, const ExactOptions& options = {});

// C of a list of candidates.
Eigen::MatrixXd CovarianceOf(const CandidateSet& set, const Eigen::MatrixXd& known, const std::vector<int>& picks);
// C after A' A is added (sign 1) or removed (-1).
Eigen::MatrixXd Updated(const Eigen::MatrixXd& c, const Eigen::MatrixXd& a, double sign);

// What the cost becomes where one more candidate is added to what left covariance C.
class CostGiven {
 public:
  CostGiven(const Criterion& criterion, const Eigen::MatrixXd& covariance);
  double With(const Eigen::MatrixXd& rows) const;

 private:
  const Criterion& criterion_;
  const Eigen::MatrixXd& c_;
  std::vector<int> columns_;
  Eigen::MatrixXd block_;   // what of C the cost depends on
  Eigen::MatrixXd middle_;  // of I: C W C; of D: C - C_:S C_SS^-1 C_S:; of A: C_:S C_S:
  double now_ = 0.0;
};

// Those of the largest values.
std::vector<int> Foremost(const Eigen::VectorXd& values, int most);

}  // namespace sagitta
