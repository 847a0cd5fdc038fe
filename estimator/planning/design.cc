#include "estimator/planning/design.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace sagitta {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& information) {
  return information.llt().solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()));
}

Eigen::MatrixXd InformationOf(const CandidateSet& set, const Eigen::MatrixXd& known, const Eigen::VectorXd& amounts) {
  Eigen::VectorXd per_row(set.rows.rows());
  for (int i = 0; i < set.size(); ++i) per_row.segment(set.first[i], set.count(i)).setConstant(amounts[i]);
  const Eigen::MatrixXd weighted = per_row.cwiseSqrt().asDiagonal() * set.rows;
  Eigen::MatrixXd information = known;
  information.selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
  return information.selfadjointView<Eigen::Lower>();
}

// d_i = tr(A_i G A_i').
Eigen::VectorXd GainsOf(const CandidateSet& set, const Eigen::MatrixXd& slope) {
  const Eigen::VectorXd of_rows = (set.rows * slope).cwiseProduct(set.rows).rowwise().sum();
  Eigen::VectorXd gains(set.size());
  for (int i = 0; i < set.size(); ++i) gains[i] = of_rows.segment(set.first[i], set.count(i)).sum();
  return gains.cwiseMax(0.0);
}

// What the gap of a certificate is measured against: a logarithm's own scale is its number of parameters.
double ScaleOf(const Criterion& criterion, double cost) {
  const bool is_logarithm = criterion.kind == CriterionKind::kD || criterion.kind == CriterionKind::kO1;
  return is_logarithm ? static_cast<double>(criterion.interest.size()) : std::abs(cost);
}

// C after A' A is added (sign 1) or taken away (-1): C -/+ C A' (I +/- A C A')^-1 A C.
Eigen::MatrixXd Updated(const Eigen::MatrixXd& c, const Eigen::MatrixXd& a, double sign) {
  const Eigen::MatrixXd ac = a * c;
  const Eigen::MatrixXd k = Eigen::MatrixXd::Identity(a.rows(), a.rows()) + sign * (ac * a.transpose());
  const Eigen::MatrixXd updated = c - sign * (ac.transpose() * k.ldlt().solve(ac));
  return 0.5 * (updated + updated.transpose());
}

// The candidate that makes the cost least beside covariance c; its cost in *cost.
class Adder {
 public:
  Adder(const CandidateSet& set, const Criterion& criterion, std::vector<int> trials)
      : set_(set), criterion_(criterion), trials_(std::move(trials)), columns_(criterion.Columns(set.rows.cols())) {}

  int Best(const Eigen::MatrixXd& c, const std::vector<bool>& barred, double* cost) const {
    const Eigen::MatrixXd block = c(columns_, columns_);
    const double now = criterion_.kind == CriterionKind::kI ? criterion_.CostOfBlock(block) : 0.0;
    int best = -1;
    *cost = kInfinity;
    for (const int i : trials_) {
      if (barred[i]) continue;
      const double trial = CostWith(c, block, now, i);
      if (trial < *cost) {
        *cost = trial;
        best = i;
      }
    }
    return best;
  }

 private:
  double CostWith(const Eigen::MatrixXd& c, const Eigen::MatrixXd& block, double now, int i) const {
    const auto a = set_.of(i);
    const Eigen::MatrixXd ac = a * c;
    const Eigen::MatrixXd k = Eigen::MatrixXd::Identity(a.rows(), a.rows()) + ac * a.transpose();
    const Eigen::LLT<Eigen::MatrixXd> root(k);
    if (criterion_.kind == CriterionKind::kI) {
      return now - root.solve(ac * criterion_.weight * ac.transpose()).trace();
    }
    const Eigen::MatrixXd part = root.matrixL().solve(Eigen::MatrixXd(ac(Eigen::all, columns_)));
    return criterion_.CostOfBlock(block - part.transpose() * part);
  }

  const CandidateSet& set_;
  const Criterion& criterion_;
  std::vector<int> trials_;
  std::vector<int> columns_;
};

// One pose at a time, beside a little of the approximate design so that the first ones have a cost.
std::vector<int> Greedy(const CandidateSet& set, const Eigen::MatrixXd& known, const Adder& adder, int poses,
                        const ApproximateDesign& approximate, bool repeats) {
  constexpr double kShare = 0.1;  // of one pose: fades against the poses taken
  Eigen::MatrixXd c = InverseOf(InformationOf(set, known, kShare * approximate.weights));
  std::vector<bool> barred(set.size(), false);
  std::vector<int> picks;
  for (int k = 0; k < poses; ++k) {
    double cost = 0.0;
    const int next = adder.Best(c, barred, &cost);
    if (next < 0) break;
    picks.push_back(next);
    barred[next] = !repeats;
    c = Updated(c, set.of(next), 1.0);
  }
  return picks;
}

// Draws from the approximate design, the same on every machine.
std::vector<int> Drawn(const Eigen::VectorXd& weights, int poses, bool repeats, std::mt19937_64* random) {
  Eigen::VectorXd left = weights.array() + 1e-9 / static_cast<double>(weights.size());
  std::vector<int> picks;
  for (int k = 0; k < poses; ++k) {
    double point = static_cast<double>((*random)() >> 11) * 0x1.0p-53 * left.sum();
    int i = 0;
    while (i + 1 < left.size() && (point -= left[i]) > 0.0) ++i;
    picks.push_back(i);
    if (!repeats) left[i] = 0.0;
  }
  return picks;
}

// Each pose in turn is taken out and the best one put in, until a round changes nothing.
ExactDesign Exchanged(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion,
                      const Adder& adder, std::vector<int> picks, bool repeats) {
  constexpr int kRounds = 20;
  constexpr double kWorth = 1e-6;  // of the cost's scale: below is rounding
  ExactDesign design{std::move(picks), {}, 0.0};
  std::vector<bool> barred(set.size(), false);
  for (const int i : design.picks) barred[i] = !repeats;
  for (int round = 0; round < kRounds; ++round) {
    design.covariance = CovarianceOf(set, known, design.picks);
    design.cost = criterion.Cost(design.covariance);
    bool changed = false;
    for (int& pick : design.picks) {
      const Eigen::MatrixXd without = Updated(design.covariance, set.of(pick), -1.0);
      double cost = 0.0;
      const int next = adder.Best(without, barred, &cost);
      if (next < 0 || next == pick || !(cost < design.cost - kWorth * ScaleOf(criterion, design.cost))) continue;
      barred[pick] = false;
      barred[next] = !repeats;
      pick = next;
      design.covariance = Updated(without, set.of(next), 1.0);
      design.cost = cost;
      changed = true;
    }
    if (!changed) break;
  }
  std::sort(design.picks.begin(), design.picks.end());
  design.covariance = CovarianceOf(set, known, design.picks);
  design.cost = criterion.Cost(design.covariance);
  return design;
}

// Those of the largest gains.
std::vector<int> Foremost(const Eigen::VectorXd& gains, int most) {
  std::vector<int> order(gains.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return gains[a] > gains[b]; });
  if (static_cast<int>(order.size()) > most) order.resize(most);
  return order;
}

}  // namespace

Eigen::MatrixXd CovarianceOf(const CandidateSet& set, const Eigen::MatrixXd& known, const std::vector<int>& picks) {
  Eigen::MatrixXd information = known;
  for (const int i : picks) information += set.of(i).transpose() * set.of(i);
  return InverseOf(information);
}

ApproximateDesign SolveApproximate(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion,
                                   double poses, double tolerance, int max_iterations) {
  const bool is_logarithm = criterion.kind == CriterionKind::kD || criterion.kind == CriterionKind::kO1;
  const double power = is_logarithm ? 1.0 : 0.5;  // Silvey, Titterington and Torsney: 1 for D, 1/2 for A
  ApproximateDesign design;
  design.weights.setConstant(set.size(), 1.0 / set.size());
  design.bound = -kInfinity;
  // Without a slope of its own a criterion searches among what D favours.
  Criterion guide = criterion;
  if (!criterion.HasCertificate()) guide.kind = CriterionKind::kD;
  for (design.iterations = 0; design.iterations < max_iterations; ++design.iterations) {
    const Eigen::MatrixXd covariance = InverseOf(InformationOf(set, known, poses * design.weights));
    design.cost = guide.Cost(covariance);
    design.gain = GainsOf(set, guide.Slope(covariance));
    const double mean = design.weights.dot(design.gain);
    const double gap = poses * (design.gain.maxCoeff() - mean);
    design.bound = std::max(design.bound, design.cost - gap);
    if (design.cost - design.bound <= tolerance * ScaleOf(guide, design.cost) || !(mean > 0.0)) break;
    design.weights = design.weights.cwiseProduct((design.gain / mean).array().pow(power).matrix());
    design.weights /= design.weights.sum();
  }
  return design;
}

ExactDesign SolveExact(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion, int poses,
                       const ApproximateDesign& approximate, const ExactOptions& options) {
  const Adder adder(set, criterion, Foremost(approximate.gain, std::max(options.max_trials, poses)));
  std::mt19937_64 random(options.seed);
  ExactDesign best;
  for (int start = 0; start < options.starts; ++start) {
    const std::vector<int> picks = start == 0 ? Greedy(set, known, adder, poses, approximate, options.repeats)
                                              : Drawn(approximate.weights, poses, options.repeats, &random);
    const ExactDesign found = Exchanged(set, known, criterion, adder, picks, options.repeats);
    if (start == 0 || found.cost < best.cost) best = found;
  }
  return best;
}

}  // namespace sagitta
