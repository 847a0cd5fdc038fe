#include "models/geometry.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/arms.h"

namespace sagitta::geometry_test {
namespace {

using test::RandomNumbers;

Vector3<double> RandomAxis(RandomNumbers* random) {
  Vector3<double> axis = random->Vector(1.0);
  while (axis.norm() < 0.1) axis = random->Vector(1.0);
  return axis.normalized();
}

TEST(Geometry, SkewIsTheCrossProduct) {
  RandomNumbers random(1);
  for (int i = 0; i < 20; ++i) {
    const Vector3<double> v = random.Vector(2.0);
    const Vector3<double> w = random.Vector(2.0);
    EXPECT_LT((Skew(v) * w - v.cross(w)).norm(), 1e-15);
  }
}

TEST(Geometry, ExponentialIsTheRotationAboutTheAxis) {
  RandomNumbers random(2);
  for (int i = 0; i < 50; ++i) {
    const Vector3<double> axis = RandomAxis(&random);
    const double angle = random.Uniform(-kPi, kPi);
    const Matrix3<double> expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    EXPECT_LT((RotationFromVector<double>(angle * axis) - expected).norm(), 1e-14);
  }
}

TEST(Geometry, LogarithmUndoesTheExponentialAtEveryAngle) {
  RandomNumbers random(3);
  for (const double angle :
       {0.0, 1e-300, 1e-16, 1e-13, 0.99e-12, 1.01e-12, 1e-9, 1e-8, 1e-4, 0.1, 1.0, 3.0, kPi - 1e-9}) {
    for (int i = 0; i < 10; ++i) {
      const Vector3<double> v = angle * RandomAxis(&random);
      const Vector3<double> back = RotationVector(QuaternionFromRotationVector(v));
      EXPECT_LE((back - v).norm(), 1e-14 + 1e-14 * angle) << "angle " << angle;
      if (angle > 1e-200) {
        EXPECT_LE((back - v).norm(), 1e-11 * angle) << "relative, angle " << angle;
      }
    }
  }
}

TEST(Geometry, LogarithmTakesTheShortWay) {
  const Vector3<double> axis = Vector3<double>(1, 2, -2) / 3.0;
  const Vector3<double> v = RotationVector(QuaternionFromRotationVector<double>((2.0 * kPi - 0.5) * axis));
  EXPECT_LT((v + 0.5 * axis).norm(), 1e-14);
  const Vector3<double> half_turn = RotationVector(QuaternionFromRotationVector<double>(kPi * axis));
  EXPECT_NEAR(half_turn.norm(), kPi, 1e-14);
}

TEST(Geometry, RotationFromRpyTurnsAboutFixedAxes) {
  const Vector3<double> rpy(0.3, -0.7, 1.9);
  const Vector3<double> x = Vector3<double>::UnitX();
  const Vector3<double> y = Vector3<double>::UnitY();
  const Vector3<double> z = Vector3<double>::UnitZ();
  const Matrix3<double> expected = RotationFromVector<double>(rpy.z() * z) * RotationFromVector<double>(rpy.y() * y) *
                                   RotationFromVector<double>(rpy.x() * x);
  EXPECT_LT((RotationFromRpy(rpy) - expected).norm(), 1e-15);
}

// d (exp(v) p) / dv = -[p]x at v = 0, and exact wherever the branch lies.
TEST(Geometry, ExponentialDifferentiatesAtAndNearZero) {
  using Jet = ceres::Jet<double, 3>;
  RandomNumbers random(4);
  const Vector3<double> p(0.4, -1.1, 2.0);
  for (const double angle : {0.0, 1e-20, 1e-13, 0.99e-12, 1.01e-12, 1e-8}) {
    const Vector3<double> v = angle * RandomAxis(&random);
    Vector3<Jet> jet_v;
    for (int i = 0; i < 3; ++i) jet_v[i] = Jet(v[i], i);
    const Vector3<Jet> rotated = RotationFromVector(jet_v) * p.cast<Jet>();
    Matrix3<double> derivative;
    for (int i = 0; i < 3; ++i) derivative.row(i) = rotated[i].v;
    EXPECT_TRUE(derivative.allFinite());
    EXPECT_LT((derivative + Skew(p)).norm(), 1e-14 + 3.0 * angle) << "angle " << angle;
  }
}

TEST(Geometry, ExponentialDifferentiatesAtLargeAngles) {
  using Jet = ceres::Jet<double, 3>;
  RandomNumbers random(5);
  const double h = 1e-6;
  for (int trial = 0; trial < 10; ++trial) {
    const Vector3<double> v = random.Uniform(0.1, 3.0) * RandomAxis(&random);
    Vector3<Jet> jet_v;
    for (int i = 0; i < 3; ++i) jet_v[i] = Jet(v[i], i);
    const Matrix3<Jet> rotation = RotationFromVector(jet_v);
    for (int i = 0; i < 3; ++i) {
      const Vector3<double> step = h * Vector3<double>::Unit(i);
      const Matrix3<double> numeric =
          (RotationFromVector<double>(v + step) - RotationFromVector<double>(v - step)) / (2.0 * h);
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(rotation(r, c).v[i], numeric(r, c), 1e-9);
      }
    }
  }
}

TEST(Geometry, PoseMapsPoints) {
  Pose<double> pose;
  pose.rotation = RotationFromVector<double>(Vector3<double>(0, 0, kPi / 2));
  pose.translation = Vector3<double>(1, 2, 3);
  EXPECT_LT((pose * Vector3<double>(1, 0, 0) - Vector3<double>(1, 3, 3)).norm(), 1e-15);
}

}  // namespace
}  // namespace sagitta::geometry_test
