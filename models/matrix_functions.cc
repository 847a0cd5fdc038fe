#include "models/matrix_functions.h"

namespace sagitta {

Eigen::MatrixXd InverseOfPositive(const Eigen::MatrixXd& matrix) {
  const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
  return factor.solve(identity);
}

double LogDeterminant(const Eigen::LLT<Eigen::MatrixXd>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

Eigen::MatrixXd TransposedQ(const Eigen::HouseholderQR<Eigen::MatrixXd>& qr, Eigen::MatrixXd x) {
  x.applyOnTheLeft(qr.householderQ().adjoint());
  return x;
}

Matrix3<double> LowerRoot(const Matrix3<double>& positive) {
  const Eigen::LLT<Eigen::MatrixXd> factor{Eigen::MatrixXd(positive)};
  return Eigen::MatrixXd(factor.matrixL());
}

PrincipalAxes PrincipalAxesOf(const Matrix3<double>& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{Eigen::MatrixXd(symmetric)};
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

// R = U diag(1, 1, det U det V) V' (Kabsch 1976, Umeyama 1991).
Matrix3<double> NearestRotation(const Matrix3<double>& matrix) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(matrix), Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3<double> u = svd.matrixU(), v = svd.matrixV();
  Matrix3<double> flip = Matrix3<double>::Identity();
  if (u.determinant() * v.determinant() < 0.0) flip(2, 2) = -1.0;
  return u * flip * v.transpose();
}

}  // namespace sagitta
