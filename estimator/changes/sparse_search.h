// Which few of many groups of columns explain a whitened vector, as a posterior over sets.
//
//   r = sum_k A_k a_k + e,   e ~ N(0, I),   a_k ~ N(0, s_k^2 I),   s_k one of kChangeScales with equal probability,
//   P(set) ~ 1/2 for nothing, 1/2 shared alike by single groups, each further group times `further`
//
// With the columns of a set scaled by their s, G = A'A and g = A'r, the evidence over nothing is
//   log B = 1/2 g' (I + G)^-1 g - 1/2 log |I + G|
// (MacKay 1992; the Occam factor is the determinant). Sets are searched by adding, dropping and swapping.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace sagitta {

// Around the typical size of a change, by which columns are scaled: from a tenth of it to thirty times.
constexpr double kChangeScales[] = {0.1, 0.3, 1.0, 3.0, 30.0};
constexpr int kNumChangeScales = 5;

struct SparsePrior {
  double nothing = 0.5;
  double further = 0.3;
};

struct SparsePosterior {
  Eigen::VectorXd probability;  // of each group, over all sets that hold it
  double nothing = 1.0;         // of the empty set
  std::vector<int> best;        // groups of the most probable set
  // Of each one's columns in that set at the widest scale, in the unit of the columns: next to least squares.
  std::vector<Eigen::VectorXd> mean;
  std::vector<Eigen::MatrixXd> covariance;
};

// groups: columns of one matrix, by index, each for one explanation.
SparsePosterior SearchSparse(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                             const std::vector<std::vector<int>>& groups, const SparsePrior& prior = {});

}  // namespace sagitta
