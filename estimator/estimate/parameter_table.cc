#include "estimator/estimate/parameter_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

// Held parameters add less than this share of a variance (5 % of the interval): not worth a word.
constexpr double kNotWorthAWord = 0.1;

bool IsWeak(const ParameterEstimate& row) {
  const double limit = TraitsOf(row.quantity).weak_limit;
  return row.sigma > (limit > 0.0 ? limit : 0.5 * std::abs(row.value));
}

Interval Around(double value, double half, double lower) { return {std::max(lower, value - half), value + half}; }

ParameterEstimate Line(const CalibrationProblem& problem, const Estimate& estimate, int i) {
  const Coordinate& coordinate = estimate.parameters.coordinates()[i];
  ParameterEstimate row;
  row.name = coordinate.name;
  row.quantity = coordinate.quantity;
  row.lower = coordinate.lower;
  row.value = estimate.parameters.Value(i);
  row.nominal = estimate.aligned.num_coordinates() > 0 ? estimate.aligned.Value(i) : problem.parameters.Value(i);
  row.free = coordinate.estimated();
  row.identifiable = !coordinate.held;
  row.ci95 = {row.value, row.value};
  row.unconditional_ci95 = row.ci95;
  return row;
}

// Of an estimated column with this variance: the held coordinates that add to it, at least the one that adds most.
std::vector<int> WidenedBy(const HeldInfluence& held, long column, double variance) {
  const Eigen::ArrayXd moved = held.slopes.row(column).transpose().array();
  const Eigen::ArrayXd added = moved.square() * held.second_moment.diagonal().array();
  std::vector<int> by;
  for (long h = 0; h < added.size(); ++h) {
    if (added[h] > kNotWorthAWord * variance || added[h] == added.maxCoeff()) by.push_back(held.coordinates[h]);
  }
  return by;
}

}  // namespace

double ModelDof(const Estimate& estimate) {
  const bool is_student = estimate.sigma.IsOfResiduals() || estimate.sigma.scaled;
  if (!is_student) return std::numeric_limits<double>::infinity();
  const PriorPull& pull = estimate.sigma.pull;
  return std::max(1, estimate.dof - (pull.is_set_aside ? pull.priors : 0));
}

void FillTable(const CalibrationProblem& problem, Estimate* estimate) {
  const ParameterSet& parameters = estimate->parameters;
  estimate->table.clear();
  for (int i = 0; i < parameters.num_coordinates(); ++i) estimate->table.push_back(Line(problem, *estimate, i));
  const Eigen::MatrixXd added = AddedCovariance(estimate->held);
  for (size_t c = 0; c < estimate->estimated.size(); ++c) {
    ParameterEstimate& row = estimate->table[estimate->estimated[c]];
    const double lower = parameters.coordinates()[estimate->estimated[c]].lower;
    row.sigma = std::sqrt(estimate->covariance(c, c));
    row.dof = estimate->interval_dof[c];
    const double quantile = StudentQuantile(kUpperOf95, row.dof);
    row.weak = IsWeak(row);
    row.at_bound = row.value - quantile * row.sigma < lower;
    row.ci95 = Around(row.value, quantile * row.sigma, lower);
    row.conditional = IsWidened(row.sigma, added(c, c));
    if (row.conditional) row.conditional_on = WidenedBy(estimate->held, static_cast<long>(c), row.sigma * row.sigma);
    row.unconditional_sigma = std::sqrt(row.sigma * row.sigma + added(c, c));
    // What is held is as uncertain as its range says, whatever the noise is known by.
    const double dof = WelchDof(row.sigma * row.sigma, row.dof, added(c, c), std::numeric_limits<double>::infinity());
    row.unconditional_ci95 = Around(row.value, StudentQuantile(kUpperOf95, dof) * row.unconditional_sigma, lower);
  }
  for (size_t h = 0; h < estimate->held.coordinates.size(); ++h) {
    ParameterEstimate& row = estimate->table[estimate->held.coordinates[h]];
    const double lower = parameters.coordinates()[estimate->held.coordinates[h]].lower;
    row.unconditional_sigma = std::sqrt(estimate->held.second_moment(h, h));
    row.unconditional_ci95 = Around(row.value, NormalQuantile(kUpperOf95) * row.unconditional_sigma, lower);
  }
}

bool IsWidened(double sigma, double added) { return added > kNotWorthAWord * sigma * sigma; }

bool IsEven(const ParameterEstimate& row) {
  constexpr double kEven = 0.02;  // of an interval's width: its arms count as equal, for with two digits they look so
  const double down = row.value - row.ci95.low, up = row.ci95.high - row.value;
  return std::abs(up - down) <= kEven * (up + down) && !row.open_low && !row.open_high;
}

double AppliedNoise(const SigmaReport& sigma) {
  if (!sigma.stated) return sigma.estimated / kFallbackSigma;
  return sigma.scaled ? sigma.a_posteriori : 1.0;
}

}  // namespace sagitta
