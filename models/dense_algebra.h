// Eigen with its decompositions and products of dynamic matrices, compiled once (dense_algebra.cc, dense_jacobi_svd.cc)
// rather than in each file that uses them. Precompiled into every source of the library: most of the
// build's time went into these.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

// Where Eigen packs matrices as dense_kernel.cc reads them: version 3.4 with vectors of two numbers.
#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90) && defined(__x86_64__) && !defined(__AVX__)
#define SAGITTA_OWN_DENSE_KERNEL
#endif

#ifndef SAGITTA_TEMPLATE
#define SAGITTA_TEMPLATE extern template
#endif

namespace Eigen {

SAGITTA_TEMPLATE class LLT<MatrixXd, Lower>;
SAGITTA_TEMPLATE class LDLT<MatrixXd, Lower>;
SAGITTA_TEMPLATE class PartialPivLU<MatrixXd>;
SAGITTA_TEMPLATE class HouseholderQR<MatrixXd>;
SAGITTA_TEMPLATE class ColPivHouseholderQR<MatrixXd>;
extern template class JacobiSVD<MatrixXd>;
SAGITTA_TEMPLATE class SelfAdjointEigenSolver<MatrixXd>;
// Member templates are not among what an instantiated class brings with it.
SAGITTA_TEMPLATE LLT<MatrixXd, Lower>& LLT<MatrixXd, Lower>::compute(const EigenBase<MatrixXd>&);
SAGITTA_TEMPLATE LDLT<MatrixXd, Lower>& LDLT<MatrixXd, Lower>::compute(const EigenBase<MatrixXd>&);
SAGITTA_TEMPLATE ColPivHouseholderQR<MatrixXd>& ColPivHouseholderQR<MatrixXd>::compute(const EigenBase<MatrixXd>&);
SAGITTA_TEMPLATE SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&,
                                                                                             int);
SAGITTA_TEMPLATE void LLT<MatrixXd, Lower>::_solve_impl(const VectorXd&, VectorXd&) const;
SAGITTA_TEMPLATE void LLT<MatrixXd, Lower>::_solve_impl(const MatrixXd&, MatrixXd&) const;
SAGITTA_TEMPLATE void LDLT<MatrixXd, Lower>::_solve_impl(const VectorXd&, VectorXd&) const;
SAGITTA_TEMPLATE void LDLT<MatrixXd, Lower>::_solve_impl(const MatrixXd&, MatrixXd&) const;
SAGITTA_TEMPLATE void HouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
SAGITTA_TEMPLATE void HouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
SAGITTA_TEMPLATE void ColPivHouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
SAGITTA_TEMPLATE void ColPivHouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;

namespace internal {

// Products of a matrix and a vector, both ways.
using RowMajorMapper = const_blas_data_mapper<double, Index, RowMajor>;
using ColMajorMapper = const_blas_data_mapper<double, Index, ColMajor>;
SAGITTA_TEMPLATE struct general_matrix_vector_product<Index, double, RowMajorMapper, RowMajor, false, double,
                                                      ColMajorMapper, false, 0>;
SAGITTA_TEMPLATE struct general_matrix_vector_product<Index, double, ColMajorMapper, ColMajor, false, double,
                                                      RowMajorMapper, false, 0>;
SAGITTA_TEMPLATE struct selfadjoint_matrix_vector_product<double, Index, ColMajor, Lower, false, false, 0>;

// Householder reflections by blocks, and what reduces a symmetric matrix to three diagonals and to one.
using MatrixBlock = Block<MatrixXd>;
using RowMajorMatrix = Matrix<double, Dynamic, Dynamic, RowMajor>;
SAGITTA_TEMPLATE void make_block_householder_triangular_factor(RowMajorMatrix&, const MatrixBlock&,
                                                               const VectorBlock<const VectorXd>&);
SAGITTA_TEMPLATE void apply_block_householder_on_the_left(MatrixBlock&, const MatrixBlock&,
                                                          const VectorBlock<const VectorXd>&, bool);
SAGITTA_TEMPLATE void tridiagonalization_inplace(MatrixXd&, VectorXd&);
SAGITTA_TEMPLATE ComputationInfo computeFromTridiagonal_impl(VectorXd&, VectorXd&, Index, bool, MatrixXd&);

using DoubleMapper = blas_data_mapper<double, Index, ColMajor, Unaligned, 1>;
using DenseKernel = gebp_kernel<double, double, Index, DoubleMapper, gebp_traits<double, double>::mr,
                                gebp_traits<double, double>::nr, false, false>;
#ifdef SAGITTA_OWN_DENSE_KERNEL
template <>
void DenseKernel::operator()(const DoubleMapper& result, const double* left, const double* right, Index rows,
                             Index depth, Index columns, double factor, Index left_stride, Index right_stride,
                             Index left_offset, Index right_offset);
#else
SAGITTA_TEMPLATE struct gebp_kernel<double, double, Index, DoubleMapper, gebp_traits<double, double>::mr,
                                    gebp_traits<double, double>::nr, false, false>;
#endif
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
