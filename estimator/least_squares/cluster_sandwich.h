// The sandwich (sandwich.h) of many clusters and of many fits at once, from one pass over rows that nobody holds.
//
// Scores J_g' A_g r_g are summed over all clusters, eight side by side, A_g by its series: a cluster among many has
// little leverage. Degrees of freedom are of a sample: cluster g with probability min(1, 2000 h_g / p), h_g its
// leverage and p the sum of all, weighted by the inverse; those that rule a variance are all in it. Of a fit of some
// clusters 500 in place of 2000: there they only say which of Student's distributions a difference is held against.
#pragma once

#include <vector>

#include "estimator/least_squares/batch_algebra.h"
#include "estimator/least_squares/row_stream.h"
#include "estimator/least_squares/sandwich.h"

namespace sagitta {

// One of the fits: of some clusters, in some columns, by one step from where the rows are.
struct ClusterFit {
  LinearSolution solution;   // without rows of priors where parts are fitted alone
  std::vector<int> columns;  // of the rows as they are turned; empty: all
  Eigen::VectorXd step;      // one per column of the fit; empty: rows are at its optimum
  std::vector<char> has;     // of each cluster; empty: all
};

class ClusterSandwich {
 public:
  // columns: of the rows, without the residual. normal: (J'J)^-1 of the fit of all clusters. turn: fits have the rows'
  // columns times this; empty: those themselves. shares: that rows are added in.
  ClusterSandwich(int columns, int clusters, const Eigen::MatrixXd& normal, std::vector<ClusterFit> fits,
                  const Eigen::MatrixXd& turn = {}, int shares = 1);

  // rows: [J r] of whole clusters, three per observation; cluster_of: of each observation, 0 .. clusters - 1.
  // To the share's fits.
  void Add(const RowMajorMatrix& rows, const std::vector<int>& cluster_of, const Share& share = {});

  // cluster_of: of each observation of the piece's list.
  void Add(const RowPiece& piece, const std::vector<int>& cluster_of, const Share& share = {});

  // priors: rows of the fit's columns that are no samples and keep the variance they state.
  RobustCovariance Result(int fit, const Eigen::MatrixXd& priors = {});
  // Without priors, in two parts: no degrees of freedom, and those of some of the fit's columns.
  RobustCovariance Covariance(int fit);
  Eigen::VectorXd DegreesOf(int fit, const std::vector<int>& listed) const;

 private:
  struct Fit {
    ClusterFit given;
    Eigen::MatrixXd basis;                     // of its columns along those of the rows
    std::vector<double> inverse_normal, step;  // along the rows' columns, padded
    GramSums products;                         // of scores
    BatchBuffer memory;
    double* held = nullptr;  // scores that are not summed yet
    int num_held = 0, clusters = 0;
  };
  // Observations of a piece that are one cluster, and in which of the fits it is.
  struct Member {
    int fits = 0, cluster = 0;
    std::size_t first = 0, count = 0;
  };
  struct Lane {
    int cluster = 0;
    std::vector<const double*> rows;
    RowMajorMatrix shortened;  // where these are more than needed
  };
  struct Sample {
    int cluster = 0;
    double leverage = 0.0;
    RowMajorMatrix rows;
  };

  bool Has(const Fit& fit, int cluster) const { return fit.given.has.empty() || fit.given.has[cluster] != 0; }
  double Expected(double leverage, bool of_part) const;
  // What the rows of a piece are put side by side in.
  struct Scratch {
    Scratch() : lanes(kBatchLanes) {}

    std::vector<int> clusters_of_piece;
    std::vector<int> by_cluster;  // observations of the piece
    std::vector<Member> members;
    std::vector<Lane> lanes;
    BatchBuffer cells, work;
  };

  void Fill(const Member& member, const RowMajorMatrix& rows, const std::vector<int>& by_cluster, Lane* lane) const;
  void AddLanes(std::size_t count, const Share& share, Scratch* scratch);
  void Score(const ClusterLanes& lanes, std::size_t count, Scratch* scratch, Fit* fit) const;
  void Draw(const Lane& lane, double leverage);
  void Flush(Fit* fit) const;
  RowMajorMatrix RowsOf(const Lane& lane) const;

  int columns_, padded_, clusters_;
  std::vector<double> root_;
  std::vector<Fit> fits_;
  std::vector<int> in_fits_;  // of each cluster: equal numbers, the same fits
  std::vector<Sample> sample_;
  std::vector<Scratch> scratch_;  // of each share
};

}  // namespace sagitta
