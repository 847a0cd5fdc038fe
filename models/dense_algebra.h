// Eigen with its decompositions and products of dynamic matrices, compiled once (dense_algebra.cc, dense_svd.cc) rather
// than in each file that uses them. Precompiled into every source of the library: most of the build's time went into
// these.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#ifndef SAGITTA_TEMPLATE
#define SAGITTA_TEMPLATE extern template
#endif
#ifndef SAGITTA_SVD_TEMPLATE
#define SAGITTA_SVD_TEMPLATE extern template
#endif

namespace Eigen {

SAGITTA_TEMPLATE class LLT<MatrixXd, Lower>;
SAGITTA_TEMPLATE class LLT<MatrixXd, Upper>;
SAGITTA_TEMPLATE class LDLT<MatrixXd, Lower>;
SAGITTA_TEMPLATE class PartialPivLU<MatrixXd>;
SAGITTA_TEMPLATE class HouseholderQR<MatrixXd>;
SAGITTA_TEMPLATE class ColPivHouseholderQR<MatrixXd>;
SAGITTA_TEMPLATE class CompleteOrthogonalDecomposition<MatrixXd>;
SAGITTA_SVD_TEMPLATE class JacobiSVD<MatrixXd>;
SAGITTA_SVD_TEMPLATE class BDCSVD<MatrixXd>;
SAGITTA_TEMPLATE class SelfAdjointEigenSolver<MatrixXd>;

namespace internal {

using DoubleMapper = blas_data_mapper<double, Index, ColMajor, Unaligned, 1>;
SAGITTA_TEMPLATE struct gebp_kernel<double, double, Index, DoubleMapper, gebp_traits<double, double>::mr,
                                    gebp_traits<double, double>::nr, false, false>;
SAGITTA_TEMPLATE struct general_matrix_matrix_product<Index, double, ColMajor, false, double, ColMajor, false, ColMajor,
                                                      1>;
SAGITTA_TEMPLATE struct general_matrix_matrix_product<Index, double, RowMajor, false, double, ColMajor, false, ColMajor,
                                                      1>;
SAGITTA_TEMPLATE struct general_matrix_matrix_product<Index, double, ColMajor, false, double, RowMajor, false, ColMajor,
                                                      1>;
SAGITTA_TEMPLATE struct general_matrix_matrix_product<Index, double, RowMajor, false, double, RowMajor, false, ColMajor,
                                                      1>;

}  // namespace internal
}  // namespace Eigen
