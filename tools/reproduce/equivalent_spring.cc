#include "tools/reproduce/equivalent_spring.h"

#include <Eigen/SVD>
#include <cmath>

namespace sagitta {
namespace {

constexpr double kSingular = 1e-10;  // of the largest singular value: six of 16 digits are left

// One row of eq. (14): the derivatives of 1/k2 by (K0, Kc, Kc s0).
Eigen::RowVector3d StiffnessRow(const SpringMounting& geometry, double q) {
  // a L sin g, a L cos g without forming an angle.
  const double sine = geometry.L * (geometry.a_x * std::cos(q) - geometry.a_y * std::sin(q));
  const double cosine = geometry.L * (geometry.a_y * std::cos(q) + geometry.a_x * std::sin(q));
  const double squared_length =
      geometry.a_x * geometry.a_x + geometry.a_y * geometry.a_y + geometry.L * geometry.L + 2 * cosine;
  const double length = std::sqrt(squared_length);
  return {1.0, -cosine, (sine * sine / squared_length + cosine) / length};
}

}  // namespace

EquivalentSpring FitEquivalentSpring(const std::vector<JointTwoNode>& nodes, const SpringMounting& geometry,
                                     SpringWeights weights) {
  EquivalentSpring spring;
  const int n = static_cast<int>(nodes.size());
  if (n < 3) return spring;
  Eigen::MatrixXd a(n, 3);
  Eigen::VectorXd stiffness(n), sigma(n), weight = Eigen::VectorXd::Ones(n);
  for (int i = 0; i < n; ++i) {
    if (!(nodes[i].k > 0.0)) return spring;
    a.row(i) = StiffnessRow(geometry, nodes[i].q);
    stiffness[i] = 1.0 / nodes[i].k;
    sigma[i] = nodes[i].sigma * stiffness[i] * stiffness[i];
    if (weights == SpringWeights::kEqual) continue;
    if (!(sigma[i] > 0.0)) return spring;
    weight[i] = 1.0 / sigma[i];
  }
  const Eigen::MatrixXd weighted = weight.asDiagonal() * a;
  const Eigen::Vector3d scale = weighted.colwise().norm();
  if (!(scale.minCoeff() > 0.0)) return spring;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(weighted * scale.cwiseInverse().asDiagonal(),
                                              Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::Vector3d s = svd.singularValues();
  spring.condition = s[0] / s[2];
  if (!(s[2] > kSingular * s[0])) return spring;
  // solution = pseudo * stiffness
  const Eigen::MatrixXd pseudo = scale.cwiseInverse().asDiagonal() * svd.matrixV() * s.cwiseInverse().asDiagonal() *
                                 svd.matrixU().transpose() * weight.asDiagonal();
  const Eigen::Vector3d solution = pseudo * stiffness;
  if (solution[0] == 0.0 || solution[1] == 0.0) return spring;
  spring.K0 = solution[0];
  spring.Kc = solution[1];
  spring.s0 = solution[2] / solution[1];
  spring.k0 = 1.0 / spring.K0;
  const Eigen::VectorXd fitted = a * solution;
  spring.rms = std::sqrt((fitted.cwiseInverse() - stiffness.cwiseInverse()).squaredNorm() / n);
  Eigen::Matrix3d by_solution = Eigen::Matrix3d::Zero();  // d (k0, Kc, s0) / d solution
  by_solution(0, 0) = -spring.k0 * spring.k0;
  by_solution(1, 1) = 1.0;
  by_solution(2, 1) = -spring.s0 / spring.Kc;
  by_solution(2, 2) = 1.0 / spring.Kc;
  const Eigen::MatrixXd propagate = by_solution * pseudo * sigma.asDiagonal();
  spring.covariance = propagate * propagate.transpose();
  spring.solved = true;
  return spring;
}

}  // namespace sagitta
