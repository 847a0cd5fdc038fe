#include "estimator/agreement/agreement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <tuple>

#include "estimator/agreement/part_fits.h"
#include "estimator/agreement/shared_errors.h"
#include "estimator/agreement/splits.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/sandwich.h"
#include "estimator/noise/repeat_spread.h"
#include "estimator/report/agreement_words.h"
#include "estimator/statistics/distributions.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

// Every split of the measured robots next to the tree (UR5, UR10 A to D, and their halves) is below it.
constexpr double kPoorHalves = 4.0;
// Standard deviations of chance by which points of one shot err alike before that is sure, one in 700.
constexpr double kSurelyAlike = 3.0;
// By less an interval is not worth another method.
constexpr double kSameWidth = 0.05;

// Differences of what both parts know, by one covariance.
struct Differences : PartDifference {
  std::vector<double> over_interval;  // |value| over the 95 % half-width
  double p_value = 1.0;
  int freedom = 0;  // of the test's denominator; 0: not tested
};

// d' (C_a + C_b)^-1 d, solved in correlations because units differ: chi2_m where the noise is stated, F(m, nu) where it
// was estimated from the residuals, of both parts, or from repeats, once for both (repeat_spread.h).
double TestAtOnce(const Whole& whole, const PartFit& a, const PartFit& b, bool sandwich, const Differences& found) {
  const auto m = static_cast<double>(found.value.size());
  const Eigen::VectorXd scale = found.covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation =
      scale.cwiseInverse().asDiagonal() * found.covariance * scale.cwiseInverse().asDiagonal();
  const Eigen::LDLT<Eigen::MatrixXd> factor(correlation);
  const Eigen::VectorXd z = found.value.cwiseQuotient(scale);
  const double squares = z.dot(factor.solve(z));
  if (factor.info() != Eigen::Success || !factor.isPositive() || !std::isfinite(squares)) return 1.0;
  if (!sandwich && !whole.is_scaled) return ChanceOfSquares(whole.problem.repeat_scatter, squares, m);
  if (!sandwich) return FSurvival(squares / m, m, a.freedom + b.freedom);
  // Hotelling: clusters are the sample.
  const double n = a.sandwich.clusters + b.sandwich.clusters - static_cast<double>(a.columns.size() + b.columns.size());
  if (n - m + 1.0 < 1.0) return 1.0;
  return FSurvival(squares * (n - m + 1.0) / (n * m), m, n - m + 1.0);
}

Differences DifferencesOfParts(const Whole& whole, const PartFit& a, const PartFit& b, bool sandwich) {
  Differences found;
  std::vector<int> in_a, in_b;
  for (size_t i = 0; i < a.columns.size(); ++i) {
    const auto same = std::find(b.columns.begin(), b.columns.end(), a.columns[i]);
    if (same == b.columns.end()) continue;
    in_a.push_back(static_cast<int>(i));
    in_b.push_back(static_cast<int>(same - b.columns.begin()));
    found.columns.push_back(a.columns[i]);
  }
  if (in_a.empty()) return found;
  std::set_symmetric_difference(a.columns.begin(), a.columns.end(), b.columns.begin(), b.columns.end(),
                                std::back_inserter(found.one_sided));
  const Eigen::MatrixXd& ca = sandwich ? a.sandwich.covariance : a.model;
  const Eigen::MatrixXd& cb = sandwich ? b.sandwich.covariance : b.model;
  const Eigen::VectorXd& dof_a = sandwich ? a.sandwich.dof : a.model_dof;
  const Eigen::VectorXd& dof_b = sandwich ? b.sandwich.dof : b.model_dof;
  found.value = a.step()(in_a) - b.step()(in_b);
  found.covariance = ca(in_a, in_a) + cb(in_b, in_b);
  for (size_t i = 0; i < in_a.size(); ++i) {
    const int ia = in_a[i], ib = in_b[i];
    // Two spreads of residuals are independent; that of repeats is one and the same.
    const bool is_shared = !sandwich && whole.dof_by_repeats.size() > 0;
    const double dof =
        is_shared ? whole.dof_by_repeats[a.columns[ia]] : WelchDof(ca(ia, ia), dof_a[ia], cb(ib, ib), dof_b[ib]);
    const double t = StudentQuantile(kUpperOf95, dof);
    found.over_interval.push_back(std::abs(found.value[i]) / (t * std::sqrt(found.covariance(i, i))));
  }
  found.p_value = TestAtOnce(whole, a, b, sandwich, found);
  return found;
}

// Halves of n independent rows have C_a + C_b = 4 C of the whole. Where they know most parameters far worse than that,
// they turn the same misfit into far larger errors than the whole does, as they do with noise: then their squares are
// divided by the mean of (C_a + C_b) / 4 C over the parameters. whole: its variances by noise alone.
PartDifference AsOfTheWhole(const Eigen::VectorXd& whole, PartDifference found) {
  const Eigen::VectorXd ratios = found.covariance.diagonal().cwiseQuotient(4.0 * whole(found.columns));
  if (ratios.size() == 0 || Median({ratios.begin(), ratios.end()}) <= kPoorHalves) return found;
  const double share = 1.0 / ratios.mean();
  found.value *= std::sqrt(share);
  found.covariance *= share;
  return found;
}

// All that is compared of one kind.
struct Pool {
  std::vector<double> over_interval;
  double least_p = 1.0;
  int splits = 0;

  void Add(const Differences& found) {
    over_interval.insert(over_interval.end(), found.over_interval.begin(), found.over_interval.end());
    least_p = std::min(least_p, found.p_value);
    ++splits;
  }
  PartComparison Result(SplitBy by, const std::string& key) const {
    PartComparison result{by, key};
    std::vector<double> sorted = over_interval;
    std::sort(sorted.begin(), sorted.end());
    result.compared = static_cast<int>(sorted.size());
    result.inside = static_cast<int>(std::upper_bound(sorted.begin(), sorted.end(), 1.0) - sorted.begin());
    if (!sorted.empty()) result.inflation = sorted[static_cast<size_t>(0.95 * (sorted.size() - 1))];
    result.p_value = std::min(1.0, least_p * splits);
    return result;
  }
};

// The kinds whose parts contradict each other, at the significance of all kinds together (Bonferroni). Random halves
// share the model's error.
std::vector<PartComparison> Contradicting(const std::vector<PartComparison>& kinds, double significance) {
  const auto is_random = [](const PartComparison& kind) { return kind.by == SplitBy::kRandom; };
  const auto tested =
      static_cast<double>(kinds.size()) - static_cast<double>(std::count_if(kinds.begin(), kinds.end(), is_random));
  std::vector<PartComparison> found;
  std::copy_if(kinds.begin(), kinds.end(), std::back_inserter(found), [&](const PartComparison& kind) {
    return !is_random(kind) && kind.p_value * tested < significance && kind.inflation > 1.0;
  });
  return found;
}

// Of the kinds whose parts contradict each other.
BetweenParts ModelErrorOf(const std::vector<PartComparison>& kinds, const std::map<SplitBy, PartMoments>& moments,
                          const Whole& whole) {
  BetweenParts found;
  PartMoments all(whole.num_columns());
  for (const PartComparison& kind : Contradicting(kinds, whole.problem.experiment().significance)) {
    all.Add(moments.at(kind.by));
    TakeLarger(moments.at(kind.by).Result(whole.turns), &found);
  }
  if (!found.known()) return found;
  found.covariance = all.Result(whole.turns).covariance;
  found.reason = PartsContradict();
  return found;
}

// Returns the sandwich of the whole.
RobustCovariance CompareSplits(const std::vector<Split>& splits, Whole* given, AlsoSummed* also,
                               AgreementReport* report, BetweenParts* between) {
  std::map<SplitBy, Pool> kinds;
  std::map<SplitBy, PartMoments> moments;
  Pool random[2];  // by the model's covariance, by the sandwich
  const SumsOfParts sums = SumParts(splits, given, also);
  if (!given->valid) return {};
  const Whole& whole = *given;
  std::vector<std::array<PartFit, 2>> fits;
  std::vector<int> with_sandwich;
  for (size_t s = 0; s < splits.size(); ++s) {
    fits.push_back(FitParts(whole, splits[s], sums.empty() ? nullptr : &sums[s]));
    if (splits[s].by == SplitBy::kRandom || whole.by_sandwich) with_sandwich.push_back(static_cast<int>(s));
  }
  const Eigen::VectorXd variances = whole.turns.VariancesOf(whole.estimate.covariance);
  const RobustCovariance robust = AddSandwiches(whole, splits, with_sandwich, &fits);
  for (size_t s = 0; s < splits.size(); ++s) {
    const Split& split = splits[s];
    const bool is_random = split.by == SplitBy::kRandom;
    const auto& [first, second] = fits[s];
    if (!first.usable || !second.usable) continue;
    const Differences found = DifferencesOfParts(whole, first, second, whole.by_sandwich);
    if (is_random) {
      random[whole.by_sandwich].Add(found);
      random[!whole.by_sandwich].Add(DifferencesOfParts(whole, first, second, !whole.by_sandwich));
    }
    if (found.over_interval.empty()) continue;
    kinds[split.by].Add(found);
    if (is_random) continue;
    moments.try_emplace(split.by, whole.num_columns()).first->second.Add(AsOfTheWhole(variances, found));
    Pool own;
    own.Add(found);
    report->splits.push_back(own.Result(split.by, split.key));
  }
  for (const SplitBy by :
       {SplitBy::kRandom, SplitBy::kRegion, SplitBy::kStation, SplitBy::kTime, SplitBy::kMarker, SplitBy::kLoad}) {
    if (kinds.count(by) > 0) report->kinds.push_back(kinds[by].Result(by, ""));
  }
  *between = ModelErrorOf(report->kinds, moments, whole);
  report->random_share_model = random[false].Result(SplitBy::kRandom, "").share();
  report->random_share_sandwich = random[true].Result(SplitBy::kRandom, "").share();
  return robust;
}

// With one value per group of repeated shots that no model can explain apart:
//   F = [(r'r - within) / (3 groups - unknowns)] / [within / (3 rows - 3 groups)]
RepeatFit TestRepeats(const Whole& whole) {
  const Measurements& data = whole.problem.data();
  const auto key = [&](int i) {
    const Observation& row = data.observations[i];
    const Shot& shot = data.shots[row.shot];
    return std::tie(shot.configuration, row.marker, shot.station, row.kind, shot.visit, shot.load);
  };
  std::vector<int> order = whole.observations;
  const auto is_before = [&](int a, int b) { return key(a) < key(b); };
  if (!std::is_sorted(order.begin(), order.end(), is_before)) std::stable_sort(order.begin(), order.end(), is_before);
  RepeatFit fit;
  double within = 0.0;
  int groups = 0;
  for (size_t first = 0, last = 0; first < order.size(); first = last, ++groups) {
    Matrix3<double> weights = Matrix3<double>::Zero();
    Vector3<double> sum = Vector3<double>::Zero();
    double squares = 0.0;
    while (last < order.size() && key(order[last]) == key(order[first])) ++last;
    if (last - first == 1) continue;  // it is its own mean
    for (size_t i = first; i < last; ++i) {
      const Matrix3<double> noise = ObservationNoise(whole.problem, {order[i]}, kFallbackSigma)[0];
      const Matrix3<double> weight = (noise * noise.transpose()).inverse();
      const Vector3<double> error =
          MeasuredMinusPredicted(data.observations[order[i]].reading(), whole.estimate.predicted.col(order[i]));
      weights += weight;
      sum += weight * error;
      squares += error.dot(weight * error);
    }
    // sum e'We - (sum We)' (sum W)^-1 (sum We): scatter of repeats about their weighted mean.
    within += squares - sum.dot(weights.inverse() * sum);
  }
  const int rows = whole.num_rows(), means = 3 * groups;
  fit.within_dof = rows - means;
  fit.between_dof = means - whole.num_columns();
  fit.known = fit.within_dof > 0 && fit.between_dof > 0 && within > 0.0;
  if (!fit.known) return fit;
  const double between = std::max(0.0, whole.squared_residual - within);
  fit.ratio = (between / fit.between_dof) / (within / fit.within_dof);
  fit.p_value = FSurvival(fit.ratio, fit.between_dof, fit.within_dof);
  return fit;
}

bool SandwichIsLarger(const Whole& whole, const RobustCovariance& robust, double* ratio) {
  if (robust.covariance.rows() == 0) return false;
  *ratio = RatioToModel(whole, robust);
  return robust.dof.size() > 0 && IsLarger(*ratio, Median({robust.dof.begin(), robust.dof.end()}));
}

}  // namespace

BetweenParts CheckAgreement(const CalibrationProblem& problem, const AgreementOptions& options, Estimate* estimate,
                            const FittedStream* fitted, AlsoSummed* also) {
  Whole whole(problem, *estimate, fitted);
  AgreementReport& report = estimate->agreement;
  report = AgreementReport();
  report.covariance = whole.by_sandwich ? CovarianceKind::kSandwich : CovarianceKind::kModel;
  report.seed = options.seed;
  if (!whole.valid || whole.num_columns() == 0) return {};
  const std::vector<Split> splits = MakeSplits(problem, *estimate, whole.clusters, options.seed, options.random_halves);
  BetweenParts between;
  const RobustCovariance robust = CompareSplits(splits, &whole, also, &report, &between);
  report.repeats = TestRepeats(whole);
  const bool larger = SandwichIsLarger(whole, robust, &report.sandwich_ratio);
  report.known = !report.kinds.empty();
  const double level = problem.experiment().significance;
  for (const PartComparison& kind : Contradicting(report.kinds, level)) {
    report.disagrees = true;
    report.inflation = std::max(report.inflation, kind.inflation);
  }
  const bool repeats_lie = report.repeats.known && report.repeats.p_value < level;
  report.shared_errors = SharedErrors(problem, whole);
  const bool err_alike = std::exp(LogNormalCdf(-report.shared_errors)) < level;
  // What hardly shows and changes no width is nothing to act upon.
  const bool is_idle =
      report.shared_errors < kSurelyAlike && std::abs(report.sandwich_ratio - 1.0) < kSameWidth && !report.disagrees;
  report.sandwich_advised = !whole.by_sandwich && (larger || repeats_lie || (err_alike && !is_idle));
  DescribeAgreement(problem, &report);
  return between;
}

}  // namespace sagitta
