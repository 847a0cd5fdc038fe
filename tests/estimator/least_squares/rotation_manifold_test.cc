#include "estimator/least_squares/rotation_manifold.h"

#include <ceres/manifold_test_utils.h>
#include <gtest/gtest.h>

#include "models/geometry.h"

namespace ceres::rotation_manifold_test {
namespace {

using sagitta::QuaternionFromRotationVector;
using sagitta::RotationManifold;
using sagitta::Vector3;

// Ceres' contract of ten checks, at neutral, near it and anywhere.
TEST(RotationManifold, KeepsTheManifoldContract) {
  const RotationManifold manifold;
  std::srand(5);
  for (const double size : {0.0, 1e-8, 1.0}) {
    for (int i = 0; i < 20; ++i) {
      const Vector3<double> v = size * Vector3<double>::Random();
      const Eigen::Quaterniond q = QuaternionFromRotationVector(v) * Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5);
      const Eigen::Vector4d x = q.coeffs();
      const Eigen::Vector3d delta = size * Eigen::Vector3d::Random();
      const Eigen::Vector4d y = (QuaternionFromRotationVector<double>(delta) * q).coeffs();
      // Relative: a step of 1e-8 next to a unit quaternion keeps half of the digits.
      EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(manifold, x, delta, y, size == 1e-8 ? 1e-7 : 1e-9);
    }
  }
}

}  // namespace
}  // namespace ceres::rotation_manifold_test

namespace sagitta::rotation_manifold_test {
namespace {

TEST(RotationManifold, TangentIsALeftRotationVectorInRad) {
  const RotationManifold manifold;
  const Eigen::Quaterniond q = QuaternionFromRotationVector<double>({0.3, -1.2, 0.7});
  const Vector3<double> delta(0.01, 0.02, -0.03);
  Eigen::Quaterniond moved;
  manifold.Plus(q.coeffs().data(), delta.data(), moved.coeffs().data());
  const Matrix3<double> expected = RotationFromVector(delta) * q.toRotationMatrix();
  EXPECT_LT((moved.toRotationMatrix() - expected).norm(), 1e-14);
}

TEST(RotationManifold, HeldAxesDoNotTurn) {
  const RotationManifold manifold({2});
  ASSERT_EQ(manifold.TangentSize(), 1);
  const Eigen::Quaterniond q = QuaternionFromRotationVector<double>({0.3, -1.2, 0.7});
  const double delta = 0.4;
  Eigen::Quaterniond moved;
  manifold.Plus(q.coeffs().data(), &delta, moved.coeffs().data());
  const Vector3<double> step = RotationVector(moved * q.conjugate());
  EXPECT_LT((step - Vector3<double>(0, 0, delta)).norm(), 1e-14);
}

}  // namespace
}  // namespace sagitta::rotation_manifold_test
