// Products of dynamic matrices, made by Eigen's general template: of a map of the result, because for the result itself
// dense_algebra.h has none.
#include "models/dense_algebra.h"

namespace Eigen {
namespace internal {
namespace {

// Aligned as what it maps is: Eigen does the same steps.
template <typename Result>
using MapOf = Map<Result, AlignedMax>;

MapOf<MatrixXd> Mapped(MatrixXd* matrix) { return {matrix->data(), matrix->rows(), matrix->cols()}; }
MapOf<VectorXd> Mapped(VectorXd* vector) { return {vector->data(), vector->size()}; }

}  // namespace

template <>
template <>
void MatrixProduct<MatrixXd, MatrixXd>::evalTo(MatrixXd& result, const MatrixXd& left, const MatrixXd& right) {
  auto mapped = Mapped(&result);
  evalTo(mapped, left, right);
}
template <>
template <>
void MatrixProduct<MatrixXd, MatrixXd>::scaleAndAddTo(MatrixXd& result, const MatrixXd& left, const MatrixXd& right,
                                                      const double& factor) {
  auto mapped = Mapped(&result);
  scaleAndAddTo(mapped, left, right, factor);
}

template <>
template <>
void MatrixProduct<MatrixXd, ConstTransposed>::evalTo(MatrixXd& result, const MatrixXd& left,
                                                      const ConstTransposed& right) {
  auto mapped = Mapped(&result);
  evalTo(mapped, left, right);
}
template <>
template <>
void MatrixProduct<MatrixXd, ConstTransposed>::scaleAndAddTo(MatrixXd& result, const MatrixXd& left,
                                                             const ConstTransposed& right, const double& factor) {
  auto mapped = Mapped(&result);
  scaleAndAddTo(mapped, left, right, factor);
}

template <>
template <>
void MatrixProduct<ConstTransposed, MatrixXd>::evalTo(MatrixXd& result, const ConstTransposed& left,
                                                      const MatrixXd& right) {
  auto mapped = Mapped(&result);
  evalTo(mapped, left, right);
}
template <>
template <>
void MatrixProduct<ConstTransposed, MatrixXd>::scaleAndAddTo(MatrixXd& result, const ConstTransposed& left,
                                                             const MatrixXd& right, const double& factor) {
  auto mapped = Mapped(&result);
  scaleAndAddTo(mapped, left, right, factor);
}

template <>
template <>
void MatrixProduct<Transposed, MatrixXd>::evalTo(MatrixXd& result, const Transposed& left, const MatrixXd& right) {
  auto mapped = Mapped(&result);
  evalTo(mapped, left, right);
}
template <>
template <>
void MatrixProduct<Transposed, MatrixXd>::scaleAndAddTo(MatrixXd& result, const Transposed& left, const MatrixXd& right,
                                                        const double& factor) {
  auto mapped = Mapped(&result);
  scaleAndAddTo(mapped, left, right, factor);
}

template <>
template <>
void VectorProduct<MatrixXd>::scaleAndAddTo(VectorXd& result, const MatrixXd& left, const VectorXd& right,
                                            const double& factor) {
  auto mapped = Mapped(&result);
  scaleAndAddTo(mapped, left, right, factor);
}
template <>
template <>
void VectorProduct<ConstTransposed>::scaleAndAddTo(VectorXd& result, const ConstTransposed& left, const VectorXd& right,
                                                   const double& factor) {
  auto mapped = Mapped(&result);
  scaleAndAddTo(mapped, left, right, factor);
}
template <>
template <>
void VectorProduct<Transposed>::scaleAndAddTo(VectorXd& result, const Transposed& left, const VectorXd& right,
                                              const double& factor) {
  auto mapped = Mapped(&result);
  scaleAndAddTo(mapped, left, right, factor);
}

}  // namespace internal
}  // namespace Eigen
