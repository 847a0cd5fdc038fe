#include "estimator/alignment/pose_registration.h"

#include <Eigen/QR>
#include <Eigen/SVD>

#include "estimator/alignment/starting_values.h"

namespace sagitta {
namespace {

// m, second principal size a marker set must have: on less a reading that is off by 0.05 mm turns it by 50 mrad.
constexpr double kFlattest = 1e-3;
constexpr int kWeightedRounds = 5;  // of Gauss-Newton: an angle of mrad that is left is squared in each

}  // namespace

bool SpansAPlane(const Eigen::Matrix3Xd& points) {
  if (points.cols() < 3) return false;
  const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
  return Eigen::JacobiSVD<Eigen::MatrixXd>(centred).singularValues()[1] > kFlattest;
}

Eigen::MatrixXd RigidColumns(const Eigen::Matrix3Xd& points, const Vector3<double>& reference) {
  Eigen::MatrixXd columns(3 * points.cols(), 6);
  for (int i = 0; i < points.cols(); ++i) {
    // d p = d t + d w x (p - reference) = d t - [p - reference]x d w.
    columns.block<3, 3>(3 * i, 0).setIdentity();
    columns.block<3, 3>(3 * i, 3) = -Skew<double>(points.col(i) - reference);
  }
  return columns;
}

Vector6 RegisterPose(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& targets, const Eigen::VectorXd& sigmas,
                     const Vector3<double>& reference) {
  // Closed form for equal sigmas; then Gauss-Newton with the weights 1 / sigma^2.
  Pose<double> pose = RegisterRigid(points, targets);
  for (int round = 0; sigmas.minCoeff() < sigmas.maxCoeff() && round < kWeightedRounds; ++round) {
    const Eigen::Matrix3Xd moved = (pose.rotation * points).colwise() + pose.translation;
    const Vector3<double> here = pose * reference;
    const Eigen::MatrixXd columns = sigmas.cwiseInverse().asDiagonal() * RigidColumns(moved, here);
    const Eigen::Matrix3Xd gap = targets - moved;
    const Eigen::VectorXd whitened = Eigen::Map<const Eigen::VectorXd>(gap.data(), gap.size()).cwiseQuotient(sigmas);
    const Vector6 step = columns.householderQr().solve(whitened);
    const Vector3<double> turn = step.tail<3>();
    const Matrix3<double> rotation = RotationFromVector(turn);
    pose = {rotation * pose.rotation, here + step.head<3>() + rotation * (pose.translation - here)};
  }
  Vector6 motion;
  motion << pose * reference - reference, RotationVector(Eigen::Quaterniond(pose.rotation));
  return motion;
}

}  // namespace sagitta
