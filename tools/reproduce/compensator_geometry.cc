#include "tools/reproduce/compensator_geometry.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "models/matrix_functions.h"

namespace sagitta {
namespace {

constexpr double kFlat = 1e-12;  // second singular value of the correlation, of the points' norm: of one angle only

Vector3<double> DirectionAt(double q) { return {std::cos(q), std::sin(q), 0.0}; }

// Covariance of (L, a_x, a_y) by way of (c, rotation, L).
Eigen::Matrix3d PropagateNoise(const CompensatorMarkers& markers, const Vector3<double>& anchor,
                               CompensatorGeometry* geometry) {
  Eigen::Matrix<double, 7, 7> information = Eigen::Matrix<double, 7, 7>::Zero();
  for (const double q : markers.q) {
    const Vector3<double> direction = geometry->rotation * DirectionAt(q);
    Eigen::Matrix<double, 3, 7> row;
    row << Matrix3<double>::Identity(), -geometry->L * Skew(direction), direction;
    information += row.transpose() * row;
  }
  const Eigen::Matrix<double, 7, 7> covariance =
      markers.point_sigma * markers.point_sigma * information.ldlt().solve(Eigen::Matrix<double, 7, 7>::Identity());
  const Matrix3<double> to_plane = geometry->rotation.transpose();
  const Eigen::Matrix3d center = to_plane * covariance.topLeftCorner<3, 3>() * to_plane.transpose();
  geometry->center_sigma = std::sqrt(std::max(center(0, 0), center(1, 1)));
  // rows of R'(P2 - c): y gives -a_x, x gives -a_y
  Eigen::Matrix<double, 3, 7> by_circle;
  by_circle << -to_plane, to_plane * Skew(Vector3<double>(anchor - geometry->center)), Vector3<double>::Zero();
  Eigen::Matrix<double, 3, 7> derivative = Eigen::Matrix<double, 3, 7>::Zero();
  derivative(0, 6) = 1.0;
  derivative.row(1) = -by_circle.row(1);
  derivative.row(2) = -by_circle.row(0);
  Eigen::Matrix3d result = derivative * covariance * derivative.transpose();
  const double anchor_variance = markers.anchor_sigma * markers.anchor_sigma +
                                 markers.point_sigma * markers.point_sigma / markers.anchor_points.cols();
  result(1, 1) += anchor_variance;
  result(2, 2) += anchor_variance;
  return result;
}

}  // namespace

CompensatorGeometry FitCompensatorGeometry(const CompensatorMarkers& markers) {
  CompensatorGeometry geometry;
  const int m = static_cast<int>(markers.q.size());
  if (m < 3 || markers.lever_points.cols() != m || markers.anchor_points.cols() < 1) return geometry;
  Eigen::Matrix3Xd directions(3, m);
  for (int i = 0; i < m; ++i) directions.col(i) = DirectionAt(markers.q[i]);
  const Vector3<double> mean_direction = directions.rowwise().mean();
  const Vector3<double> mean_point = markers.lever_points.rowwise().mean();
  const Eigen::Matrix3Xd u = directions.colwise() - mean_direction;
  const Eigen::Matrix3Xd p = markers.lever_points.colwise() - mean_point;
  geometry.sum_of_directions = u.squaredNorm();
  const Matrix3<double> correlation = p * u.transpose();
  const Eigen::JacobiSVD<Matrix3<double>> svd(correlation);
  if (!(svd.singularValues()[1] > kFlat * p.norm())) return geometry;  // no arc
  geometry.rotation = NearestRotation(correlation);
  const Eigen::Matrix3Xd turned = geometry.rotation * u;
  geometry.L = p.cwiseProduct(turned).sum() / geometry.sum_of_directions;
  geometry.center = mean_point - geometry.L * geometry.rotation * mean_direction;
  geometry.rms = std::sqrt((p - geometry.L * turned).squaredNorm() / (3 * m));
  const Vector3<double> anchor = markers.anchor_points.rowwise().mean();
  const Vector3<double> in_plane = geometry.rotation.transpose() * (anchor - geometry.center);
  geometry.a_x = -in_plane.y();
  geometry.a_y = -in_plane.x();
  geometry.covariance = PropagateNoise(markers, anchor, &geometry);
  geometry.solved = true;
  return geometry;
}

}  // namespace sagitta
