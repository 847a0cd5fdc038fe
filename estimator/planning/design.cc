#include "estimator/planning/design.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include "estimator/least_squares/parallel.h"
#include "models/constants.h"
#include "models/matrix_functions.h"
#include "models/random_bits.h"
#include "problems/interruption.h"
#include "problems/range.h"

namespace sagitta {
namespace {

// These two, and the counts and shares of the functions below, are choices of how long the search needs: how far it
// came says the certificate.
constexpr int kFewCandidates = 600;  // that many are all worked on at once
constexpr int kJoining = 100;        // of more, so many join at a time

bool IsLogarithm(const Criterion& criterion) {
  return criterion.kind == CriterionKind::kD || criterion.kind == CriterionKind::kO1;
}

// Two halves at once where that is worth a thread. The halves are the same on every machine, and so is their sum.
bool IsWorthThreads(const CandidateSet& set) {
  constexpr double kWork = 1e7;  // multiplications: some milliseconds
  return static_cast<double>(set.rows.size()) * static_cast<double>(set.rows.cols()) > kWork;
}

void InHalves(const CandidateSet& set, const std::function<void(int, int)>& work) {
  const int half = set.size() / 2, ends[] = {0, half, set.size()};
  ParallelFor(2, IsWorthThreads(set) ? 2 : 1, [&](int i, int) { work(ends[i], ends[i + 1]); });
}

Eigen::MatrixXd InformationOf(const CandidateSet& set, const Eigen::MatrixXd& known, const Eigen::VectorXd& amounts) {
  const int half = set.size() / 2;
  const Eigen::Index n = known.rows();
  Eigen::MatrixXd sums[2] = {Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n)};
  InHalves(set, [&](int from, int to) {
    constexpr int kAtOnce = 64;  // candidates: what fits a cache
    Eigen::MatrixXd& sum = sums[from < half || half == 0 ? 0 : 1];
    Eigen::MatrixXd weighted;
    for (int i = from; i < to; i += kAtOnce) {
      const int end = std::min(to, i + kAtOnce);
      // M = known + sum_i n_i A_i'A_i, by products of many candidates at a time.
      weighted = set.rows.middleRows(set.first[i], set.first[end] - set.first[i]).transpose();
      for (int k = i; k < end; ++k) {
        weighted.middleCols(set.first[k] - set.first[i], set.count(k)) *= std::sqrt(amounts[k]);
      }
      sum.selfadjointView<Eigen::Lower>().rankUpdate(weighted);
    }
  });
  const Eigen::MatrixXd information = known + sums[0] + sums[1];
  return information.selfadjointView<Eigen::Lower>();
}

void AddGains(const CandidateSet& set, const Eigen::MatrixXd& slope, int from, int to, Eigen::VectorXd* gains) {
  constexpr int kAtOnce = 64;  // candidates: what fits a cache
  for (int i = from; i < to; i += kAtOnce) {
    const int end = std::min(to, i + kAtOnce);
    const auto rows = set.rows.middleRows(set.first[i], set.first[end] - set.first[i]);
    // d_i = tr(A_i slope A_i'): by how much the cost falls per pose spent on candidate i.
    const Eigen::MatrixXd sloped = rows * slope;
    const Eigen::VectorXd of_rows = sloped.cwiseProduct(rows).rowwise().sum();
    for (int k = i; k < end; ++k) {
      (*gains)[k] = std::max(0.0, of_rows.segment(set.first[k] - set.first[i], set.count(k)).sum());
    }
  }
}

// What the gap of a certificate is measured against: a logarithm's own scale is its number of parameters.
double ScaleOf(const Criterion& criterion, double cost) {
  return IsLogarithm(criterion) ? static_cast<double>(criterion.interest.size()) : std::abs(cost);
}

// The multiplicative algorithm on all of a set. Returns its last iteration.
class Multiplicative {
 public:
  Multiplicative(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion, double poses)
      : set_(set),
        known_(known),
        criterion_(criterion),
        poses_(poses),
        least_power_(IsLogarithm(criterion) ? 1.0 : 0.5) {}

  // design->weights is where it starts. True: no candidate of the set gains enough to go on.
  bool Run(double tolerance, int max_iterations, ApproximateDesign* design) const {
    double power = least_power_, before = kInfinity;
    Eigen::VectorXd last;
    for (int k = 0; k < max_iterations; ++k, ++design->iterations) {
      CheckInterruption();
      Evaluate(design);
      const double mean = design->weights.dot(design->gain);
      // The cost is convex in the weights: no design of as many poses costs less than cost - poses (max d - mean d)
      // (Kiefer and Wolfowitz 1960).
      const double gap = poses_ * (design->gain.maxCoeff() - mean);
      if (gap <= tolerance * ScaleOf(criterion_, design->cost) || !(mean > 0.0)) return true;
      if (design->cost > before && power > least_power_) {  // too far
        design->weights = last;
        Evaluate(design);
        power = std::max(least_power_, 0.6 * power);
      } else {
        power = std::min(1.1 * power, 3.0 * least_power_);
      }
      before = design->cost;
      last = design->weights;
      // w_i <- w_i (d_i / mean d)^power.
      design->weights = last.cwiseProduct((design->gain / last.dot(design->gain)).array().pow(power).matrix());
      design->weights /= design->weights.sum();
    }
    Evaluate(design);
    return false;
  }

 private:
  void Evaluate(ApproximateDesign* design) const {
    const Eigen::MatrixXd covariance = InverseOfPositive(InformationOf(set_, known_, poses_ * design->weights));
    design->cost = criterion_.Cost(covariance);
    design->slope = criterion_.Slope(covariance);
    design->gain = GainsOf(set_, design->slope);
  }

  const CandidateSet& set_;
  const Eigen::MatrixXd& known_;
  const Criterion& criterion_;
  const double poses_, least_power_;  // Silvey, Titterington and Torsney: 1 for D, 1/2 for A
};

// The candidates to begin with: those that weigh something, or some of all.
std::vector<int> FirstActive(const CandidateSet& set, const Eigen::VectorXd& weights, bool is_started) {
  std::vector<int> active;
  const int stride = std::max(1, set.size() / kFewCandidates);
  for (int i = 0; i < set.size(); ++i) {
    if ((is_started && weights[i] > 1e-7) || (!is_started && i % stride == 0)) active.push_back(i);
  }
  return active;
}

// Solves on the active candidates alone; those that fade away leave. Then gains are those of all.
void SolveOnActive(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion, double poses,
                   double tolerance, int max_iterations, std::vector<int>* active, ApproximateDesign* design) {
  constexpr int kBetween = 25;    // iterations before some may leave
  constexpr double kFaded = 0.1;  // of an even share
  for (bool is_solved = false; !is_solved;) {
    const CandidateSet subset = set.Subset(*active);
    ApproximateDesign inner;
    inner.weights = design->weights(*active) / design->weights(*active).sum();
    const int left = max_iterations - design->iterations;
    is_solved = Multiplicative(subset, known, criterion, poses).Run(tolerance, std::min(kBetween, left), &inner) ||
                left <= kBetween;
    design->iterations += inner.iterations;
    design->cost = inner.cost;
    design->slope = inner.slope;
    design->weights.setZero();
    design->weights(*active) = inner.weights;
    if (is_solved) break;
    // Near the end even a small weight is what the candidate is worth.
    const double mean = inner.weights.dot(inner.gain);
    const double gap = poses * (inner.gain.maxCoeff() - mean) / ScaleOf(criterion, inner.cost);
    const double faded = kFaded * std::min(1.0, gap) / static_cast<double>(active->size());
    std::vector<int> staying;
    for (size_t k = 0; k < active->size(); ++k) {
      if (inner.weights[k] > faded || inner.gain[k] > mean) staying.push_back((*active)[k]);
    }
    *active = staying;
  }
  design->gain = GainsOf(set, design->slope);
}

// The candidate that makes the cost least given covariance c; its cost in *cost. The cost is convex in the
// information, so that no candidate saves more than its gain d_i: those of small gain need no look.
class Adder {
 public:
  Adder(const CandidateSet& set, const Criterion& criterion, std::vector<int> trials)
      : criterion_(criterion), trials_(std::move(trials)), set_(set.Subset(trials_)) {}

  int Best(const Eigen::MatrixXd& c, const std::vector<bool>& barred, double* cost) const {
    const CostGiven given(criterion_, c);
    const bool is_convex = criterion_.HasCertificate();
    const double now = is_convex ? criterion_.Cost(c) : 0.0;
    const Eigen::VectorXd gains =
        is_convex ? GainsOf(set_, criterion_.Slope(c)) : Eigen::VectorXd::Constant(set_.size(), kInfinity);
    int best = -1;
    *cost = kInfinity;
    for (const int k : Foremost(gains, set_.size())) {
      if (now - gains[k] >= *cost) break;
      if (barred[trials_[k]]) continue;
      const double trial = given.With(set_.of(k));
      if (trial < *cost) {
        *cost = trial;
        best = trials_[k];
      }
    }
    return best;
  }

 private:
  const Criterion& criterion_;
  const std::vector<int> trials_;
  const CandidateSet set_;
};

// One pose at a time, together with a little of the approximate design so that the first ones have a cost.
std::vector<int> Greedy(const CandidateSet& set, const Eigen::MatrixXd& known, const Adder& adder, int poses,
                        const ApproximateDesign& approximate, bool repeats) {
  constexpr double kShare = 0.1;  // of one pose: fades against the poses chosen
  Eigen::MatrixXd c = InverseOfPositive(InformationOf(set, known, kShare * approximate.weights));
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
    double point = UnitNumber((*random)()) * left.sum();
    int i = 0;
    while (i + 1 < left.size() && (point -= left[i]) > 0.0) ++i;
    picks.push_back(i);
    if (!repeats) left[i] = 0.0;
  }
  return picks;
}

// Each pose in turn is removed and the best one put in, until a round changes nothing.
ExactDesign Exchanged(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion,
                      const Adder& adder, std::vector<int> picks, bool repeats, int rounds) {
  constexpr double kWorth = 1e-6;  // of the cost's scale: below is rounding
  ExactDesign design{std::move(picks), {}, 0.0};
  std::vector<bool> barred(set.size(), false);
  for (const int i : design.picks) barred[i] = !repeats;
  for (int round = 0; round < rounds; ++round) {
    design.covariance = CovarianceOf(set, known, design.picks);
    design.cost = criterion.Cost(design.covariance);
    bool changed = false;
    for (int& pick : design.picks) {
      CheckInterruption();
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

}  // namespace

CandidateSet CandidateSet::Subset(const std::vector<int>& candidates) const {
  CandidateSet subset;
  subset.first = {0};
  for (const int i : candidates) subset.first.push_back(subset.first.back() + count(i));
  subset.rows.resize(subset.first.back(), rows.cols());
  for (size_t k = 0; k < candidates.size(); ++k)
    subset.rows.middleRows(subset.first[k], count(candidates[k])) = of(candidates[k]);
  return subset;
}

void CandidateSet::Append(const std::vector<Eigen::MatrixXd>& candidates) {
  int more = 0;
  for (const Eigen::MatrixXd& own : candidates) more += static_cast<int>(own.rows());
  int next = static_cast<int>(rows.rows());
  rows.conservativeResize(next + more, Eigen::NoChange);
  for (const Eigen::MatrixXd& own : candidates) {
    rows.middleRows(next, own.rows()) = own;
    next += static_cast<int>(own.rows());
    first.push_back(next);
  }
}

Eigen::VectorXd GainsOf(const CandidateSet& set, const Eigen::MatrixXd& slope) {
  Eigen::VectorXd gains(set.size());
  InHalves(set, [&](int from, int to) { AddGains(set, slope, from, to, &gains); });
  return gains;
}

Eigen::MatrixXd CovarianceOf(const CandidateSet& set, const Eigen::MatrixXd& known, const std::vector<int>& picks) {
  Eigen::MatrixXd information = known;
  for (const int i : picks) information += set.of(i).transpose() * set.of(i);
  return InverseOfPositive(information);
}

// C -/+ C A' (I +/- A C A')^-1 A C.
Eigen::MatrixXd Updated(const Eigen::MatrixXd& c, const Eigen::MatrixXd& a, double sign) {
  const Eigen::MatrixXd ac = a * c;
  const Eigen::MatrixXd aca = ac * a.transpose();
  const Eigen::MatrixXd k = Eigen::MatrixXd::Identity(a.rows(), a.rows()) + sign * aca;
  const Eigen::MatrixXd solved = k.ldlt().solve(ac), change = ac.transpose() * solved;
  return c - 0.5 * sign * (change + change.transpose());
}

CostGiven::CostGiven(const Criterion& criterion, const Eigen::MatrixXd& covariance)
    : criterion_(criterion), c_(covariance), columns_(criterion.Columns(static_cast<int>(covariance.rows()))) {
  block_ = c_(columns_, columns_);
  const bool is_known =
      IsLogarithm(criterion) || criterion.kind == CriterionKind::kA || criterion.kind == CriterionKind::kI;
  if (is_known) now_ = criterion.CostOfBlock(block_);
  if (criterion.kind == CriterionKind::kI) middle_ = c_ * criterion.weight * c_;
  const Eigen::MatrixXd tall = c_(Eigen::all, columns_);
  if (criterion.kind == CriterionKind::kA) middle_ = tall * tall.transpose();
  if (IsLogarithm(criterion)) {
    const Eigen::MatrixXd across = tall.transpose(), known = block_.llt().solve(across);
    middle_ = c_ - tall * known;
  }
}

// With K = I + A C A': of I and A the loss tr(K^-1 A middle A'). Of D ln det C'_SS = ln det C_SS - ln det K
// + ln det(I + A middle A'), the last of what would be left unknown if S were known.
double CostGiven::With(const Eigen::MatrixXd& rows) const {
  const Eigen::MatrixXd ac = rows * c_;
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(rows.rows(), rows.rows());
  const Eigen::MatrixXd aca = ac * rows.transpose();
  const Eigen::LLT<Eigen::MatrixXd> root(Eigen::MatrixXd(one + aca));
  if (middle_.size() == 0) {
    Eigen::MatrixXd part = ac(Eigen::all, columns_);
    root.matrixL().solveInPlace(part);
    return criterion_.CostOfBlock(block_ - part.transpose() * part);
  }
  const Eigen::MatrixXd half = rows * middle_, inner = half * rows.transpose();
  if (!IsLogarithm(criterion_)) return now_ - root.solve(inner).trace();
  return now_ - LogDeterminant(root) + LogDeterminant((one + inner).eval().llt());
}

std::vector<int> Foremost(const Eigen::VectorXd& values, int most) {
  std::vector<int> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  const auto before = [&](int a, int b) { return values[a] > values[b] || (values[a] == values[b] && a < b); };
  if (static_cast<int>(order.size()) <= most) {
    std::sort(order.begin(), order.end(), before);
  } else {
    std::partial_sort(order.begin(), order.begin() + most, order.end(), before);
    order.resize(most);
  }
  return order;
}

ApproximateDesign SolveApproximate(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion,
                                   double poses, double tolerance, int max_iterations, const Eigen::VectorXd* start) {
  constexpr int kJoins = 60;  // a guard: the certificate ends them
  // Without a slope of its own a criterion searches among what D favours.
  Criterion guide = criterion;
  if (!criterion.HasCertificate()) guide.kind = CriterionKind::kD;
  ApproximateDesign design;
  design.weights = start != nullptr ? *start : Eigen::VectorXd::Constant(set.size(), 1.0 / set.size());
  design.bound = -kInfinity;
  std::vector<int> active = FirstActive(set, design.weights, start != nullptr);
  for (int join = 0; join < kJoins; ++join) {
    SolveOnActive(set, known, guide, poses, 0.5 * tolerance, max_iterations, &active, &design);
    const double mean = design.weights.dot(design.gain);
    const double gap = poses * (design.gain.maxCoeff() - mean), scale = ScaleOf(guide, design.cost);
    design.bound = std::max(design.bound, design.cost - gap);
    const bool is_near = design.cost - design.bound <= tolerance * scale;
    if (is_near || !(mean > 0.0) || design.iterations >= max_iterations) break;
    // Those that gain most join, with the less weight the nearer the end is.
    const double share = std::clamp(gap / scale, 1e-4, 0.2);
    std::vector<int> joining;
    for (const int i : Foremost(design.gain, kJoining)) {
      if (design.gain[i] > mean && design.weights[i] < 0.1 * share / kJoining) joining.push_back(i);
    }
    design.weights *= 1.0 - share;
    if (joining.empty()) design.weights /= design.weights.sum();
    for (const int i : joining) design.weights[i] += share / static_cast<double>(joining.size());
    active.clear();
    for (int i = 0; i < set.size(); ++i) {
      if (design.weights[i] > 0.0) active.push_back(i);
    }
  }
  return design;
}

void CheckOptions(const ExactOptions& options) {
  CheckIn(allowed::kStarts, options.starts, "ExactOptions.starts");
  CheckIn(allowed::kIterations, options.rounds, "ExactOptions.rounds");
  CheckIn(allowed::kPool, options.max_trials, "ExactOptions.max_trials");
}

ExactDesign SolveExact(const CandidateSet& set, const Eigen::MatrixXd& known, const Criterion& criterion, int poses,
                       const ApproximateDesign& approximate, const ExactOptions& options) {
  CheckOptions(options);
  const Adder adder(set, criterion, Foremost(approximate.gain, std::max(options.max_trials, poses)));
  std::mt19937_64 random(options.seed);
  ExactDesign best;
  for (int start = 0; start < options.starts; ++start) {
    const std::vector<int> picks = start == 0 ? Greedy(set, known, adder, poses, approximate, options.repeats)
                                              : Drawn(approximate.weights, poses, options.repeats, &random);
    const ExactDesign found = Exchanged(set, known, criterion, adder, picks, options.repeats, options.rounds);
    if (start == 0 || found.cost < best.cost) best = found;
  }
  return best;
}

}  // namespace sagitta
