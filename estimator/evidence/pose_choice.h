// Which of many poses distinguishes rival explanations.
//
// Rival i predicts the whitened rows of any poses as N(m_i, I + Y_i' Y_i), Y_i = N_i^-1/2 R_i' of the rows R_i in its
// coefficients and their precision N_i by what is known so far. Readings distinguish i from j by
//
//   D_ij = d' (I + (Y_i' Y_i + Y_j' Y_j) / 2)^-1 d,   d = m_i - m_j
//
// over the rows of all poses together: a second reading of what the coefficients can follow says little. That is twice
// the expected log Bayes factor for small differences. Poses are chosen one after the other, each the one that makes
// the mutual information between what the rivals are called and the readings largest (statistics/mutual_information.h),
// which is what `plan --discriminate` goes by too.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace sagitta {

// What a rival predicts at all poses, their rows one after the other.
struct RivalRows {
  double probability = 0.0;
  int name = 0;            // rivals of one name (shapes of one compensator) need not be distinguished
  Eigen::VectorXd means;   // m, of each row
  Eigen::MatrixXd spread;  // Y, coefficients x rows
};

class PoseChoice {
 public:
  // first_row: of each pose, and how many there are in all.
  PoseChoice(std::vector<RivalRows> rivals, std::vector<long> first_row);

  // Chooses the best pose that is left; its number. What is worth little at first stays so: after the first choice only
  // the best are asked again.
  size_t Take();

  // The right name's probability after the poses that are chosen, expected; with `visits` readings of each as if each
  // were read once but with a variance of 1 / visits.
  double Decides(double visits = 1.0) const;
  // Visits to poses like those chosen, in turn, after which the right name is expected to have this probability; 0:
  // more than `most`.
  int Needed(double wanted, int most) const;

 private:
  // D over the rows of these poses, each read so often.
  Eigen::MatrixXd Apart(const std::vector<size_t>& poses, double visits) const;

  std::vector<RivalRows> rivals_;
  std::vector<long> first_row_;
  Eigen::VectorXd probabilities_;
  std::vector<int> names_;
  std::vector<size_t> asked_, taken_;
};

}  // namespace sagitta
