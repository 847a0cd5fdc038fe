// Which few of many groups of columns explain a whitened vector, as a posterior over sets.
//
//   r = sum_k A_k a_k + e,   e ~ N(0, I),   a_k ~ N(0, s_k^2 I),   s_k one of kChangeScales with equal probability,
//   P(set) ~ 1/2 for nothing, 1/2 shared alike by single groups, each further group times kFurtherChange
//
// Columns are derivatives where some changes have been applied already: with `left` what is left there and b_k what has
// been applied, r = left + sum_k A_k b_k. What can be larger has one scale more: kLargeSize, or for what can be
// anywhere kAnySize. Every place is then as likely as any other, a_k ~ N(b_k, kAnySize^2 I), and the way to it, over
// which A_k would not be constant, is in no formula: such a group in the set leaves its A_k b_k out of r.
//
// With the columns of a set scaled by their s, G = A'A and g = A'r, the evidence but for a constant is
//   log p = -1/2 r'r + 1/2 g' (I + G)^-1 g - 1/2 log |I + G|
// (MacKay 1992; the Occam factor is the determinant). Sets are searched by adding, dropping and swapping.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace sagitta {

// Around the typical size of a change, by which columns are scaled: from a tenth of it to thirty times.
constexpr double kChangeScales[] = {0.1, 0.3, 1.0, 3.0, 30.0};
constexpr int kNumChangeScales = 5;
// 0.1 rad (m) of what is typically 0.2 mrad (mm): a motor's turn behind a gear of 60, another place on the same tool.
constexpr double kLargeSize = 500.0;
// A metre and a radian of what is typically 0.2 mm and 0.2 mrad: anywhere.
constexpr double kAnySize = 5000.0;

// Of a set, but for what is anywhere: so many are looked for, for the prior has 0.3^6 = 0.07 % for more.
constexpr int kMostChangedGroups = 6;

// What a change can be beyond kChangeScales.
enum class BeyondTypical { kNone, kLarge, kAnywhere };

// Columns of one matrix, by index, for one explanation.
struct SparseGroup {
  std::vector<int> columns;
  BeyondTypical beyond = BeyondTypical::kNone;
  int part_of = -1;  // group that moves all that this one moves: no answer has both
};

struct SparsePosterior {
  Eigen::VectorXd probability;  // of each group, over all sets that hold it
  double nothing = 1.0;         // of the empty set
  double log_best = 0.0;        // log evidence and prior of the best set at its best scales
  // The most probable set. Of each one's columns, in their unit, at the widest scale: next to least squares.
  struct Member {
    int group = -1;
    bool anywhere = false;  // of kAnySize
    Eigen::VectorXd mean;   // a_k; anywhere: a_k - b_k
    Eigen::MatrixXd covariance;
  };
  std::vector<Member> best;

  // Whether the best set holds as many as are looked for: there may be more.
  bool IsFull() const;
};

// applied: b, one per column; empty: nothing has been.
SparsePosterior SearchSparse(const Eigen::MatrixXd& columns, const Eigen::VectorXd& left,
                             const std::vector<SparseGroup>& groups, const Eigen::VectorXd& applied = {});

}  // namespace sagitta
