// Model error as what it is: each part of the data has a robot of its own. With x_a = x + e_a + noise, where the
// model's error e has covariance T and is another in every part,
//
//   d = x_a - x_b,   E d d' = C_a + C_b + 2 T,   T = mean over the splits of (d d' - C_a - C_b) / 2
//
// (DerSimonian and Laird 1986; metrologists say dark uncertainty, Thompson and Ellison 2011). The estimate of the whole
// is itself that of one region and one series: for any other it has C + T. Noise averages over the parts, T does not.
#pragma once

#include <string>
#include <vector>

#include "estimator/agreement/base_turns.h"

namespace sagitta {

// SI, of the coordinates behind Estimate::covariance. Empty: the parts agree.
struct BetweenParts {
  Eigen::MatrixXd covariance;  // T, a moment estimate: single combinations may come out below 0. Empty: not known
  Eigen::VectorXd variance;    // of each coordinate, not below 0
  Eigen::VectorXd draws;       // splits behind it: its degrees of freedom
  std::string reason;          // what it was found by, in words

  bool known() const { return variance.size() > 0; }
};

// Of one split: its differences and their covariance by noise alone.
struct PartDifference {
  std::vector<int> columns;  // positions among the coordinates that are compared
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
  std::vector<int>
      one_sided;  // seen by one part alone: another station's base, another marker. Others are held in both
};

// Moments over splits of one kind, in the base's own axes.
class PartMoments {
 public:
  explicit PartMoments(int coordinates);
  void Add(const PartDifference& difference);
  void Add(const PartMoments& other);
  // In the axes of the coordinates.
  BetweenParts Result(const BaseTurns& turns) const;

 private:
  Eigen::MatrixXd sums_;   // of d d' - C_a - C_b
  Eigen::MatrixXd pairs_;  // splits in which neither of two coordinates is one-sided
  Eigen::VectorXd times_;  // splits that determine a coordinate
};

// Of each coordinate the larger variance.
void TakeLarger(const BetweenParts& other, BetweenParts* found);

}  // namespace sagitta
