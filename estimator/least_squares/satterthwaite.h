// What the fit removed from the clusters of a robust covariance, and what is known of them (sandwich.h).
#pragma once

#include <utility>
#include <vector>

#include "models/dense_algebra.h"

namespace sagitta {

// A_g - I = (I - H)^-1/2 - 1 of H = b_g b_g': a small symmetric problem, of as many rows as the cluster has. Directions
// that the cluster alone determines are left out (generalised inverse): their residual is zero and says nothing.
Eigen::MatrixXd Unshrinking(const Eigen::MatrixXd& h);

// Satterthwaite's degrees of freedom of each column's variance under independent noise: with a_g = A_g J_g M e and
// w_g = b_g' a_g, the variance is a quadratic form with P_gh = [g = h] |a_g|^2 - w_g . w_h; nu = tr(P)^2 / tr(P^2).
class Satterthwaite {
 public:
  explicit Satterthwaite(int columns)
      : trace_(Eigen::ArrayXd::Zero(columns)), of_square_(Eigen::ArrayXd::Zero(columns)) {}

  // a: A_g J_g M, h: b_g b_g'. weight: of how many clusters like this one it is a sample.
  void Add(const Eigen::MatrixXd& b, const Eigen::MatrixXd& h, const Eigen::MatrixXd& a, double weight = 1.0);
  // Clusters whose rows b_g stand one after the other. first: where each begins, and the end; root_of_listed: W' of the
  // columns asked for, M = W W'; weights: of each, empty: 1. Returns A_g b_g.
  Eigen::MatrixXd AddClusters(const Eigen::MatrixXd& b, const std::vector<Eigen::Index>& first,
                              const Eigen::MatrixXd& root_of_listed, const std::vector<double>& weights = {});
  Eigen::VectorXd Degrees() const;

 private:
  Eigen::VectorXd DegreesOfFew() const;

  Eigen::ArrayXd trace_, of_square_;
  std::vector<std::pair<Eigen::MatrixXd, Eigen::MatrixXd>> clusters_;  // b', a
};

}  // namespace sagitta
