// Functions of which there are more than can be listed: jumps between any two poses, waves of any order or period. Each
// is tried by itself, by what it explains of chi-square; the best are listed, and the prior counts all of them
// (UnnamedGroup::listed).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <utility>
#include <vector>

#include "estimator/explanations/driver_functions.h"

namespace sagitta {

// Of a unit of each source in each shot, over the fitted rows: its square, and its product with the residual (shots x
// sources); noise as stated, joints that deviate included, as if a function did not vary within an arrival; nothing
// eliminated. products: of each two sources, shots x their matrix by columns.
struct AlongSources {
  Eigen::MatrixXd square, residual, products = {};

  // Of chi-square, by a function f of the shots that one source follows: (f'b)^2 / sum a f^2, as the residual is
  // orthogonal to what is believed. is_offset: a constant is believed, and f counts from its mean.
  double Reduction(Eigen::ArrayXd function, long source, bool is_offset = false) const;
};

// A jump somewhere between two values of x, and what it explains of chi-square.
struct TriedJump {
  Gap gap;
  double reduction;
};

// Which jumps: in at most so many gaps, with so many shots on each side, of sources first .. first + count - 1.
struct JumpsToTry {
  int most_gaps = 0, fewest_of_a_side = 1;
  long first = 0, count = 1;
};

// Jumps of x, of every shot, between neighbours among the fitted shots. Each source jumps in its own way; a constant of
// each is believed.
std::vector<TriedJump> TryJumps(const AlongSources& along, const std::vector<int>& fitted, const Eigen::VectorXd& x,
                                const JumpsToTry& jumps);

// Where a function of x that is constant but for k jumps has them, k = 0 .. most_jumps or as many as there are gaps:
// those that explain most of chi-square together, each source with values of its own (Bellman 1961; Bai and Perron
// 2003, J. Appl. Econometrics 18, 1). Nothing else is considered.
std::vector<std::vector<Gap>> BestJumps(const AlongSources& along, const std::vector<int>& fitted,
                                        const Eigen::VectorXd& x, int most_gaps, size_t most_jumps);

// What was tried so far.
template <class Function>
class Scan {
 public:
  void Try(double reduction, const Function& function) { tried_.emplace_back(reduction, function); }
  size_t size() const { return tried_.size(); }

  // At most so many, the best first; of equals the first tried.
  std::vector<Function> Best(size_t most) {
    std::stable_sort(tried_.begin(), tried_.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<Function> best;
    for (size_t i = 0; i < std::min(most, tried_.size()); ++i) best.push_back(tried_[i].second);
    return best;
  }

 private:
  std::vector<std::pair<double, Function>> tried_;
};

}  // namespace sagitta
