#include "tools/reproduce/compensator_geometry.h"

#include <gtest/gtest.h>

#include "tests/support/loaded_kr270.h"

namespace sagitta::compensator_geometry_test {
namespace {

// Paper 002's six angles; P1 and P2 built from distances: |P1 - P2| is the
// spring's length of models/gravity_compensator.h at every angle.
CompensatorMarkers ExactMarkers(const test::SpringTruth& spring, double beside = 0.05) {
  CompensatorMarkers markers;
  const Eigen::Matrix3d turn = test::Turn(Eigen::Vector3d(1, 2, -0.5).normalized(), 1.1);
  const Vector3<double> axis_point(0.4, -0.2, 0.9);
  markers.lever_points.resize(3, 6);
  for (const double q_deg : {0.0, -30.0, -60.0, -90.0, -120.0, -140.0}) {
    const double q = q_deg * kDegree;
    const Vector3<double> lever(spring.L * std::sin(q), spring.L * std::cos(q), 0);
    markers.lever_points.col(markers.q.size()) = axis_point + turn * lever;
    markers.q.push_back(q);
  }
  markers.anchor_points = axis_point + turn * Vector3<double>(-spring.a_x, -spring.a_y, beside);
  return markers;
}

TEST(CompensatorGeometry, RecoversTheSpringFromExactPoints) {
  const test::SpringTruth spring;
  const CompensatorGeometry geometry = FitCompensatorGeometry(ExactMarkers(spring));
  ASSERT_TRUE(geometry.solved);
  EXPECT_NEAR(geometry.L, spring.L, 1e-14);
  EXPECT_NEAR(geometry.a_x, spring.a_x, 1e-14);
  EXPECT_NEAR(geometry.a_y, spring.a_y, 1e-14);
  EXPECT_LT(geometry.rms, 1e-15);
  // What it is for: the distance of the markers is the spring's length.
  const CompensatorMarkers markers = ExactMarkers(spring);
  const CompensatorParameters<double> parameters{geometry.L, geometry.a_x, geometry.a_y, 0.4, 1.0};
  const Vector3<double> along = geometry.rotation.col(2);
  for (int i = 0; i < 6; ++i) {
    const Vector3<double> d = markers.lever_points.col(i) - markers.anchor_points.col(0);
    EXPECT_NEAR((d - along.dot(d) * along).norm(), CompensatorSpringLength(parameters, markers.q[i]), 1e-14);
  }
}

double Ci(const CompensatorGeometry& geometry, int i) { return 3e3 * std::sqrt(geometry.covariance(i, i)); }  // mm

// PUBLISHED.md section 5. Its intervals of a_x and a_y are those of the anchor's
// x and y in the plane of u, P2 at (a_x, a_y) there: -a_y and -a_x of ours.
TEST(CompensatorGeometry, PublishedFigures) {
  const test::SpringTruth spring;
  test::SpringTruth as_printed = spring;
  as_printed.a_x = -spring.a_y;
  as_printed.a_y = -spring.a_x;
  CompensatorMarkers markers = ExactMarkers(as_printed, 0.0);
  markers.point_sigma = 0.036e-3;
  CompensatorGeometry geometry = FitCompensatorGeometry(markers);
  EXPECT_NEAR(geometry.sum_of_directions, 3.296, 5e-4);
  EXPECT_NEAR(std::sqrt(geometry.covariance(0, 0)), markers.point_sigma / std::sqrt(geometry.sum_of_directions), 1e-12);
  EXPECT_NEAR(Ci(geometry, 0), 0.06, 0.001);
  EXPECT_NEAR(Ci(geometry, 2), 0.14, 0.005);
  EXPECT_NEAR(Ci(geometry, 1), 0.245, 0.005);
  EXPECT_NEAR(Ci(geometry, 2) / Ci(geometry, 0), 2.4, 0.05);
  EXPECT_NEAR(Ci(geometry, 1) / Ci(geometry, 0), 4.1, 0.05);
  EXPECT_NEAR(geometry.center_sigma / markers.point_sigma, 0.55, 0.01);
  markers.anchor_sigma = 0.23e-3;
  geometry = FitCompensatorGeometry(markers);
  EXPECT_NEAR(Ci(geometry, 0), 0.06, 0.001);
  EXPECT_NEAR(Ci(geometry, 2), 0.70, 0.01);
  EXPECT_NEAR(Ci(geometry, 1), 0.70, 0.035);
  // The anchor where alpha from the vertical puts it: ratios 2.2 and 3.65.
  markers = ExactMarkers(spring, 0.0);
  markers.point_sigma = 0.036e-3;
  geometry = FitCompensatorGeometry(markers);
  EXPECT_NEAR(Ci(geometry, 1) / Ci(geometry, 0), 2.2, 0.05);
  EXPECT_NEAR(Ci(geometry, 2) / Ci(geometry, 0), 3.65, 0.05);
}

TEST(CompensatorGeometry, ScattersAsItsCovarianceSays) {
  const test::SpringTruth spring;
  const CompensatorMarkers exact = ExactMarkers(spring);
  NormalNumbers normal(4);
  constexpr int kTrials = 2000;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero(), claimed;
  for (int trial = 0; trial < kTrials; ++trial) {
    CompensatorMarkers markers = exact;
    markers.point_sigma = 0.05e-3;
    markers.anchor_sigma = 0.1e-3;
    const auto noise = [&](double sigma) -> Vector3<double> {
      return {sigma * normal(), sigma * normal(), sigma * normal()};
    };
    for (int i = 0; i < 6; ++i) markers.lever_points.col(i) += noise(markers.point_sigma);
    markers.anchor_points.col(0) += noise(markers.point_sigma) + noise(markers.anchor_sigma);
    const CompensatorGeometry geometry = FitCompensatorGeometry(markers);
    const Eigen::Vector3d error(geometry.L - spring.L, geometry.a_x - spring.a_x, geometry.a_y - spring.a_y);
    scatter += error * error.transpose() / kTrials;
    claimed = geometry.covariance;
  }
  const Eigen::Vector3d root = claimed.diagonal().cwiseSqrt();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {  // standard error of a covariance entry is below sqrt(2 / trials)
      EXPECT_NEAR((scatter(i, j) - claimed(i, j)) / (root[i] * root[j]), 0.0, 4 * std::sqrt(2.0 / kTrials));
    }
  }
}

TEST(CompensatorGeometry, OneAngleOrNoAnchorIsNotSolved) {
  CompensatorMarkers markers = ExactMarkers(test::SpringTruth());
  CompensatorMarkers still = markers;
  still.q.assign(6, -0.5);
  still.lever_points.colwise() = Vector3<double>(1, 2, 3);
  EXPECT_FALSE(FitCompensatorGeometry(still).solved);
  markers.anchor_points.resize(3, 0);
  EXPECT_FALSE(FitCompensatorGeometry(markers).solved);
}

}  // namespace
}  // namespace sagitta::compensator_geometry_test
