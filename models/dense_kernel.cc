// The innermost product of Eigen's products, triangular solves and decompositions of matrices of doubles, with the
// instructions that the machine has: Eigen chooses them when it is compiled, and for every x86-64 that is SSE2, a
// quarter of what AVX2 does in the same time. Operands as Eigen 3.4 packs them: panels of four rows, then of two, then
// single rows; panels of four columns, then single columns.
#include "models/dense_algebra.h"

#ifdef SAGITTA_OWN_DENSE_KERNEL

// The order of these is Highway's.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "models/dense_kernel.cc"
#include "models/batch/targets.h"

#include <hwy/foreach_target.h>  // must come before highway.h

#include <hwy/highway.h>
// clang-format on

#ifndef SAGITTA_PACKED_PANELS
#define SAGITTA_PACKED_PANELS
namespace sagitta {

constexpr Eigen::Index kRowsOfPanel = 4, kColumnsOfPanel = 4;

// Packed rows or columns: number i of step k of the panel that begins at `first` is at
// numbers[first stride + width (offset + k) + i].
struct PackedPanels {
  const double* numbers;
  Eigen::Index count, stride, offset;

  const double* At(Eigen::Index first, Eigen::Index width) const { return numbers + first * stride + width * offset; }
};

// result (column by column) += factor left right
struct PackedProduct {
  PackedPanels left, right;
  Eigen::Index depth;
  double factor;
  double* result;
  Eigen::Index stride;
};

}  // namespace sagitta
#endif

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// kPanels panels of kRows rows times one of kColumns columns. Sums stay in registers: three panels of four by four
// columns need 12 of the 16 vectors of AVX2. An addition waits for the one before it, four cycles: fewer than eight
// sums are made in several sets, each of every second or fourth step.
template <int kRows, int kPanels, int kColumns>
struct Tile {
  static constexpr int kLanes = hn::MaxLanes(hn::CappedTag<double, kRows>()), kPerPanel = kRows / kLanes;
  static constexpr int kVectors = kPanels * kPerPanel, kSums = kVectors * kColumns;
  static constexpr int kSets = kSums >= 8 ? 1 : kSums >= 4 ? 2 : 4;
  using D = hn::CappedTag<double, kRows>;
  using V = hn::Vec<D>;

  HWY_INLINE void AddStep(const double* left, const double* right, Eigen::Index to_next, V (*sum)[kVectors]) {
    const D d;
    V own[kVectors];
    for (int i = 0; i < kVectors; ++i) own[i] = hn::LoadU(d, left + i / kPerPanel * to_next + i % kPerPanel * kLanes);
    for (int j = 0; j < kColumns; ++j) {
      const V factor = hn::Set(d, right[j]);
      for (int i = 0; i < kVectors; ++i) sum[j][i] = hn::MulAdd(own[i], factor, sum[j][i]);
    }
  }

  HWY_INLINE void Add(const PackedProduct& p, Eigen::Index row, Eigen::Index column) {
    const D d;
    V sum[kSets][kColumns][kVectors];
    for (auto& set : sum) {
      for (auto& of_column : set) {
        for (V& one : of_column) one = hn::Zero(d);
      }
    }
    const double* left = p.left.At(row, kRows);
    const double* right = p.right.At(column, kColumns);
    const Eigen::Index to_next = kRows * p.left.stride;
    Eigen::Index k = 0;
    for (; k + kSets <= p.depth; k += kSets, left += kSets * kRows, right += kSets * kColumns) {
      for (int s = 0; s < kSets; ++s) AddStep(left + s * kRows, right + s * kColumns, to_next, sum[s]);
    }
    for (; k < p.depth; ++k, left += kRows, right += kColumns) AddStep(left, right, to_next, sum[0]);
    const V factor = hn::Set(d, p.factor);
    for (int j = 0; j < kColumns; ++j) {
      double* result = p.result + row + (column + j) * p.stride;
      for (int i = 0; i < kVectors; ++i, result += kLanes) {
        for (int s = 1; s < kSets; ++s) sum[0][j][i] = hn::Add(sum[0][j][i], sum[s][j][i]);
        hn::StoreU(hn::MulAdd(factor, sum[0][j][i], hn::LoadU(d, result)), d, result);
      }
    }
  }
};

template <int kRows, int kPanels>
HWY_INLINE void AddRows(const PackedProduct& p, Eigen::Index row) {
  Eigen::Index column = 0;
  for (; column + kColumnsOfPanel <= p.right.count; column += kColumnsOfPanel) {
    Tile<kRows, kPanels, kColumnsOfPanel>().Add(p, row, column);
  }
  for (; column < p.right.count; ++column) Tile<kRows, kPanels, 1>().Add(p, row, column);
}

}  // namespace

void AddPackedProduct(const PackedProduct& p) {
  constexpr int kTogether = hn::MaxLanes(hn::CappedTag<double, kRowsOfPanel>()) == kRowsOfPanel ? 3 : 1;
  const Eigen::Index rows = p.left.count;
  Eigen::Index row = 0;
  for (; row + kTogether * kRowsOfPanel <= rows; row += kTogether * kRowsOfPanel)
    AddRows<kRowsOfPanel, kTogether>(p, row);
  for (; row + 2 * kRowsOfPanel <= rows; row += 2 * kRowsOfPanel) AddRows<kRowsOfPanel, 2>(p, row);
  for (; row + kRowsOfPanel <= rows; row += kRowsOfPanel) AddRows<kRowsOfPanel, 1>(p, row);
  for (; row + 2 <= rows; row += 2) AddRows<2, 1>(p, row);
  for (; row < rows; ++row) AddRows<1, 1>(p, row);
}

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sagitta {
namespace {

HWY_EXPORT(AddPackedProduct);

void AddProduct(const PackedProduct& p) { HWY_DYNAMIC_DISPATCH(AddPackedProduct)(p); }

}  // namespace
}  // namespace sagitta

namespace Eigen::internal {

template <>
void DenseKernel::operator()(const DoubleMapper& result, const double* left, const double* right, Index rows,
                             Index depth, Index columns, double factor, Index left_stride, Index right_stride,
                             Index left_offset, Index right_offset) {
  if (rows == 0 || columns == 0) return;
  sagitta::AddProduct({{left, rows, left_stride == -1 ? depth : left_stride, left_offset},
                       {right, columns, right_stride == -1 ? depth : right_stride, right_offset},
                       depth,
                       factor,
                       &result(0, 0),
                       result.stride()});
}

}  // namespace Eigen::internal
#endif

#endif
