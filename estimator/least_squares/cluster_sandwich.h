// The sandwich (sandwich.h) of many clusters and of many fits at once, from one pass over rows that nobody holds.
//
// Scores J_g' A_g r_g are summed over all clusters, eight side by side, A_g by its series: a cluster among many has
// little leverage. Degrees of freedom are of a sample: cluster g with probability min(1, 2000 h_g / p), h_g its
// leverage and p the sum of all, weighted by the inverse; those that rule a variance are all in it.
#pragma once

#include <vector>

#include "estimator/least_squares/batch_algebra.h"
#include "estimator/least_squares/row_stream.h"
#include "estimator/least_squares/sandwich.h"

namespace sagitta {

// One of the fits: of some clusters, in some columns, by one step from where the rows are.
struct ClusterFit {
  LinearSolution solution;   // without rows of priors where parts are fitted alone
  std::vector<int> columns;  // of the rows; empty: all
  Eigen::VectorXd step;      // one per column of the fit; empty: rows are at its optimum
  std::vector<char> has;     // of each cluster; empty: all
};

class ClusterSandwich {
 public:
  // columns: of the rows, without the residual. root: upper triangular W of the fit of all clusters, W W' = (J'J)^-1.
  ClusterSandwich(int columns, int clusters, const Eigen::MatrixXd& root, std::vector<ClusterFit> fits);

  // rows: [J r] of whole clusters, three per observation; cluster_of: of each observation, 0 .. clusters - 1.
  void Add(const RowMajorMatrix& rows, const std::vector<int>& cluster_of);

  // All rows of a stream whose groups are clusters; cluster_of: of each of its observations.
  void Add(const RowStream& stream, const ParameterSet& parameters, const std::vector<int>& columns,
           const std::vector<int>& cluster_of);

  // priors: rows of the fit's columns that are no samples and keep the variance they state.
  RobustCovariance Result(int fit, const Eigen::MatrixXd& priors = {});

 private:
  struct Fit {
    ClusterFit given;
    std::vector<double> inverse_normal, step;  // padded
    GramSums products;                         // of scores
    BatchBuffer memory;
    double* held = nullptr;  // scores that are not summed yet
    int num_held = 0, clusters = 0;
  };
  struct Sample {
    int cluster = 0;
    double weight = 1.0;
    RowMajorMatrix rows;
  };

  bool Has(const Fit& fit, int cluster) const { return fit.given.has.empty() || fit.given.has[cluster] != 0; }
  void AddLanes(const std::vector<int>& clusters, const std::vector<RowMajorMatrix>& rows);
  void Score(const ClusterLanes& lanes, const std::vector<int>& clusters, const std::vector<RowMajorMatrix>& rows,
             Fit* fit);
  void Draw(int cluster, double leverage, const RowMajorMatrix& rows);
  void Flush(Fit* fit);
  Eigen::MatrixXd Columns(const RowMajorMatrix& rows, const Fit& fit) const;
  Eigen::VectorXd DegreesOf(const Fit& fit) const;

  int columns_, padded_, clusters_;
  std::vector<double> root_;
  std::vector<Fit> fits_;
  std::vector<Sample> sample_;
  BatchBuffer cells_, work_, scores_;
};

}  // namespace sagitta
