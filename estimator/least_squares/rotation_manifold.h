// Unit quaternions (x, y, z, w) under left perturbations, x [+] delta = exp(delta) x,
// delta in rad, along the free axes only.
//
// ceres::EigenQuaternionManifold has half angles as tangent and no way to hold
// one axis; here the tangent is the rotation vector that results are stated in.
#pragma once

#include <ceres/manifold.h>

#include <vector>

namespace sagitta {

class RotationManifold : public ceres::Manifold {
 public:
  // free_axes: which of x, y, z (0, 1, 2) may turn; not empty.
  explicit RotationManifold(std::vector<int> free_axes = {0, 1, 2});

  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return static_cast<int>(free_axes_.size()); }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;  // 4 x n, row major
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;  // n x 4, row major

 private:
  std::vector<int> free_axes_;
};

// d(exp(delta) x)/d(delta) at 0, 4 x 3: half of the quaternion product (delta, 0) * x.
Eigen::Matrix<double, 4, 3> QuaternionPlusJacobian(const double* x);

}  // namespace sagitta
