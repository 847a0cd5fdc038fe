// Functions of matrices that many sources need: their decompositions are instantiated in one source.
#pragma once

#include "models/dense_algebra.h"
#include "models/geometry.h"

namespace sagitta {

// A^-1 of a symmetric positive definite matrix.
Eigen::MatrixXd InverseOfPositive(const Eigen::MatrixXd& matrix);

// ln |A| = 2 sum_i ln L_ii of A = L L'.
double LogDeterminant(const Eigen::LLT<Eigen::MatrixXd>& factor);

// Q' X of any X with as many rows as what was decomposed, A = Q R.
Eigen::MatrixXd TransposedQ(const Eigen::HouseholderQR<Eigen::MatrixXd>& qr, Eigen::MatrixXd x);

// Lower triangular L of A = L L', A symmetric and positive definite.
Matrix3<double> LowerRoot(const Matrix3<double>& positive);

// A symmetric matrix in its own axes, A = axes diag(values) axes', values ascending.
struct PrincipalAxes {
  Vector3<double> values;
  Matrix3<double> axes;  // columns of unit length
};
PrincipalAxes PrincipalAxesOf(const Matrix3<double>& symmetric);

// The rotation R that maximises tr(R' M), nearest to M in the sense of Frobenius.
Matrix3<double> NearestRotation(const Matrix3<double>& matrix);

}  // namespace sagitta
