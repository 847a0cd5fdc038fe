// Eigen with its decompositions and products of dynamic matrices, compiled once (dense_algebra.cc, dense_jacobi_svd.cc,
// dense_products.cc) rather than in each file that uses them. Precompiled into every source of the library: most of the
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

namespace Eigen {
namespace internal {

// Of these only the declarations are Eigen's: without a body, no file that multiplies matrices compiles what choosing
// between sizes needs (a product of rows, of columns, coefficient by coefficient, by blocks).
using ConstTransposed = Transpose<const MatrixXd>;
using Transposed = Transpose<MatrixXd>;
template <typename Left, typename Right>
using MatrixProduct = generic_product_impl<Left, Right, DenseShape, DenseShape, GemmProduct>;
template <typename Left>
using VectorProduct = generic_product_impl<Left, VectorXd, DenseShape, DenseShape, GemvProduct>;

template <>
template <>
void MatrixProduct<MatrixXd, MatrixXd>::evalTo(MatrixXd& result, const MatrixXd& left, const MatrixXd& right);
template <>
template <>
void MatrixProduct<MatrixXd, MatrixXd>::scaleAndAddTo(MatrixXd& result, const MatrixXd& left, const MatrixXd& right,
                                                      const double& factor);
template <>
template <>
void MatrixProduct<MatrixXd, ConstTransposed>::evalTo(MatrixXd& result, const MatrixXd& left,
                                                      const ConstTransposed& right);
template <>
template <>
void MatrixProduct<MatrixXd, ConstTransposed>::scaleAndAddTo(MatrixXd& result, const MatrixXd& left,
                                                             const ConstTransposed& right, const double& factor);
template <>
template <>
void MatrixProduct<ConstTransposed, MatrixXd>::evalTo(MatrixXd& result, const ConstTransposed& left,
                                                      const MatrixXd& right);
template <>
template <>
void MatrixProduct<ConstTransposed, MatrixXd>::scaleAndAddTo(MatrixXd& result, const ConstTransposed& left,
                                                             const MatrixXd& right, const double& factor);
template <>
template <>
void MatrixProduct<Transposed, MatrixXd>::evalTo(MatrixXd& result, const Transposed& left, const MatrixXd& right);
template <>
template <>
void MatrixProduct<Transposed, MatrixXd>::scaleAndAddTo(MatrixXd& result, const Transposed& left, const MatrixXd& right,
                                                        const double& factor);
template <>
template <>
void VectorProduct<MatrixXd>::scaleAndAddTo(VectorXd& result, const MatrixXd& left, const VectorXd& right,
                                            const double& factor);
template <>
template <>
void VectorProduct<ConstTransposed>::scaleAndAddTo(VectorXd& result, const ConstTransposed& left, const VectorXd& right,
                                                   const double& factor);
template <>
template <>
void VectorProduct<Transposed>::scaleAndAddTo(VectorXd& result, const Transposed& left, const VectorXd& right,
                                              const double& factor);

}  // namespace internal
}  // namespace Eigen

#define SAGITTA_TEMPLATE extern template
#include "models/dense_templates.h"
#undef SAGITTA_TEMPLATE

namespace Eigen {
extern template class JacobiSVD<MatrixXd>;
}
