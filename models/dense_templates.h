// The templates of Eigen that are compiled once. Read twice: as declarations by dense_algebra.h, as definitions by
// dense_algebra.cc; SAGITTA_TEMPLATE says which.

namespace Eigen {

// Members one by one: half of what a whole class has nobody calls.
SAGITTA_TEMPLATE void PartialPivLU<MatrixXd>::compute();
SAGITTA_TEMPLATE void HouseholderQR<MatrixXd>::computeInPlace();
SAGITTA_TEMPLATE void ColPivHouseholderQR<MatrixXd>::computeInPlace();
SAGITTA_TEMPLATE LLT<MatrixXd, Lower>& LLT<MatrixXd, Lower>::compute(const EigenBase<MatrixXd>&);
SAGITTA_TEMPLATE LDLT<MatrixXd, Lower>& LDLT<MatrixXd, Lower>::compute(const EigenBase<MatrixXd>&);
SAGITTA_TEMPLATE ColPivHouseholderQR<MatrixXd>& ColPivHouseholderQR<MatrixXd>::compute(const EigenBase<MatrixXd>&);
SAGITTA_TEMPLATE SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&,
                                                                                             int);
SAGITTA_TEMPLATE void LLT<MatrixXd, Lower>::_solve_impl(const VectorXd&, VectorXd&) const;
SAGITTA_TEMPLATE void LLT<MatrixXd, Lower>::_solve_impl(const MatrixXd&, MatrixXd&) const;
SAGITTA_TEMPLATE void LDLT<MatrixXd, Lower>::_solve_impl(const VectorXd&, VectorXd&) const;
SAGITTA_TEMPLATE void HouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
SAGITTA_TEMPLATE void HouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
SAGITTA_TEMPLATE void ColPivHouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;

namespace internal {

// Products of a matrix and a vector, both ways.
using RowMajorMapper = const_blas_data_mapper<double, Index, RowMajor>;
using ColMajorMapper = const_blas_data_mapper<double, Index, ColMajor>;
SAGITTA_TEMPLATE struct general_matrix_vector_product<Index, double, RowMajorMapper, RowMajor, false, double,
                                                      ColMajorMapper, false, 0>;
SAGITTA_TEMPLATE struct general_matrix_vector_product<Index, double, ColMajorMapper, ColMajor, false, double,
                                                      RowMajorMapper, false, 0>;
SAGITTA_TEMPLATE struct general_matrix_vector_product<Index, double, ColMajorMapper, ColMajor, false, double,
                                                      ColMajorMapper, false, 0>;
SAGITTA_TEMPLATE struct selfadjoint_matrix_vector_product<double, Index, ColMajor, Lower, false, false, 0>;

// Triangular systems of one right-hand side and of many.
SAGITTA_TEMPLATE struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false, ColMajor>;
SAGITTA_TEMPLATE struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, ColMajor>;
SAGITTA_TEMPLATE struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, RowMajor>;
SAGITTA_TEMPLATE struct triangular_solve_vector<double, double, Index, OnTheLeft, UnitLower, false, ColMajor>;
SAGITTA_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor, ColMajor, 1>;
SAGITTA_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor, ColMajor, 1>;
SAGITTA_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor, ColMajor, 1>;
SAGITTA_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, ColMajor, ColMajor, 1>;
SAGITTA_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheRight, Upper, false, RowMajor, ColMajor, 1>;

// Householder reflections, by blocks too, and what reduces a symmetric matrix to three diagonals and to one.
using MatrixBlock = Block<MatrixXd>;
using Reflection = Block<const MatrixXd, Dynamic, 1, false>;
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
// How large the blocks of a product are: 1 for products, 4 for triangular systems.
SAGITTA_TEMPLATE void evaluateProductBlockingSizesHeuristic<double, double, 1, Index>(Index&, Index&, Index&, Index);
SAGITTA_TEMPLATE void evaluateProductBlockingSizesHeuristic<double, double, 4, Index>(Index&, Index&, Index&, Index);
SAGITTA_TEMPLATE struct general_matrix_matrix_product<Index, double, ColMajor, false, double, ColMajor, false, ColMajor,
                                                      1>;
SAGITTA_TEMPLATE struct general_matrix_matrix_product<Index, double, RowMajor, false, double, ColMajor, false, ColMajor,
                                                      1>;
SAGITTA_TEMPLATE struct general_matrix_matrix_product<Index, double, ColMajor, false, double, RowMajor, false, ColMajor,
                                                      1>;
SAGITTA_TEMPLATE struct general_matrix_matrix_product<Index, double, RowMajor, false, double, RowMajor, false, ColMajor,
                                                      1>;

}  // namespace internal

SAGITTA_TEMPLATE void MatrixBase<internal::MatrixBlock>::applyHouseholderOnTheLeft(const internal::Reflection&,
                                                                                   const double&, double*);
SAGITTA_TEMPLATE void MatrixBase<internal::MatrixBlock>::applyHouseholderOnTheRight(const internal::Reflection&,
                                                                                    const double&, double*);
SAGITTA_TEMPLATE void MatrixBase<Block<VectorXd>>::applyHouseholderOnTheLeft(const internal::Reflection&, const double&,
                                                                             double*);

}  // namespace Eigen
