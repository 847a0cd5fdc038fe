#include "estimator/least_squares/normal_algebra.h"

// The order of these is Highway's.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "estimator/least_squares/normal_algebra.cc"
#include "models/batch/targets.h"

#include <hwy/foreach_target.h>  // must come before highway.h

#include <hwy/aligned_allocator.h>
#include <hwy/highway.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "models/batch/shot_program.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, kBatchLanes>;
using V = hn::Vec<Tag>;
constexpr std::size_t kBlock = 4;  // columns that are looked at together
// By as many others: their sums stay in registers, 4 x 4 with 32 of them, 4 x 2 with 16.
constexpr std::size_t kAcross = hn::MaxLanes(Tag()) >= 8 ? 4 : 2;
constexpr std::size_t kRegisters = kBatchLanes / hn::MaxLanes(Tag());  // of kBatchLanes numbers

// to += factor from, numbers [first, last): multiples of the lanes
HWY_INLINE void AddTimes(double factor, const double* from, std::size_t first, std::size_t last, double* to) {
  const Tag d;
  const V f = hn::Set(d, factor);
  for (std::size_t i = first; i < last; i += hn::Lanes(d)) {
    hn::Store(hn::MulAdd(f, hn::Load(d, from + i), hn::Load(d, to + i)), d, to + i);
  }
}
HWY_INLINE void Scale(double factor, std::size_t first, std::size_t last, double* numbers) {
  const Tag d;
  for (std::size_t i = first; i < last; i += hn::Lanes(d)) {
    hn::Store(hn::Mul(hn::Set(d, factor), hn::Load(d, numbers + i)), d, numbers + i);
  }
}
HWY_INLINE std::size_t Down(std::size_t i) { return i / hn::Lanes(Tag()) * hn::Lanes(Tag()); }
HWY_INLINE std::size_t Up(std::size_t i) { return Down(i + hn::Lanes(Tag()) - 1); }

// The first `count` numbers at p, fewer than a vector; zeros follow. Without masks of the instruction set MaskedLoad
// reads a whole vector, beyond the end, and from aligned places alone.
HWY_INLINE V LoadRest(const double* p, std::size_t count) {
  const Tag d;
#if HWY_MEM_OPS_MIGHT_FAULT
  HWY_ALIGN double padded[hn::MaxLanes(Tag())] = {};
  std::copy(p, p + count, padded);
  return hn::Load(d, padded);
#else
  return hn::MaskedLoad(hn::FirstN(d, count), d, p);
#endif
}

}  // namespace

// j: n columns of `rows` numbers; product: n x n.
void SelfProductOfLanes(const double* j, std::size_t rows, std::size_t n, double* product) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d), whole = Down(rows);
  for (std::size_t a = 0; a < n; a += kBlock) {
    for (std::size_t b = a; b < n; b += kAcross) {
      const double *x[kBlock], *y[kAcross];
      V sum[kBlock][kAcross];
      for (std::size_t k = 0; k < kAcross; ++k) y[k] = j + std::min(b + k, n - 1) * rows;
      for (std::size_t i = 0; i < kBlock; ++i) {
        x[i] = j + std::min(a + i, n - 1) * rows;
        for (std::size_t k = 0; k < kAcross; ++k) sum[i][k] = hn::Zero(d);
      }
      const auto add = [&](const auto& load) HWY_ATTR {
        V own[kBlock];
        for (std::size_t i = 0; i < kBlock; ++i) own[i] = load(x[i]);
        for (std::size_t k = 0; k < kAcross; ++k) {
          const V other = load(y[k]);
          for (std::size_t i = 0; i < kBlock; ++i) sum[i][k] = hn::MulAdd(own[i], other, sum[i][k]);
        }
      };
      for (std::size_t r = 0; r < whole; r += lanes) add([&](const double* p) HWY_ATTR { return hn::LoadU(d, p + r); });
      if (whole < rows) add([&](const double* p) HWY_ATTR { return LoadRest(p + whole, rows - whole); });
      double total[kBlock][kAcross];  // sums that were indexed by variables would leave their registers
      for (std::size_t i = 0; i < kBlock; ++i) {
        for (std::size_t k = 0; k < kAcross; ++k) total[i][k] = hn::GetLane(hn::SumOfLanes(d, sum[i][k]));
      }
      for (std::size_t i = 0; i < std::min(kBlock, n - a); ++i) {
        for (std::size_t k = 0; k < std::min(kAcross, n - b); ++k) {
          product[(a + i) * n + b + k] = product[(b + k) * n + a + i] = total[i][k];
        }
      }
    }
  }
}

// a = L L', column by column; then root = L^-T, column by column, zero before. Columns are `stride` numbers apart,
// aligned; what lies above the diagonal of a is not looked at. False: a pivot is not positive.
bool InverseRootOfLanes(std::size_t n, std::size_t stride, double* a, double* root) {
  for (std::size_t k = 0; k < n; ++k) {
    double* const own = a + k * stride;
    if (!(own[k] > 0.0) || !std::isfinite(own[k])) return false;
    const double inverse = 1.0 / std::sqrt(own[k]);
    Scale(inverse, Down(k), Up(n), own);
    for (std::size_t c = k + 1; c < n; ++c) AddTimes(-own[c], own, Down(c), Up(n), a + c * stride);
    own[k] = inverse;
  }
  for (std::size_t c = 0; c < n; ++c) {
    double* const column = root + c * stride;
    column[c] = 1.0;
    for (std::size_t k = 0; k < c; ++k) AddTimes(-a[k * stride + c], root + k * stride, 0, Up(k + 1), column);
    Scale(a[c * stride + c], 0, Up(c + 1), column);
  }
  return true;
}

// How many eigenvalues of a symmetric tridiagonal matrix lie below each of kBatchLanes numbers x: the signs of Sturm's
// q_i = d_i - x - e_i^2 / q_i-1; e_i: before d_i, e_0 = 0.
void CountBelow(const double* diagonal, const double* squares, std::size_t n, const double* x, double* counts) {
  const Tag d;
  const V least = hn::Set(d, 1e-290), one = hn::Set(d, 1.0);
  V q[kRegisters], own[kRegisters], count[kRegisters];
  for (std::size_t k = 0; k < kRegisters; ++k) {
    own[k] = hn::LoadU(d, x + k * hn::Lanes(d));
    q[k] = one;
    count[k] = hn::Zero(d);
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < kRegisters; ++k) {
      const V next = hn::Sub(hn::Sub(hn::Set(d, diagonal[i]), own[k]), hn::Div(hn::Set(d, squares[i]), q[k]));
      q[k] = hn::IfThenElse(hn::Lt(hn::Abs(next), least), hn::Neg(least), next);
      count[k] = hn::Add(count[k], hn::IfThenElseZero(hn::Lt(q[k], hn::Zero(d)), one));
    }
  }
  for (std::size_t k = 0; k < kRegisters; ++k) hn::StoreU(count[k], d, counts + k * hn::Lanes(d));
}

// square = W W', the columns of W `stride` numbers apart and aligned; its upper triangle, zero before.
void SquareOfLanes(std::size_t n, std::size_t stride, const double* root, double* square) {
  for (std::size_t c = 0; c < n; ++c) {
    for (std::size_t k = 0; k <= c; ++k) {
      AddTimes(root[c * stride + k], root + c * stride, 0, Up(k + 1), square + k * stride);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sagitta {
namespace {

HWY_EXPORT(SelfProductOfLanes);
HWY_EXPORT(InverseRootOfLanes);
HWY_EXPORT(SquareOfLanes);
HWY_EXPORT(CountBelow);

// Columns of a square matrix, each aligned; zero.
class Padded {
 public:
  explicit Padded(Eigen::Index n)
      : n_(n),
        stride_((n + kBatchLanes - 1) / kBatchLanes * kBatchLanes),
        memory_(hwy::AllocateAligned<double>(static_cast<std::size_t>(n * stride_))) {
    std::fill(memory_.get(), memory_.get() + n * stride_, 0.0);
  }
  explicit Padded(const Eigen::MatrixXd& matrix) : Padded(matrix.cols()) { Matrix() = matrix; }

  Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> Matrix() {
    return {memory_.get(), n_, n_, Eigen::OuterStride<>(stride_)};
  }
  double* data() { return memory_.get(); }
  std::size_t stride() const { return static_cast<std::size_t>(stride_); }

 private:
  Eigen::Index n_, stride_;
  hwy::AlignedFreeUniquePtr<double[]> memory_;
};

}  // namespace

Eigen::MatrixXd SelfProduct(const Eigen::MatrixXd& j) {
  Eigen::MatrixXd product(j.cols(), j.cols());
  if (j.size() == 0) return product.setZero();
  HWY_DYNAMIC_DISPATCH(SelfProductOfLanes)
  (j.data(), static_cast<std::size_t>(j.rows()), static_cast<std::size_t>(j.cols()), product.data());
  return product;
}

Eigen::MatrixXd InverseRoot(const Eigen::MatrixXd& a) {
  if (a.size() == 0) return {};
  Padded work(a), root(a.cols());
  const auto n = static_cast<std::size_t>(a.cols());
  if (!HWY_DYNAMIC_DISPATCH(InverseRootOfLanes)(n, work.stride(), work.data(), root.data())) return {};
  return root.Matrix();
}

// Both ends at once: half of the lanes cut what brackets the least, the others what brackets the largest.
std::pair<double, double> EndsOfSpectrum(const Eigen::MatrixXd& a) {
  constexpr int kCuts = kBatchLanes / 2;
  constexpr int kRounds = 24;  // (kCuts + 1)^24 is beyond the digits of a double
  const Eigen::Tridiagonalization<Eigen::MatrixXd> reduced(a);
  const Eigen::VectorXd diagonal = reduced.diagonal();
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(diagonal.size());
  squares.tail(diagonal.size() - 1) = reduced.subDiagonal().cwiseAbs2();
  const double norm = a.cwiseAbs().rowwise().sum().maxCoeff();
  const double below[2] = {1.0, static_cast<double>(diagonal.size())};  // that many lie below where the end does
  double low[2] = {-norm, -norm}, width[2] = {2.0 * norm, 2.0 * norm};
  for (int round = 0; round < kRounds; ++round) {
    double x[kBatchLanes], counts[kBatchLanes];
    for (int i = 0; i < kBatchLanes; ++i) x[i] = low[i / kCuts] + width[i / kCuts] * (i % kCuts + 1) / (kCuts + 1);
    HWY_DYNAMIC_DISPATCH(CountBelow)
    (diagonal.data(), squares.data(), static_cast<std::size_t>(diagonal.size()), x, counts);
    for (int end = 0; end < 2; ++end) {
      width[end] /= kCuts + 1;
      for (int i = end * kCuts; i < (end + 1) * kCuts && counts[i] < below[end]; ++i) low[end] = x[i];
    }
  }
  return {low[0] + 0.5 * width[0], low[1] + 0.5 * width[1]};
}

Eigen::MatrixXd SquareOfRoot(const Eigen::MatrixXd& w) {
  if (w.size() == 0) return w;
  Padded root(w), square(w.cols());
  HWY_DYNAMIC_DISPATCH(SquareOfLanes)(static_cast<std::size_t>(w.cols()), root.stride(), root.data(), square.data());
  return square.Matrix().selfadjointView<Eigen::Upper>();
}

}  // namespace sagitta
#endif
