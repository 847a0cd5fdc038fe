#include "estimator/diagnosis/confirmation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "estimator/statistics/distributions.h"
#include "problems/split.h"

namespace sagitta {
namespace {

constexpr int kFolds = 5;

// Part of each configuration: groups of equal joint values that are fitted are dealt in order of appearance, so that
// each part covers the whole time.
std::vector<int> PartOfConfiguration(const Measurements& data, int parts) {
  std::vector<int> part(data.configurations.size(), 0);
  int next = 0;
  for (const std::vector<int>& group : GroupsOfEqualJointValues(data)) {
    const auto is_held_out = [&](int c) { return data.configurations[c].is_validation; };
    if (std::all_of(group.begin(), group.end(), is_held_out)) continue;
    for (const int c : group) part[c] = next;
    next = (next + 1) % parts;
  }
  return part;
}

std::vector<int> PartOfRow(const CalibrationProblem& problem, const Linearization& here, int parts) {
  const std::vector<int> of_configuration = PartOfConfiguration(problem.data, parts);
  std::vector<int> of_row;
  for (const int observation : here.observations) {
    const int shot = problem.data.observations[observation].shot;
    of_row.insert(of_row.end(), 3, of_configuration[problem.data.shots[shot].configuration]);
  }
  return of_row;
}

std::vector<int> RowsOf(const std::vector<int>& part_of_row, int part) {
  std::vector<int> rows;
  for (size_t row = 0; row < part_of_row.size(); ++row) {
    if (part_of_row[row] == part) rows.push_back(static_cast<int>(row));
  }
  return rows;
}

// Chi-square per row of configurations left out of the fit, from one
// linearization: with N = J'J, g = J'r (priors included), and those of a fold f,
//   e_f = r_f - J_f (N - N_f)^-1 (g - g_f).
double CrossValidated(const Linearization& complete, const std::vector<int>& fold_of_row) {
  const Eigen::VectorXd scale = complete.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd jacobian = complete.jacobian * scale.asDiagonal();
  const Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  const Eigen::VectorXd gradient = jacobian.transpose() * complete.residual;
  double sum = 0.0;
  for (int fold = 0; fold < kFolds; ++fold) {
    const std::vector<int> own = RowsOf(fold_of_row, fold);
    const Eigen::MatrixXd left_out = jacobian(own, Eigen::all);
    const Eigen::VectorXd residual = complete.residual(own);
    const Eigen::LDLT<Eigen::MatrixXd> rest(information - left_out.transpose() * left_out);
    sum += (residual - left_out * rest.solve(gradient - left_out.transpose() * residual)).squaredNorm();
  }
  return fold_of_row.empty() ? 0.0 : sum / static_cast<double>(fold_of_row.size());
}

// With priors, and with other columns and another residual.
Linearization Complete(const ParameterSet& parameters, const Linearization& believed, const std::vector<int>& columns,
                       const Eigen::VectorXd& residual) {
  Linearization complete;
  complete.residual = residual;
  complete.jacobian = believed.jacobian(Eigen::all, columns);
  for (const int c : columns) complete.columns.push_back(believed.columns[c]);
  AppendPriors(parameters, &complete);
  return complete;
}

// Values and covariance of the step's parameters on one half, without those that only a prior holds.
void ReadValues(const StepBench& steps, const LinearSolution& half, const ChosenStep& step, HalfResult* result) {
  if (!half.full_rank) return;
  const ParameterSet& parameters = steps.model().estimate.parameters;
  const std::vector<int> own = steps.OwnColumns(step);
  result->values.resize(own.size());
  for (size_t i = 0; i < own.size(); ++i) {
    result->values[i] = parameters.Value(steps.whole().believed.columns[own[i]]) + half.step[own[i]];
  }
  result->covariance = half.covariance(own, own);
}

constexpr double kNothingCompared = std::numeric_limits<double>::quiet_NaN();

// In units of the scatter that is left: a model that does not reach the stated sigma cannot use it as yardstick.
double CompatibleP(const HalfResult& a, const HalfResult& b, double left) {
  if (a.values.size() == 0 || a.values.size() != b.values.size()) return kNothingCompared;
  const Eigen::VectorXd difference = a.values - b.values;
  const Eigen::LLT<Eigen::MatrixXd> joint(a.covariance + b.covariance);
  if (joint.info() != Eigen::Success) return kNothingCompared;
  return ChiSquareSurvival(difference.dot(joint.solve(difference)) / left, static_cast<double>(difference.size()));
}

}  // namespace

ConfirmationBench::ConfirmationBench(const StepBench& steps) : steps_(steps) {
  const auto with_priors = [&](Linearization complete) {
    AppendPriors(steps.model().estimate.parameters, &complete);
    return complete;
  };
  const Linearization& all = steps.whole().believed;
  const CalibrationProblem& problem = *steps.model().problem;
  const std::vector<int> half_of_row = PartOfRow(problem, all, 2);
  for (int half = 0; half < 2; ++half) {
    halves_.push_back(steps.PartOfRows(RowsOf(half_of_row, half)));
    solutions_.push_back(SolveLinearization(with_priors(halves_.back().believed)));
  }
  fold_of_row_ = PartOfRow(problem, all, kFolds);
  cv_with_ = CrossValidated(with_priors(all), fold_of_row_);
}

HalfResult ConfirmationBench::NameAgain(const BenchPart& half, const ChosenStep& step,
                                        const Eigen::VectorXd& neutral_residual, double tie) const {
  HalfResult result;
  const WithoutStep without = steps_.Without(step, neutral_residual, half);
  const double own = without.residual.Test(without.own, step.candidate.settings).penalised;
  const Eigen::VectorXd found = without.residual.Reproduce(without.own, without.residual.residual());
  double best = std::max(0.0, own);
  if (own > 0.0) result.best = step.candidate.spec.Path();
  const Screening screening(half.candidates, without.residual, without.has_spring);
  for (size_t i = 0; i < half.candidates.candidates().size(); ++i) {
    if (half.candidates.candidates()[i].spec.Path() == step.candidate.spec.Path()) continue;
    const CandidateScore scored = screening.Of(static_cast<int>(i));
    if (scored.score.rank == 0 || scored.score.penalised <= best) continue;
    if (scored.oversized && !step.candidate.oversized) continue;  // few have an optimum near an absurd size
    if (own > 0.0 && screening.Reproduced(scored, found) < kOverlapOfRivals * found.squaredNorm()) continue;
    best = scored.score.penalised;
    result.best = half.candidates.candidates()[i].spec.Path();
  }
  result.telling = best > 0.0;
  result.named = own > 0.0 && own > best - tie;
  return result;
}

Confirmation ConfirmationBench::Confirm(const ChosenStep& step, const Eigen::VectorXd& neutral_residual,
                                        double tie) const {
  Confirmation confirmation;
  for (size_t half = 0; half < halves_.size(); ++half) {
    confirmation.halves.push_back(NameAgain(halves_[half], step, neutral_residual, tie));
    ReadValues(steps_, solutions_[half], step, &confirmation.halves.back());
  }
  const Estimate& all = steps_.model().estimate;
  const double left = all.dof > 0 ? all.chi2 / all.dof : 1.0;
  confirmation.compatible_p = CompatibleP(confirmation.halves[0], confirmation.halves[1], std::max(1.0, left));
  confirmation.folds = static_cast<int>(std::set<int>(fold_of_row_.begin(), fold_of_row_.end()).size());
  if (confirmation.folds < 2) {
    confirmation.cv_before = confirmation.cv_after = kNothingCompared;
    return confirmation;
  }
  confirmation.cv_before = CrossValidated(Complete(steps_.model().estimate.parameters, steps_.whole().believed,
                                                   steps_.OtherColumns(step), neutral_residual),
                                          fold_of_row_);
  confirmation.cv_after = cv_with_;
  return confirmation;
}

}  // namespace sagitta
