// Covariance that does not assume the stated noise: paper 003, eq. (8),
//
//   C = M (sum_g s_g s_g') M,   M = (J'J)^-1,   s_g = J_g' A_g r_g
//
// with one term per cluster g of rows that share errors (a configuration: its
// markers, visits and loads share the robot's error there), so that whatever is
// correlated inside a cluster, or differs between clusters, counts as it is seen.
// A_g = (I - H_gg)^-1/2, H = J M J', undoes what the fit removed from the residuals
// (Bell and McCaffrey 2002, "CR2"): without it few clusters look too certain.
#pragma once

#include <vector>

#include "estimator/least_squares/linearization.h"

namespace sagitta {

struct RobustCovariance {
  Eigen::MatrixXd covariance;  // SI
  Eigen::VectorXd dof;         // of each column's variance (Satterthwaite), for Student's t
  int clusters = 0;
};

// cluster_of: one entry per Linearization::observations, any integers. Rows of
// priors are no samples: they keep the variance they state.
RobustCovariance SandwichCovariance(const Linearization& linearization, const std::vector<int>& cluster_of);

// The cluster of each listed observation: its configuration; configurations with
// equal joint values are one.
std::vector<int> ConfigurationClusters(const Measurements& data, const std::vector<int>& observations);

}  // namespace sagitta
