#include "estimator/least_squares/batch_algebra.h"

// The order of these is Highway's.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "estimator/least_squares/batch_algebra.cc"
#include "models/batch/targets.h"

#include <hwy/foreach_target.h>  // must come before highway.h

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include "models/batch/shot_program.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, kBatchLanes>;
using V = hn::Vec<Tag>;

// Sums that stay in registers: 4 x 4 with 32 of them, 4 x 2 with 16.
constexpr int kWide = hn::MaxLanes(Tag()) >= 8 ? 4 : 2;

template <int kFirst>
HWY_INLINE void AddBlock(const double* const* rows, std::size_t n, std::size_t a, std::size_t b, double* sums) {
  const Tag d;
  V s[kGramBlock][kWide];
  for (int i = 0; i < kGramBlock; ++i)
    for (int j = 0; j < kWide; ++j) s[i][j] = hn::LoadU(d, sums + (i * kGramBlock + kFirst + j) * kBatchLanes);
  for (std::size_t r = 0; r < n; ++r) {
    V left[kGramBlock];
    for (int i = 0; i < kGramBlock; ++i) left[i] = hn::Load(d, rows[r] + a + i * kBatchLanes);
    for (int j = 0; j < kWide; ++j) {
      const V right = hn::Load(d, rows[r] + b + (kFirst + j) * kBatchLanes);
      for (int i = 0; i < kGramBlock; ++i) s[i][j] = hn::MulAdd(left[i], right, s[i][j]);
    }
  }
  for (int i = 0; i < kGramBlock; ++i)
    for (int j = 0; j < kWide; ++j) hn::StoreU(s[i][j], d, sums + (i * kGramBlock + kFirst + j) * kBatchLanes);
}

}  // namespace

void AddGramBlock(const double* const* rows, std::size_t n, std::size_t a, std::size_t b, double* sums) {
  const std::size_t step = hn::Lanes(Tag());
  for (std::size_t lane = 0; lane < kBatchLanes; lane += step) {
    AddBlock<0>(rows, n, a + lane, b + lane, sums + lane);
    if (kWide < kGramBlock) AddBlock<kGramBlock - kWide>(rows, n, a + lane, b + lane, sums + lane);
  }
}

// sums[a .. a + 4, b .. b + kVectors vectors] += rows' rows
template <int kVectors>
HWY_INLINE void AddProductsOf(const double* rows, std::size_t count, std::size_t columns, std::size_t a, std::size_t b,
                              double* sums) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d);
  V s[kGramBlock][kVectors];
  for (int i = 0; i < kGramBlock; ++i)
    for (int j = 0; j < kVectors; ++j) s[i][j] = hn::Load(d, sums + (a + i) * columns + b + j * lanes);
  for (const double* row = rows; row != rows + count * columns; row += columns) {
    V right[kVectors];
    for (int j = 0; j < kVectors; ++j) right[j] = hn::Load(d, row + b + j * lanes);
    for (int i = 0; i < kGramBlock; ++i) {
      const V left = hn::Set(d, row[a + i]);
      for (int j = 0; j < kVectors; ++j) s[i][j] = hn::MulAdd(left, right[j], s[i][j]);
    }
  }
  for (int i = 0; i < kGramBlock; ++i)
    for (int j = 0; j < kVectors; ++j) hn::Store(s[i][j], d, sums + (a + i) * columns + b + j * lanes);
}

void AddProductsOfRows(const double* rows, std::size_t count, std::size_t columns, double* sums) {
  const std::size_t lanes = hn::Lanes(Tag());
  for (std::size_t a = 0; a < columns; a += kGramBlock) {
    std::size_t b = a / lanes * lanes;
    for (; b + kWide * lanes <= columns; b += kWide * lanes) {
      AddProductsOf<kWide>(rows, count, columns, a, b, sums);
    }
    const std::size_t rest = (columns - b) / lanes;  // together: each alone waits for its own sums
    const auto add = rest < 2 ? AddProductsOf<1> : rest == 2 ? AddProductsOf<2> : AddProductsOf<3>;
    if (rest > 0) add(rows, count, columns, a, b, sums);
  }
}

// Sums that stay in registers: of 24 vectors by 32 registers, of 8 by 16.
constexpr int kDeep = hn::MaxLanes(Tag()) >= 8 ? 3 : 2, kAcross = hn::MaxLanes(Tag()) >= 8 ? 8 : 4;

// strip: so many vectors of rows, a column each `step`.
template <int kVectors, int kColumns>
HWY_INLINE void MultiplyFew(const double* strip, std::size_t step, std::size_t n, const double* w, std::size_t stride,
                            double* product) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d);
  V s[kVectors][kColumns];
  for (int i = 0; i < kVectors; ++i)
    for (int j = 0; j < kColumns; ++j) s[i][j] = hn::Zero(d);
  for (std::size_t c = 0; c < n; ++c) {
    V own[kVectors];
    for (int i = 0; i < kVectors; ++i) own[i] = hn::LoadU(d, strip + c * step + i * lanes);
    for (int j = 0; j < kColumns; ++j) {
      const V factor = hn::Set(d, w[j * n + c]);
      for (int i = 0; i < kVectors; ++i) s[i][j] = hn::MulAdd(own[i], factor, s[i][j]);
    }
  }
  for (int j = 0; j < kColumns; ++j)
    for (int i = 0; i < kVectors; ++i) hn::StoreU(s[i][j], d, product + j * stride + i * lanes);
}

// So many columns of W at a time, of the rest half as many.
template <int kVectors, int kColumns = kAcross>
void MultiplyStrip(const double* strip, std::size_t step, std::size_t n, const double* w, std::size_t k,
                   std::size_t stride, double* product) {
  std::size_t j = 0;
  for (; j + kColumns <= k; j += kColumns)
    MultiplyFew<kVectors, kColumns>(strip, step, n, w + j * n, stride, product + j * stride);
  if constexpr (kColumns > 1)
    MultiplyStrip<kVectors, kColumns / 2>(strip, step, n, w + j * n, k - j, stride, product + j * stride);
}

constexpr std::size_t kFewColumns = 16;  // of X: they stay in the cache wherever they lie

// A strip of rows is copied together, unless it is by itself or columns are few, so that it stays in the cache while
// all columns of W go by; the last one is filled up with zeros to whole vectors.
void MultiplyLanes(const double* x, std::size_t stride, std::size_t rows, std::size_t n, const double* w, std::size_t k,
                   double* product) {
  const std::size_t lanes = hn::Lanes(Tag());
  const std::unique_ptr<double[]> copy(new double[kDeep * lanes * (n + k)]);
  double* const last = copy.get() + kDeep * lanes * n;
  for (std::size_t first = 0; first < rows; first += kDeep * lanes) {
    const std::size_t own = std::min(kDeep * lanes, rows - first), vectors = (own + lanes - 1) / lanes;
    const std::size_t wide = vectors * lanes;
    const bool is_copied = stride != wide && (own < wide || n > kFewColumns);
    for (std::size_t c = 0; c < n && is_copied; ++c)
      std::fill_n(std::copy_n(x + c * stride + first, own, copy.get() + c * wide), wide - own, 0.0);
    const auto multiply = vectors == 1 ? MultiplyStrip<1> : vectors == 2 ? MultiplyStrip<2> : MultiplyStrip<kDeep>;
    multiply(is_copied ? copy.get() : x + first, is_copied ? wide : stride, n, w, k, own < wide ? wide : stride,
             own < wide ? last : product + first);
    for (std::size_t j = 0; j < k && own < wide; ++j) std::copy_n(last + j * wide, own, product + j * stride + first);
  }
}

constexpr int kMostTerms = 12;  // of leverages up to a quarter, 0.25^12 = 6e-8
// Of the residuals: what later terms would add. A score moves by as much at most, a standard deviation by half of it.
constexpr double kNegligible = 1e-7;
constexpr double kSurely = 10.0;  // times what the last two terms say of the next

// From a cell of one lane on.
struct Lanes {
  const ClusterLanes& own;
  std::size_t lane;
  const double* At(std::size_t row, std::size_t column) const {
    return own.cells + (row * own.stride + column) * kBatchLanes + lane;
  }
};

// Numbers that are summed side by side: each sum waits for its last product, four products of two at a time.
constexpr int kSideBySide = 2 * kGramBlock;

// by_column = J' by_row, some columns from c on
template <int kColumns>
HWY_INLINE void TransposeTimes(const Lanes& j, const double* by_row, std::size_t c, double* by_column) {
  const Tag d;
  V sum[kColumns];
  for (V& s : sum) s = hn::Zero(d);
  for (std::size_t r = 0; r < j.own.rows; ++r) {
    const V value = hn::Load(d, by_row + r * kBatchLanes);
    const double* const cells = j.At(r, c);
    for (int k = 0; k < kColumns; ++k) sum[k] = hn::MulAdd(hn::Load(d, cells + k * kBatchLanes), value, sum[k]);
  }
  for (int k = 0; k < kColumns; ++k) hn::Store(sum[k], d, by_column + (c + k) * kBatchLanes);
}

HWY_INLINE void TransposeTimes(const Lanes& j, const double* by_row, double* by_column) {
  std::size_t c = 0;
  for (; c + kSideBySide <= j.own.columns; c += kSideBySide) TransposeTimes<kSideBySide>(j, by_row, c, by_column);
  if (c < j.own.columns) TransposeTimes<kGramBlock>(j, by_row, c, by_column);
}

// Rows of J times numbers by column.
template <int kRows>
HWY_INLINE void RowsTimes(const Lanes& j, std::size_t row, const double* by_column, V (&product)[kRows]) {
  const Tag d;
  V sum[kRows][kGramBlock];
  for (auto& own : sum)
    for (V& s : own) s = hn::Zero(d);
  for (std::size_t c = 0; c < j.own.columns; c += kGramBlock) {
    for (int k = 0; k < kGramBlock; ++k) {
      const V value = hn::Load(d, by_column + (c + k) * kBatchLanes);
      for (int r = 0; r < kRows; ++r) sum[r][k] = hn::MulAdd(hn::Load(d, j.At(row + r, c + k)), value, sum[r][k]);
    }
  }
  for (int r = 0; r < kRows; ++r) product[r] = hn::Add(hn::Add(sum[r][0], sum[r][1]), hn::Add(sum[r][2], sum[r][3]));
}

// Calls `take` with the row and J's row times numbers by column, for every row: most come by points of three.
template <typename Take>
HWY_INLINE void ForEachRowTimes(const Lanes& j, const double* by_column, const Take& take) {
  V three[3], one[1];
  std::size_t r = 0;
  for (; r + 3 <= j.own.rows; r += 3) {
    RowsTimes(j, r, by_column, three);
    for (std::size_t i = 0; i < 3; ++i) take(r + i, three[i]);
  }
  for (; r < j.own.rows; ++r) {
    RowsTimes(j, r, by_column, one);
    take(r, one[0]);
  }
}

// product = matrix numbers, some rows from a on; matrix symmetric and the same in all lanes.
template <int kRows>
HWY_INLINE void SymmetricTimes(const double* matrix, std::size_t n, const double* numbers, std::size_t a,
                               double* product) {
  const Tag d;
  V sum[kRows];
  for (V& s : sum) s = hn::Zero(d);
  for (std::size_t c = 0; c < n; ++c) {
    const V value = hn::Load(d, numbers + c * kBatchLanes);
    for (int k = 0; k < kRows; ++k) sum[k] = hn::MulAdd(hn::Set(d, matrix[c * n + a + k]), value, sum[k]);
  }
  for (int k = 0; k < kRows; ++k) hn::Store(sum[k], d, product + (a + k) * kBatchLanes);
}

HWY_INLINE void SymmetricTimes(const double* matrix, std::size_t n, const double* numbers, double* product) {
  std::size_t a = 0;
  for (; a + kSideBySide <= n; a += kSideBySide) SymmetricTimes<kSideBySide>(matrix, n, numbers, a, product);
  if (a < n) SymmetricTimes<kGramBlock>(matrix, n, numbers, a, product);
}

// s = J'A r with A = (1 - H)^-1/2 = 1 + 1/2 H + 3/8 H^2 + 5/16 H^3 + .., H = J M J': each term is one product by J', M
// and J of the term before. r is moved by the fit's step first.
unsigned ScoresOfLanes(const ClusterLanes& clusters, const ScoreFit& fit, double* work, double* scores) {
  const Tag d;
  unsigned too_long = 0;
  double* const rest_memory = work;
  double* const sum_memory = rest_memory + clusters.rows * kBatchLanes;
  double* const by_column_memory = sum_memory + clusters.rows * kBatchLanes;
  double* const moved_memory = by_column_memory + clusters.columns * kBatchLanes;
  for (std::size_t lane = 0; lane < kBatchLanes; lane += hn::Lanes(d)) {
    const Lanes j = {clusters, lane};
    double *const rest = rest_memory + lane, *const sum = sum_memory + lane;
    double *const by_column = by_column_memory + lane, *const moved = moved_memory + lane;
    const V counts = hn::LoadU(d, fit.counts + lane);
    for (std::size_t c = 0; c < clusters.columns; ++c) {
      hn::Store(hn::Set(d, fit.step[c]), d, moved + c * kBatchLanes);
    }
    V size = hn::Zero(d);
    ForEachRowTimes(j, moved, [&](std::size_t r, V product) HWY_ATTR {
      const V own = hn::Mul(counts, hn::Add(hn::Load(d, j.At(r, clusters.columns)), product));
      hn::Store(own, d, rest + r * kBatchLanes);
      hn::Store(own, d, sum + r * kBatchLanes);
      size = hn::MulAdd(own, own, size);
    });
    const V limit = hn::Mul(hn::Set(d, kNegligible * kNegligible), size);
    double coefficient = 1.0;
    auto settled = hn::Lt(hn::Zero(d), hn::Zero(d));
    for (int k = 1; k <= kMostTerms && !hn::AllTrue(d, settled); ++k) {
      coefficient *= (2.0 * k - 1.0) / (2.0 * k);
      TransposeTimes(j, rest, by_column);
      SymmetricTimes(fit.inverse_normal, clusters.columns, by_column, moved);
      // The first power of H shows a direction of large leverage only as far as r has it: it does not show what
      // follows.
      const V before = k == 1 ? hn::Zero(d) : size;
      size = hn::Zero(d);
      ForEachRowTimes(j, moved, [&](std::size_t r, V own) HWY_ATTR {
        hn::Store(own, d, rest + r * kBatchLanes);
        hn::Store(hn::MulAdd(hn::Set(d, coefficient), own, hn::Load(d, sum + r * kBatchLanes)), d,
                  sum + r * kBatchLanes);
        size = hn::MulAdd(own, own, size);
      });
      // Settled, or the next term would be: |H^k+1 r| is about |H^k r|^2 / |H^k-1 r|.
      const V next = hn::Mul(hn::Mul(hn::Set(d, kSurely * kSurely), size), size);
      settled = hn::Or(hn::Le(size, limit), hn::Le(next, hn::Mul(limit, before)));
    }
    TransposeTimes(j, sum, scores + lane);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Not(settled), bits);
    too_long |= static_cast<unsigned>(bits[0]) << lane;
  }
  return too_long;
}

// |row W|^2 of a row, of columns a .. a + kColumns of W alone
template <int kColumns>
HWY_INLINE V SquaredTimes(const Lanes& j, std::size_t r, const double* root, std::size_t a) {
  const Tag d;
  V sum[kColumns], total = hn::Zero(d);
  for (V& s : sum) s = hn::Zero(d);
  for (std::size_t c = 0; c < a + kColumns; ++c) {
    const V value = hn::Load(d, j.At(r, c));
    const double* const w = root + c * j.own.columns + a;
    for (int k = 0; k < kColumns; ++k) sum[k] = hn::MulAdd(hn::Set(d, w[k]), value, sum[k]);
  }
  for (const V& s : sum) total = hn::MulAdd(s, s, total);
  return total;
}

// h = tr(J M J') = |J W|^2; W is upper triangular: its columns a .. a + b end with row a + b.
void LeveragesOfLanes(const ClusterLanes& clusters, const double* root, double* leverages) {
  const Tag d;
  for (std::size_t lane = 0; lane < kBatchLanes; lane += hn::Lanes(d)) {
    const Lanes j = {clusters, lane};
    V total = hn::Zero(d);
    for (std::size_t r = 0; r < clusters.rows; ++r) {
      std::size_t a = 0;
      for (; a + kSideBySide <= clusters.columns; a += kSideBySide) {
        total = hn::Add(total, SquaredTimes<kSideBySide>(j, r, root, a));
      }
      if (a < clusters.columns) total = hn::Add(total, SquaredTimes<kGramBlock>(j, r, root, a));
    }
    hn::StoreU(total, d, leverages + lane);
  }
}

// Lanes of rows that share deviations, and of a square matrix of as many rows: kRows, or any number (0).
template <int kRows>
struct SharedRows {
  int any_rows;
  std::size_t step;  // from row to row
  double *cells, *factor;

  int size() const { return kRows > 0 ? kRows : any_rows; }
  double* At(int r, int c) const { return cells + r * step + static_cast<std::size_t>(c) * kBatchLanes; }
  double* F(int r, int c) const { return factor + (static_cast<std::size_t>(r) * size() + c) * kBatchLanes; }
};

// u_rk of C = 1 + L L' = U D U', below.
template <int kRows>
HWY_INLINE V Rest(const SharedRows<kRows>& rows, int r, int k, int latent, int count) {
  const Tag d;
  V sum = hn::Set(d, r == k ? 1.0 : 0.0);
  for (int i = latent; i < latent + count; ++i) {
    sum = hn::MulAdd(hn::Load(d, rows.At(r, i)), hn::Load(d, rows.At(k, i)), sum);
  }
  for (int i = 0; i < k; ++i) sum = hn::NegMulAdd(hn::Load(d, rows.F(i, r)), hn::Load(d, rows.F(k, i)), sum);
  return sum;
}

// U lower triangular with a unit diagonal, column by column:
//   D_k = u_kk,  U_rk = u_rk / D_k,  u_rk = C_rk - sum_{i < k} u_ri U_ki
// u_rk lies above the diagonal, D^-1/2 on it.
template <int kRows>
void Factor(const SharedRows<kRows>& rows, int latent, int count) {
  const Tag d;
  for (int k = 0; k < rows.size(); ++k) {
    const V inverse = hn::Div(hn::Set(d, 1.0), Rest(rows, k, k, latent, count));
    hn::Store(hn::Sqrt(inverse), d, rows.F(k, k));
    for (int r = k + 1; r < rows.size(); ++r) {
      const V rest = Rest(rows, r, k, latent, count);
      hn::Store(rest, d, rows.F(k, r));
      hn::Store(hn::Mul(rest, inverse), d, rows.F(r, k));
    }
  }
}

// From row k on; by recursion: all of x stays in registers. rows by value: a reference is read anew after stores.
template <int k, int kRows, int kColumns>
HWY_INLINE void Eliminate(SharedRows<kRows> rows, int column, V (&x)[kRows][kColumns]) {
  if constexpr (k < kRows) {
    const Tag d;
    const V scale = hn::Load(d, rows.F(k, k));
    for (int c = 0; c < kColumns; ++c) hn::Store(hn::Mul(scale, x[k][c]), d, rows.At(k, column + c));
    for (int r = k + 1; r < kRows; ++r) {
      const V factor = hn::Load(d, rows.F(r, k));
      for (int c = 0; c < kColumns; ++c) x[r][c] = hn::NegMulAdd(factor, x[k][c], x[r][c]);
    }
    Eliminate<k + 1>(rows, column, x);
  }
}

// Columns <- D^-1/2 U^-1 columns; some side by side: in one of them each row waits for the row before.
template <int kColumns, int kRows>
void Solve(SharedRows<kRows> rows, int column) {
  const Tag d;
  if constexpr (kRows > 0) {
    V x[kRows][kColumns];
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < kColumns; ++c) x[r][c] = hn::Load(d, rows.At(r, column + c));
    }
    Eliminate<0>(rows, column, x);
  } else {
    for (int k = 0; k < rows.size(); ++k) {
      V x = hn::Load(d, rows.At(k, column));
      for (int i = 0; i < k; ++i) x = hn::NegMulAdd(hn::Load(d, rows.F(k, i)), hn::Load(d, rows.At(i, column)), x);
      hn::Store(x, d, rows.At(k, column));
    }
    for (int k = 0; k < rows.size(); ++k) {
      hn::Store(hn::Mul(hn::Load(d, rows.F(k, k)), hn::Load(d, rows.At(k, column))), d, rows.At(k, column));
    }
  }
}

template <int kRows>
void MarginaliseRowsOf(int num_rows, int columns, int latent, int count, double* cells, double* factor) {
  // What registers hold: rows of two columns of 32, of one of 16.
  constexpr int kAtOnce = kRows > 0 && hn::MaxLanes(Tag()) >= 8 ? 2 : 1;
  for (std::size_t lane = 0; lane < kBatchLanes; lane += hn::Lanes(Tag())) {
    const SharedRows<kRows> rows = {num_rows, static_cast<std::size_t>(columns) * kBatchLanes, cells + lane,
                                    factor + lane};
    Factor(rows, latent, count);
    int c = 0;
    for (; c + kAtOnce <= latent; c += kAtOnce) Solve<kAtOnce>(rows, c);
    for (; c < latent; ++c) Solve<1>(rows, c);
  }
}

void MarginaliseRows(int num_rows, int columns, int latent, int count, double* rows, double* factor) {
  const auto marginalise = num_rows == 9   ? MarginaliseRowsOf<9>
                           : num_rows == 6 ? MarginaliseRowsOf<6>
                           : num_rows == 3 ? MarginaliseRowsOf<3>
                                           : MarginaliseRowsOf<0>;
  marginalise(num_rows, columns, latent, count, rows, factor);
}

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sagitta {

double* Aligned(double* p) {
  constexpr std::size_t kAlignment = kBatchLanes * sizeof(double);
  const std::uintptr_t past = reinterpret_cast<std::uintptr_t>(p) % kAlignment;
  return past == 0 ? p : p + (kAlignment - past) / sizeof(double);
}

HWY_EXPORT(AddGramBlock);
HWY_EXPORT(AddProductsOfRows);
HWY_EXPORT(MarginaliseRows);
HWY_EXPORT(MultiplyLanes);
HWY_EXPORT(ScoresOfLanes);
HWY_EXPORT(LeveragesOfLanes);

GramSums::GramSums(int blocks_a, int blocks_b, bool symmetric)
    : blocks_a_(blocks_a), blocks_b_(blocks_b), symmetric_(symmetric) {
  const int blocks = symmetric ? blocks_a * (blocks_a + 1) / 2 : blocks_a * blocks_b;
  lanes_.assign(static_cast<std::size_t>(blocks) * kGramBlock * kGramBlock * kBatchLanes, 0.0);
}

void GramSums::Add(const std::vector<const double*>& rows, int first_a, int first_b) {
  constexpr std::size_t kBlockLanes = kGramBlock * kBatchLanes;
  double* block = lanes_.data();
  for (int i = 0; i < blocks_a_; ++i) {
    for (int j = symmetric_ ? i : 0; j < blocks_b_; ++j, block += kGramBlock * kBlockLanes) {
      HWY_DYNAMIC_DISPATCH(AddGramBlock)
      (rows.data(), rows.size(), first_a * kBatchLanes + i * kBlockLanes, first_b * kBatchLanes + j * kBlockLanes,
       block);
    }
  }
}

std::vector<double> GramSums::Totals() const {
  std::vector<double> totals(static_cast<std::size_t>(blocks_a_) * kGramBlock * columns_b(), 0.0);
  const double* lanes = lanes_.data();
  for (int i = 0; i < blocks_a_; ++i) {
    for (int j = symmetric_ ? i : 0; j < blocks_b_; ++j) {
      double* const cell = totals.data() + i * kGramBlock * columns_b() + j * kGramBlock;
      for (int k = 0; k < kGramBlock * kGramBlock; ++k, lanes += kBatchLanes) {
        cell[k / kGramBlock * columns_b() + k % kGramBlock] = std::accumulate(lanes, lanes + kBatchLanes, 0.0);
      }
    }
  }
  return totals;
}

void AddProducts(const double* rows, std::size_t count, std::size_t columns, double* sums) {
  HWY_DYNAMIC_DISPATCH(AddProductsOfRows)(rows, count, columns, sums);
}

void MultiplyColumns(const double* x, std::size_t stride, std::size_t rows, std::size_t n, const double* w,
                     std::size_t k, double* product) {
  HWY_DYNAMIC_DISPATCH(MultiplyLanes)(x, stride, rows, n, w, k, product);
}

unsigned ScoreClusters(const ClusterLanes& clusters, const ScoreFit& fit, double* work, double* scores) {
  return HWY_DYNAMIC_DISPATCH(ScoresOfLanes)(clusters, fit, work, scores);
}

void LeveragesOf(const ClusterLanes& clusters, const double* root, double* leverages) {
  HWY_DYNAMIC_DISPATCH(LeveragesOfLanes)(clusters, root, leverages);
}

void MarginaliseLanes(int num_rows, int columns, int latent, int count, double* rows, double* factor) {
  HWY_DYNAMIC_DISPATCH(MarginaliseRows)(num_rows, columns, latent, count, rows, factor);
}

}  // namespace sagitta
#endif
