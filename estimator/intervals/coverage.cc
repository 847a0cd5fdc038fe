#include "estimator/intervals/coverage.h"

#include <cmath>

#include "estimator/baselines/compare_methods.h"
#include "estimator/calibration/noise_loop.h"
#include "estimator/intervals/intervals.h"
#include "estimator/intervals/redraw.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/refit.h"
#include "models/constants.h"
#include "problems/noise_checks.h"

namespace sagitta {
namespace {

Estimate EstimateBy(Method method, const CalibrationProblem& problem) {
  ResolvedEstimate resolved = EstimateWithNoise(problem);
  Estimate& estimate = resolved.estimate;
  if (!IsUsable(estimate.status)) return estimate;
  if (method != Method::kJoint) estimate = RunMethod(resolved.problem, method, estimate).estimate;
  if (IsUsable(estimate.status)) AddIntervals(resolved.problem, {}, &estimate);
  return estimate;
}

// Truth minus value within the interval's arms, so that rotations count by their perturbation.
bool Covers(const ParameterEstimate& row, double error) {
  const Interval& interval = row.conditional ? row.unconditional_ci95 : row.ci95;
  const bool above = row.open_low || interval.low - row.value <= -error;
  const bool below = row.open_high || -error <= interval.high - row.value;
  return above && below;
}

}  // namespace

CoverageStudy::CoverageStudy(const CalibrationProblem& problem, const Estimate& truth, Method method,
                             unsigned long long seed)
    : problem_(problem), truth_(truth), method_(method), seed_(seed) {
  noise_scale_ = truth.sigma.scaled ? truth.sigma.a_posteriori : 1.0;
  fallback_ = truth.sigma.stated ? kFallbackSigma : truth.sigma.estimated;
  const Linearization fit = LinearizeFit(problem, truth.parameters, truth.estimated);
  const Eigen::MatrixXd root = SolveLinearization(fit).covariance_root;
  Linearization best = fit;  // the Cramér-Rao bound is that of the noise, whatever the fit weighs with
  if (!problem.weight_roots.empty()) {
    best = Linearize(problem, truth.parameters, fit.observations, truth.estimated,
                     ObservationNoise(problem, fit.observations, fallback_));
    AppendPriors(truth.parameters, &best);
  }
  const double scale = truth.sigma.stated ? noise_scale_ : truth.sigma.estimated / kFallbackSigma;
  // Cramér and Rao: no unbiased estimate scatters by less than (J'J)^-1, J whitened by the true noise.
  cramer_rao_ = scale * SolveLinearization(best).covariance.diagonal().cwiseSqrt();
  // -(J'J)^-1 J'r: the error of the estimate to first order in the noise. What a trial has beyond it is the model's
  // curvature.
  linear_ = root * (root.transpose() * fit.jacobian.transpose());
}

CoverageTrial CoverageStudy::Run(int number, CalibrationProblem* own) const {
  const size_t n = truth_.estimated.size();
  CoverageTrial trial;
  trial.number = number;
  trial.error.assign(n, kNotKnown);
  trial.linear_error.assign(n, kNotKnown);
  trial.sigma.assign(n, kNotKnown);
  trial.covered.assign(n, -1);
  const ParameterSet truth = DrawTruth(truth_.parameters, SeedOf(~seed_, number));
  const Simulator redraw = RedrawAt(problem_, truth, noise_scale_, fallback_);
  if (!redraw.Draw(SeedOf(seed_, 2ULL * number), own->mutable_data())) {
    trial.status = StatusName(Status::kEquilibriumDiverged);
    return trial;
  }
  ResolveRepeats(own);
  DrawPriors(truth, SeedOf(seed_, 2ULL * number + 1), &own->parameters);
  // Refits of its own for every trial: the same draws in all of them would share the luck of their quantiles.
  own->mutable_experiment()->method.bootstrap.seed = SeedOf(problem_.experiment().method.bootstrap.seed, number);
  const Estimate estimate = EstimateBy(method_, *own);
  trial.status = StatusName(estimate.status);
  if (!IsUsable(estimate.status)) return trial;
  ParameterSet with_priors = truth;
  DrawPriors(truth, SeedOf(seed_, 2ULL * number + 1), &with_priors);
  CalibrationProblem at_truth = problem_;  // with the true noise
  std::vector<Observation>& rows = at_truth.mutable_data()->observations;
  rows = own->data().observations;
  for (size_t k = 0; k < rows.size(); ++k) rows[k].excluded = problem_.data().observations[k].excluded;
  const Eigen::VectorXd linear = -linear_ * LinearizeFit(at_truth, with_priors, truth_.estimated).residual;
  const Eigen::VectorXd error = TangentDifference(estimate.parameters, truth);
  for (size_t c = 0; c < n; ++c) {
    const ParameterEstimate& row = estimate.table[truth_.estimated[c]];
    trial.linear_error[c] = linear[c];
    if (!row.free || !(row.sigma > 0.0)) continue;
    trial.error[c] = error[truth_.estimated[c]];
    trial.sigma[c] = row.conditional ? row.unconditional_sigma : row.sigma;
    trial.covered[c] = Covers(row, trial.error[c]) ? 1 : 0;
  }
  return trial;
}

std::vector<CoverageRow> CoverageStudy::Summarise(const std::vector<CoverageTrial>& trials) const {
  std::vector<CoverageRow> rows;
  for (size_t c = 0; c < truth_.estimated.size(); ++c) {
    const ParameterEstimate& line = truth_.table[truth_.estimated[c]];
    CoverageRow row;
    row.name = line.name;
    row.quantity = line.quantity;
    row.conditional = line.conditional;
    row.cramer_rao = cramer_rao_[c];
    for (const CoverageTrial& trial : trials) {
      if (trial.covered[c] < 0) continue;
      ++row.trials;
      row.covered += trial.covered[c];
      row.bias += trial.error[c];
      row.rmse += trial.error[c] * trial.error[c];
      row.linear_rmse += trial.linear_error[c] * trial.linear_error[c];
      row.predicted_sigma += trial.sigma[c] * trial.sigma[c];
    }
    const double count = std::max(1, row.trials);
    row.bias /= count;
    for (double* mean_square : {&row.rmse, &row.linear_rmse, &row.predicted_sigma}) {
      *mean_square = std::sqrt(*mean_square / count);
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace sagitta
