#include "estimator/explanations/scan.h"

namespace sagitta {
namespace {

// Of the square of a unit in all shots: below, a jump's variation is rounding.
constexpr double kVaries = 1e-12;

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

}  // namespace sagitta
