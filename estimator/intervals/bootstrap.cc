#include "estimator/intervals/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <random>

#include "estimator/calibration/bounds.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/intervals/redraw.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/normal_equations.h"
#include "estimator/least_squares/parallel.h"
#include "estimator/least_squares/refit.h"
#include "estimator/least_squares/row_stream.h"
#include "estimator/least_squares/sandwich.h"
#include "estimator/report/intervals_words.h"
#include "estimator/statistics/distributions.h"
#include "models/quantiles.h"
#include "problems/input_error.h"
#include "problems/range.h"

namespace sagitta {
namespace {

constexpr double kEnough = 2.0;  // configurations per unknown: two thirds of them are in a draw

struct Replicate {
  bool used = false;
  Eigen::VectorXd shift;  // theta* - theta_hat, SI, per estimated coordinate
  Eigen::VectorXd sigma;
  std::vector<bool> on_bound;  // of each estimated coordinate: the refit ended at its physical bound
};

struct Setup {
  const CalibrationProblem& problem;
  const Estimate& estimate;
  bool by_configurations = false;
  bool is_scaled = false;     // sigma from the residuals
  std::vector<int> clusters;  // of each calibration observation
  int num_clusters = 0;
};

// J'r of each configuration, one row each, as the rows count: where they are too many to be kept, piece by piece.
Eigen::MatrixXd ScoresOf(const Setup& setup, const Refit& refit, const std::vector<double>& weights) {
  const Linearization& fit = refit.linearization;
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(setup.num_clusters, fit.num_columns());
  if (!fit.observations.empty()) {
    for (size_t k = 0; k < setup.clusters.size(); ++k) {
      const int row = static_cast<int>(3 * k);
      scores.row(setup.clusters[k]) += fit.residual.segment<3>(row).transpose() * fit.jacobian.middleRows(row, 3);
    }
    return scores;
  }
  const auto noise = [&](const std::vector<int>& listed) { return FitRoots(setup.problem, listed, kFallbackSigma); };
  const RowStream stream(setup.problem, setup.problem.CalibrationObservations(), noise, LatentTreatment::kMarginalise);
  const Eigen::Index n = fit.num_columns();
  stream.ForEach(refit.parameters, fit.columns, [&](const RowPiece& piece) {
    for (int i = 0; i < piece.num_observations(); ++i) {
      const int k = piece.positions[i];
      const auto rows = piece.rows.middleRows(3 * i, 3);
      scores.row(setup.clusters[k]) +=
          (weights.empty() ? 1.0 : weights[k]) * rows.col(n).transpose() * rows.leftCols(n);
    }
  });
  return scores;
}

// sigma* of the columns: the model's, or the plain sandwich of whole configurations.
Eigen::VectorXd Sigmas(const Setup& setup, const Refit& refit, const std::vector<double>& weights) {
  const Linearization& fit = refit.linearization;
  if (!setup.by_configurations) {
    const double dof = std::max(1, refit.equations - fit.num_columns());
    // sigma*_c = |row c of W|, W W' = (J'J)^-1.
    return (setup.is_scaled ? std::sqrt(refit.chi2 / dof) : 1.0) * refit.left.root.rowwise().norm();
  }
  Eigen::MatrixXd scores = ScoresOf(setup, refit, weights);
  std::vector<double> count(setup.num_clusters, 1.0);
  for (size_t k = 0; k < weights.size(); ++k) count[setup.clusters[k]] = weights[k];
  // Rows carry the root of their weight w: the score of a configuration is w times
  // its own; drawn w times it counts w times the square of its own.
  for (int g = 0; g < setup.num_clusters; ++g) scores.row(g) *= count[g] > 0.0 ? 1.0 / std::sqrt(count[g]) : 0.0;
  const Eigen::MatrixXd priors = PriorsOf(refit.parameters, fit.columns).jacobian;
  const Eigen::MatrixXd spread = refit.left.root * (refit.left.root.transpose() * scores.transpose());
  const Eigen::MatrixXd stated = refit.left.root * (refit.left.root.transpose() * priors.transpose());
  return (spread.rowwise().squaredNorm() + stated.rowwise().squaredNorm()).cwiseSqrt();
}

// truth: what the data were drawn at.
Replicate MakeReplicate(const Setup& setup, const CalibrationProblem& problem, const ParameterSet& truth,
                        const std::vector<double>& weights, std::uint64_t prior_seed) {
  RefitOptions options;
  options.weights = weights;
  ParameterSet start = truth;
  DrawPriors(truth, prior_seed, &start);
  const Refit refit = RefitFrom(problem, start, options);
  Replicate replicate;
  if (!refit.converged) return replicate;
  const Eigen::VectorXd shift = TangentDifference(refit.parameters, truth);
  replicate.shift = shift(setup.estimate.estimated);
  replicate.sigma = Sigmas(setup, refit, weights);
  for (const int c : setup.estimate.estimated) replicate.on_bound.push_back(RestsOnBound(refit.parameters, c));
  replicate.used = replicate.sigma.allFinite() && replicate.shift.allFinite();
  return replicate;
}

// How often each configuration is drawn; the draw has as many as the data.
std::vector<double> DrawConfigurations(const Setup& setup, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<double> count(setup.num_clusters, 0.0);
  for (int i = 0; i < setup.num_clusters; ++i) count[random() % setup.num_clusters] += 1.0;
  std::vector<double> weights;
  weights.reserve(setup.clusters.size());
  for (const int cluster : setup.clusters) weights.push_back(count[cluster]);
  return weights;
}

std::vector<Replicate> RunReplicates(const Setup& setup, const BootstrapOptions& options) {
  const SigmaReport& sigma = setup.estimate.sigma;
  const double scale = sigma.scaled ? sigma.a_posteriori : 1.0;
  const double fallback = sigma.stated ? kFallbackSigma : sigma.estimated;
  std::vector<Replicate> replicates(options.replicates);
  std::vector<CalibrationProblem> copies(setup.by_configurations ? 0 : options.num_threads, setup.problem);
  std::mutex mutex;
  int done = 0;
  ParallelFor(options.replicates, options.num_threads, [&](int i, int worker) {
    const std::uint64_t seed = SeedOf(options.seed, 2ULL * i), prior_seed = SeedOf(options.seed, 2ULL * i + 1);
    const ParameterSet& estimate = setup.estimate.parameters;
    if (setup.by_configurations) {
      replicates[i] = MakeReplicate(setup, setup.problem, estimate, DrawConfigurations(setup, seed), prior_seed);
    } else {
      const ParameterSet truth = DrawTruth(estimate, SeedOf(~options.seed, i));
      const Simulator redraw = RedrawAt(setup.problem, truth, scale, fallback);
      if (redraw.Draw(seed, copies[worker].mutable_data())) {
        replicates[i] = MakeReplicate(setup, copies[worker], truth, {}, prior_seed);
      }
    }
    const std::lock_guard<std::mutex> lock(mutex);
    ++done;
    if (options.progress) {
      options.progress("bootstrap: " + std::to_string(done) + " of " + std::to_string(options.replicates));
    }
  });
  return replicates;
}

// What the refits do not repeat: the price of a loss, and, where the noise they are drawn with was estimated (REML),
// how far that may be off: Student's quantile over the normal one.
double WideningOf(const Setup& setup, double dof) {
  const double loss = std::sqrt(setup.estimate.noise_report.loss_inflation);
  if (setup.by_configurations || setup.is_scaled) return loss;
  return loss * StudentQuantile(kUpperOf95, dof) / NormalQuantile(kUpperOf95);
}

// model: the table before the draws. Refits that end at a physical bound all have the same value, whatever their data
// would have had beyond it: quantiles of theirs are none, and an interval may have no length. There the interval holds
// what the model's holds too.
void Studentise(const Setup& setup, const std::vector<Replicate>& used, const Eigen::VectorXd& plain_sigma,
                const std::vector<ParameterEstimate>& model, Estimate* estimate) {
  for (size_t c = 0; c < estimate->estimated.size(); ++c) {
    const double sigma = WideningOf(setup, estimate->interval_dof[c]) * plain_sigma[c];
    // t* = (theta* - theta_hat) / sigma*; interval [theta_hat - q_0.975 sigma, theta_hat - q_0.025 sigma], q quantiles
    // of t*: the tails change sides (bootstrap-t, Efron and Tibshirani 1993, section 12.5).
    std::vector<double> t;
    for (const Replicate& replicate : used) {
      t.push_back(replicate.sigma[c] > 0.0 ? replicate.shift[c] / replicate.sigma[c] : 0.0);
    }
    std::sort(t.begin(), t.end());
    ParameterEstimate& row = estimate->table[estimate->estimated[c]];
    const double lower = setup.estimate.parameters.coordinates()[estimate->estimated[c]].lower;
    const double low = row.value - InterpolatedQuantile(t, kUpperOf95) * sigma;
    row.at_bound = low < lower;
    row.ci95 = {std::max(lower, low), std::max(lower, row.value - InterpolatedQuantile(t, 0.025) * sigma)};
    row.dof = std::numeric_limits<double>::infinity();
    const bool any_on_bound =
        std::any_of(used.begin(), used.end(), [c](const Replicate& replicate) { return replicate.on_bound[c]; });
    if (!any_on_bound) continue;
    const ParameterEstimate& by_model = model[estimate->estimated[c]];
    row.ci95 = {std::min(row.ci95.low, by_model.ci95.low), std::max(row.ci95.high, by_model.ci95.high)};
    row.at_bound |= by_model.at_bound;
  }
}

bool ByConfigurations(const BootstrapOptions& options, int clusters, int unknowns) {
  if (options.kind == BootstrapKind::kAutomatic) return clusters >= kEnough * unknowns;
  if (options.kind == BootstrapKind::kConfigurations && clusters < unknowns) {
    throw InputError({"", 0, "bootstrap.kind"},
                     "too few configurations (" + std::to_string(clusters) + ") to draw from for " +
                         std::to_string(unknowns) + " unknowns",
                     "use parametric");
  }
  return options.kind == BootstrapKind::kConfigurations;
}

}  // namespace

void CheckOptions(const BootstrapOptions& options) {
  CheckIn(allowed::kReplicates, options.replicates, "BootstrapOptions.replicates");
  CheckIn(allowed::kThreads, options.num_threads, "BootstrapOptions.num_threads");
}

void BootstrapIntervals(const CalibrationProblem& problem, const BootstrapOptions& options, Estimate* estimate) {
  CheckOptions(options);
  Setup setup{problem, *estimate, false, false, {}, 0};
  setup.clusters = ConfigurationClusters(problem.data(), problem.CalibrationObservations());
  setup.num_clusters = setup.clusters.empty() ? 0 : 1 + *std::max_element(setup.clusters.begin(), setup.clusters.end());
  setup.by_configurations = ByConfigurations(options, setup.num_clusters, static_cast<int>(estimate->estimated.size()));
  setup.is_scaled = !estimate->sigma.stated || estimate->sigma.scaled;
  const Refit here = RefitFrom(problem, estimate->parameters);
  std::vector<Replicate> used;
  for (Replicate& replicate : RunReplicates(setup, options)) {
    if (replicate.used) used.push_back(std::move(replicate));
  }
  IntervalReport& report = estimate->intervals;
  report = IntervalReport();
  report.method = CovarianceKind::kBootstrap;
  report.kind = setup.by_configurations ? BootstrapKind::kConfigurations : BootstrapKind::kParametric;
  report.clusters = setup.by_configurations ? setup.num_clusters : 0;
  report.replicates = static_cast<int>(used.size());
  report.failed = options.replicates - report.replicates;
  report.seed = options.seed;
  report.words = BootstrapInWords(report, setup.num_clusters);
  // More failed than lie beyond both ends of an interval of 95 %.
  if (report.failed > options.replicates / 20 || !here.converged) {
    report.method = CovarianceKind::kModel;
    report.words = BootstrapRefused(report.failed, options.replicates);
    estimate->warnings.push_back(report.words);
    return;
  }
  const std::vector<ParameterEstimate> model = estimate->table;
  const auto n = static_cast<int>(estimate->estimated.size());
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(n);
  for (const Replicate& replicate : used) mean += replicate.shift / used.size();
  estimate->covariance.setZero(n, n);
  for (const Replicate& replicate : used) {
    estimate->covariance += (replicate.shift - mean) * (replicate.shift - mean).transpose() / (used.size() - 1.0);
  }
  estimate->covariance *= setup.estimate.noise_report.loss_inflation;
  FillTable(problem, estimate);
  Studentise(setup, used, Sigmas(setup, here, {}), model, estimate);
}

}  // namespace sagitta
