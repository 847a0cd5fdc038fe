#include "estimator/least_squares/bounded_step.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/least_squares/normal_algebra.h"

namespace sagitta {
namespace {

// The Gauss-Newton step of the columns listed in `active`; the others move by `delta`.
bool SolveActive(const Eigen::MatrixXd& normal, const Eigen::VectorXd& gradient, const std::vector<int>& active,
                 BoundedStep* step) {
  const bool are_all = active.size() == static_cast<size_t>(normal.cols());
  const Eigen::MatrixXd some = are_all ? Eigen::MatrixXd() : Eigen::MatrixXd(normal(active, active));
  const Eigen::MatrixXd& reduced = are_all ? normal : some;
  // N_aa d_a = -(g + N_ap d_p): a active, p on their bounds. Solved in columns of unit norm, S^-1 N S^-1, so that
  // Cholesky loses digits to what depends on each other and not to units.
  const Eigen::VectorXd scale = reduced.diagonal().cwiseSqrt();
  if (!(scale.size() == 0 || scale.minCoeff() > 0.0)) return false;
  const Eigen::MatrixXd scaled = scale.cwiseInverse().asDiagonal() * reduced * scale.cwiseInverse().asDiagonal();
  // U'U = S^-1 N S^-1, hence N^-1 = W W' with W = S^-1 U^-1.
  const Eigen::MatrixXd inverse = InverseRoot(scaled);
  if (inverse.cols() != scaled.cols()) return false;
  Eigen::MatrixXd root = scale.cwiseInverse().asDiagonal() * inverse;
  if (are_all) {
    step->delta = -(root * (root.transpose() * gradient));
    step->root = std::move(root);
    return true;
  }
  Eigen::VectorXd pinned = step->delta;
  pinned(active).setZero();
  const Eigen::VectorXd right = -(gradient + normal * pinned)(active);
  step->delta(active) = root * (root.transpose() * right);
  step->root.setZero(normal.rows(), root.cols());
  step->root(active, Eigen::all) = root;
  return true;
}

constexpr double kReleases = 1e-9;  // of the gradient's own size: round-off does not release

// The pinned column whose cost falls most if it leaves its bound; -1: none does.
int WorstPinned(const Eigen::MatrixXd& normal, const Eigen::VectorXd& gradient, const BoundedStep& step) {
  // Karush, Kuhn and Tucker: at the minimum the cost rises from a lower bound into the interior, (g + N d)_c >= 0.
  // Divided by the norm of the column, so that metres and radians compare.
  const Eigen::VectorXd slope = gradient + normal * step.delta;
  int worst = -1;
  double gain = 0.0;
  for (const int c : step.pinned) {
    const double unit = std::sqrt(normal(c, c));
    const double own = -slope[c] / unit;
    if (own <= std::max(gain, kReleases * std::abs(gradient[c]) / unit)) continue;
    gain = own;
    worst = c;
  }
  return worst;
}

}  // namespace

BoundedStep SolveBounded(const Linearization& here, const ParameterSet& parameters, double damping) {
  const int n = here.num_columns();
  Eigen::MatrixXd normal = SelfProduct(here.jacobian);
  normal.diagonal() *= 1.0 + damping;
  const Eigen::VectorXd gradient = here.jacobian.transpose() * here.residual;
  BoundedStep step;
  step.delta.setZero(n);
  std::vector<int> active(n);
  for (int c = 0; c < n; ++c) active[c] = c;
  // Each release may cost a pinning again; more of them than columns would be a cycle.
  int releases = n;
  while (true) {
    if (!SolveActive(normal, gradient, active, &step)) return step;
    std::vector<int> inside;
    for (const int c : active) {
      const double lowest = parameters.coordinates()[here.columns[c]].lower - parameters.Value(here.columns[c]);
      const bool is_below = step.delta[c] < lowest;
      if (is_below) step.delta[c] = std::min(0.0, lowest);
      (is_below ? step.pinned : inside).push_back(c);
    }
    if (inside.size() == active.size()) {
      const int worst = releases-- > 0 ? WorstPinned(normal, gradient, step) : -1;
      if (worst < 0) break;
      step.pinned.erase(std::find(step.pinned.begin(), step.pinned.end(), worst));
      inside.push_back(worst);
    }
    active = inside;
  }
  // |d_c| / sigma_c, sigma_c^2 = (W W')_cc; on a bound sigma_c is that of the column alone, 1 / |J_c|.
  for (const int c : active) step.size = std::max(step.size, std::abs(step.delta[c]) / step.root.row(c).norm());
  for (const int c : step.pinned) step.size = std::max(step.size, std::abs(step.delta[c]) * std::sqrt(normal(c, c)));
  step.valid = std::isfinite(step.size);
  return step;
}

void Move(const std::vector<int>& columns, const Eigen::VectorXd& delta, double share, ParameterSet* parameters) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(parameters->num_coordinates());
  for (size_t c = 0; c < columns.size(); ++c) all[columns[c]] = share * delta[c];
  parameters->Plus(all);
}

Eigen::VectorXd TangentDifference(const ParameterSet& to, const ParameterSet& from) {
  Eigen::VectorXd difference(from.num_coordinates());
  for (size_t i = 0; i < from.blocks().size(); ++i) {
    const ParameterBlock& a = from.blocks()[i];
    const ParameterBlock& b = to.blocks()[i];
    if (IsRotation(a.kind)) {
      const Eigen::Map<const Eigen::Quaterniond> qa(a.values.data()), qb(b.values.data());
      difference.segment<3>(a.first_coordinate) = RotationVector(qb * qa.conjugate());
      continue;
    }
    for (int k = 0; k < a.tangent_size; ++k) difference[a.first_coordinate + k] = b.values[k] - a.values[k];
  }
  return difference;
}

}  // namespace sagitta
