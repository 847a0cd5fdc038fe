// What readings say of which explanation is the right one: one measure for plans and for the diagnosis.
//
// Under the right explanation i the log odds of i over j that the readings bring are normal about D_ij / 2 with
// variance D_ij, D_ij the squared distance of what both predict in the covariance of the readings (exact for known
// predictions and Gaussian noise; Box and Hill, Technometrics 9, 1967). With prior probabilities p, in nat,
//
//   P_i = sum_(j called like i) p_j exp(x_ij) / sum_j p_j exp(x_ij),   x_ij = -D_ij / 2 + sqrt(D_ij) z,   z ~ N(0, 1)
//   information = H + sum_i p_i E ln P_i,   decides = sum_i p_i E P_i
//
// the mutual information of name and readings (H: entropy of the names), and the probability that the right name is
// expected to have after them. For two explanations both are exact; for more the x_ij of one i are assumed to move
// together.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace sagitta {

// apart: D, symmetric with a diagonal of 0. probabilities sum to 1. names: of each explanation, by number; D of two
// that are called alike is not asked.
double MutualInformation(const Eigen::VectorXd& probabilities, const std::vector<int>& names,
                         const Eigen::MatrixXd& apart);
double ExpectedProbability(const Eigen::VectorXd& probabilities, const std::vector<int>& names,
                           const Eigen::MatrixXd& apart);

// Of two explanations of the same probability that are D apart: the information, at most ln 2, its derivative by D and
// the probability of the right one. Concave in D (the mutual information of a binary signal in Gaussian noise; Guo,
// Shamai and Verdu, IEEE Trans. Information Theory 51, 2005: dI/dD = E s^2 / 2, s the probability of the wrong one).
struct TwoApart {
  double information = 0.0, slope = 0.0, decides = 0.5;
};
TwoApart InformationOfTwo(double apart);

}  // namespace sagitta
