#include "estimator/explanations/scan.h"

#include <limits>

namespace sagitta {
namespace {

// Of the square of a unit in all shots: below, a jump's variation is rounding.
constexpr double kVaries = 1e-12;
// Of the largest square of a source: a direction that moves the rows less is none.
constexpr double kDetermined = 1e-9;

}  // namespace

double AlongSources::Reduction(Eigen::ArrayXd function, long source, bool is_offset) const {
  const Eigen::ArrayXd weights = square.col(source).array();
  if (is_offset) function -= (weights * function).sum() / std::max(weights.sum(), 1e-300);
  const double along = (function * residual.col(source).array()).sum();
  const double all = (weights * function.square()).sum();
  return all > 0.0 ? along * along / all : 0.0;
}

// The jump f is 0 before and 1 beyond the gap. With sums over the shots beyond it (a1, b1) and over all (a, b), counted
// from its mean a1 / a:  f'b = b1 - (a1 / a) b,  sum a f^2 = a1 - a1^2 / a. Sums from the last shot on give every gap.
std::vector<TriedJump> TryJumps(const AlongSources& along, const std::vector<int>& fitted, const Eigen::VectorXd& x,
                                const JumpsToTry& jumps) {
  std::vector<int> order = fitted;
  std::sort(order.begin(), order.end(), [&x](int a, int b) { return x[a] < x[b]; });
  const auto count = static_cast<long>(order.size());
  Eigen::MatrixXd squares = along.square(order, Eigen::seqN(jumps.first, jumps.count));
  Eigen::MatrixXd residuals = along.residual(order, Eigen::seqN(jumps.first, jumps.count));
  for (long s = count - 2; s >= 0; --s) {
    squares.row(s) += squares.row(s + 1);
    residuals.row(s) += residuals.row(s + 1);
  }
  std::vector<TriedJump> tried;
  for (const Gap& gap : Gaps(x(order), jumps.most_gaps)) {
    const long below =
        std::partition_point(order.begin(), order.end(), [&](int s) { return x[s] < gap.second; }) - order.begin();
    if (std::min(below, count - below) < jumps.fewest_of_a_side) continue;
    double reduction = 0.0;
    for (long source = 0; source < jumps.count; ++source) {
      const double all = squares(0, source), beyond = squares(below, source), mean = beyond / std::max(all, 1e-300);
      const double varies = beyond - mean * beyond;
      const double moved = residuals(below, source) - mean * residuals(0, source);
      if (varies > kVaries * all) reduction += moved * moved / varies;
    }
    tried.push_back({gap, reduction});
  }
  return tried;
}

namespace {

// Sums over the shots before each place where a jump may lie, the first and the last included.
struct JumpSums {
  std::vector<Gap> gaps;
  Eigen::MatrixXd products, residuals;  // a row for each place

  // Of chi-square, by a value of its own of each source from one place to another: b'A^-1 b.
  double Explained(long from, long to) const {
    const long sources = residuals.cols();
    const Eigen::VectorXd along = residuals.row(to) - residuals.row(from);
    Eigen::MatrixXd all = (products.row(to) - products.row(from)).reshaped(sources, sources);
    const double most = all.diagonal().maxCoeff();
    if (!(most > 0.0)) return 0.0;
    all.diagonal().array() += kDetermined * most;
    return along.dot(all.llt().solve(along));
  }
};

JumpSums SumBefore(const AlongSources& along, const std::vector<int>& fitted, const Eigen::VectorXd& x, int most_gaps) {
  std::vector<int> order = fitted;
  std::sort(order.begin(), order.end(), [&x](int a, int b) { return x[a] < x[b]; });
  JumpSums sums{Gaps(x(order), most_gaps), {}, {}};
  const long places = static_cast<long>(sums.gaps.size()) + 2;
  sums.products = Eigen::MatrixXd::Zero(places, along.products.cols());
  sums.residuals = Eigen::MatrixXd::Zero(places, along.residual.cols());
  long place = 1;
  for (const int s : order) {
    while (place + 1 < places && x[s] >= sums.gaps[static_cast<size_t>(place) - 1].second) ++place;
    sums.products.row(place) += along.products.row(s);
    sums.residuals.row(place) += along.residual.row(s);
  }
  for (long p = 1; p < places; ++p) {
    sums.products.row(p) += sums.products.row(p - 1);
    sums.residuals.row(p) += sums.residuals.row(p - 1);
  }
  return sums;
}

}  // namespace

// most(k, p) = max over i < p of most(k - 1, i) + explained(i, p): the most that k jumps before the place p explain.
std::vector<std::vector<Gap>> BestJumps(const AlongSources& along, const std::vector<int>& fitted,
                                        const Eigen::VectorXd& x, int most_gaps, size_t most_jumps) {
  const JumpSums sums = SumBefore(along, fitted, x, most_gaps);
  const long places = sums.residuals.rows();
  const long jumps = std::min<long>(static_cast<long>(most_jumps), places - 2);
  Eigen::MatrixXd explained(places, places);
  for (long p = 1; p < places; ++p) {
    for (long i = 0; i < p; ++i) explained(i, p) = sums.Explained(i, p);
  }
  Eigen::MatrixXd most = Eigen::MatrixXd::Constant(jumps + 1, places, -std::numeric_limits<double>::infinity());
  Eigen::MatrixXi from = Eigen::MatrixXi::Zero(jumps + 1, places);
  most.row(0).tail(places - 1) = explained.row(0).tail(places - 1);
  for (long k = 1; k <= jumps; ++k) {
    for (long p = k + 1; p < places; ++p) {
      most(k, p) = (most.row(k - 1).head(p).transpose() + explained.col(p).head(p)).maxCoeff(&from(k, p));
    }
  }
  std::vector<std::vector<Gap>> best(static_cast<size_t>(jumps) + 1);
  for (long k = 1; k <= jumps; ++k) {
    for (long left = k, p = places - 1; left > 0; --left) {
      p = from(left, p);
      best[static_cast<size_t>(k)].insert(best[static_cast<size_t>(k)].begin(), sums.gaps[static_cast<size_t>(p) - 1]);
    }
  }
  return best;
}

}  // namespace sagitta
