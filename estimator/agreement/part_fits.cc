#include "estimator/agreement/part_fits.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "estimator/least_squares/cluster_sandwich.h"
#include "estimator/least_squares/identifiability.h"
#include "estimator/least_squares/normal_equations.h"
#include "estimator/noise/repeat_spread.h"
#include "estimator/noise/weighting.h"
#include "estimator/statistics/distributions.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

// Degrees of freedom of a part: with less its noise is not known even to 1 / sqrt(12) = 29 %.
constexpr int kFewestFree = 6;

Linearization RowsOfPart(const Linearization& whole, const std::vector<int>& observations,
                         const std::vector<int>& columns) {
  Linearization part;
  std::vector<int> rows;
  for (const int k : observations) {
    part.observations.push_back(whole.observations[k]);
    for (int axis = 0; axis < 3; ++axis) rows.push_back(3 * k + axis);
  }
  for (const int c : columns) part.columns.push_back(whole.columns[c]);
  part.residual = whole.residual(rows);
  part.jacobian = whole.jacobian(rows, columns);
  return part;
}

// One part of the data: its rows, or, where they are many, as few with the same sums.
struct Part {
  const Whole& whole;
  const std::vector<int>& observations;
  const NormalSums* sums = nullptr;

  Linearization Of(const std::vector<int>& columns) const {
    return sums != nullptr ? Condense(SelectColumns(*sums, columns)) : RowsOfPart(whole.rows, observations, columns);
  }
  // Columns that it sees at all.
  std::vector<int> Seen() const {
    const int n = whole.num_columns();
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(n);
    if (sums != nullptr) squares = sums->matrix.diagonal().head(n);
    for (size_t i = 0; i < observations.size() && sums == nullptr; ++i) {
      squares += whole.rows.jacobian.middleRows<3>(3 * observations[i]).colwise().squaredNorm().transpose();
    }
    std::vector<int> seen;
    for (int c = 0; c < n; ++c) {
      if (squares[c] > 0.0) seen.push_back(c);
    }
    return seen;
  }
};

// Of the columns that a part sees, what it does not determine (positions in the whole).
std::vector<int> HeldColumns(const Part& part, const std::vector<int>& seen) {
  const Whole& whole = part.whole;
  const double scale = whole.is_scaled ? whole.estimate.sigma.a_posteriori : 1.0;
  const double noise = whole.estimate.sigma.stated ? scale : whole.estimate.sigma.estimated / kFallbackSigma;
  const Unidentifiable found = FindUnidentifiable(part.Of(seen), whole.estimate.parameters, noise);
  std::vector<int> held;
  for (const int c : found.columns) held.push_back(seen[c]);
  return held;
}

PartFit FitPart(const Part& part, const std::vector<int>& columns) {
  const Whole& whole = part.whole;
  PartFit fit;
  fit.columns = columns;
  fit.freedom = static_cast<int>(3 * part.observations.size()) - static_cast<int>(columns.size());
  if (columns.empty() || fit.freedom < kFewestFree) return fit;
  fit.solution = SolveLinearization(part.Of(columns));
  if (!fit.solution.full_rank) return fit;
  fit.model = (whole.is_scaled ? fit.solution.residual_norm_squared / fit.freedom : 1.0) * fit.solution.covariance;
  fit.model_dof = Eigen::VectorXd::Constant(
      static_cast<Eigen::Index>(columns.size()),
      whole.is_scaled ? static_cast<double>(fit.freedom) : std::numeric_limits<double>::infinity());
  fit.usable = true;
  return fit;
}

RobustCovariance SandwichOf(const Whole& whole, const std::vector<int>& observations, const PartFit& fit) {
  std::vector<int> clusters;
  for (const int k : observations) clusters.push_back(whole.clusters[k]);
  Linearization at_its_optimum = RowsOfPart(whole.rows, observations, fit.columns);
  // r + J d: where the part alone would end, to first order.
  at_its_optimum.residual += at_its_optimum.jacobian * fit.solution.step;
  return SandwichCovariance(at_its_optimum, clusters);
}

// Columns of both parts whose differences depend on how well the sandwiches are known: all where these are the
// intervals. Else only how many are inside is counted, and what is inside the normal interval is inside Student's.
std::array<std::vector<int>, 2> WithDegrees(const Whole& whole, const std::array<PartFit, 2>& fits) {
  const double normal = StudentQuantile(kUpperOf95, std::numeric_limits<double>::infinity());
  std::array<std::vector<int>, 2> listed;
  for (size_t i = 0; i < fits[0].columns.size(); ++i) {
    const auto same = std::find(fits[1].columns.begin(), fits[1].columns.end(), fits[0].columns[i]);
    if (same == fits[1].columns.end()) continue;
    const auto a = static_cast<int>(i), b = static_cast<int>(same - fits[1].columns.begin());
    const double variance = fits[0].sandwich.covariance(a, a) + fits[1].sandwich.covariance(b, b);
    const double difference = fits[0].step()[a] - fits[1].step()[b];
    if (!whole.by_sandwich && std::abs(difference) <= normal * std::sqrt(variance)) continue;
    listed[0].push_back(a);
    listed[1].push_back(b);
  }
  return listed;
}

// Adds the rows of every observation. False: an equilibrium diverges.
bool AddAllRows(const Whole& whole, PartSums* sums) {
  if (!whole.are_held) {
    return whole.stream->ForEachShared(whole.estimate.parameters, whole.columns,
                                       [&](const RowPiece& piece, const Share& share) { sums->Add(piece, share); });
  }
  RowMajorMatrix rows(3, whole.num_columns() + 1);
  for (int k = 0; k < static_cast<int>(whole.observations.size()); ++k) {
    rows << whole.rows.jacobian.middleRows<3>(3 * k), whole.rows.residual.segment<3>(3 * k);
    sums->Add(k, rows.data());
  }
  return true;
}

Partition PartitionOf(const Split& split, size_t observations) {
  Partition partition{2, std::vector<int>(observations, -1)};
  for (const int k : split.first) partition.part_of[k] = 0;
  for (const int k : split.second) partition.part_of[k] = 1;
  return partition;
}

}  // namespace

Whole::Whole(const CalibrationProblem& given, const Estimate& at, const FittedStream* fitted)
    : problem(given),
      estimate(at),
      observations(given.CalibrationObservations()),
      columns(at.estimated),
      turns(at.parameters, columns),
      clusters(fitted != nullptr ? fitted->clusters() : ConfigurationClusters(given.data(), observations)),
      is_scaled(!at.sigma.stated || at.sigma.scaled || WeighsByEq14(given.experiment())),
      by_sandwich(at.intervals.is_empirical()) {
  if (given.noise_origin == NoiseOrigin::kRepeats && !is_scaled) dof_by_repeats = DofByRepeats(given, at);
  are_held = AreHeld(num_rows(), num_columns());
  valid = !are_held;
  if (!are_held) {
    if (fitted != nullptr && given.weight_roots.empty()) {
      stream = fitted;
      return;
    }
    const auto noise = [&given](const std::vector<int>& listed) {
      return ObservationNoise(given, listed, kFallbackSigma);
    };
    own_stream.emplace(given, noise, nullptr, fitted != nullptr ? fitted->num_threads() : 1);
    stream = &*own_stream;
    return;
  }
  rows = Linearize(problem, estimate.parameters, observations, columns,
                   ObservationNoise(problem, observations, kFallbackSigma));
  valid = rows.valid;
  if (valid) turns.TurnColumns(&rows.jacobian);
  squared_residual = rows.residual.squaredNorm();
}

std::array<PartFit, 2> FitParts(const Whole& whole, const Split& split, const std::vector<NormalSums>* sums) {
  const Part parts[2] = {{whole, split.first, sums != nullptr ? &(*sums)[0] : nullptr},
                         {whole, split.second, sums != nullptr ? &(*sums)[1] : nullptr}};
  std::vector<int> columns[2];
  std::vector<int> held;
  for (int p = 0; p < 2; ++p) {
    columns[p] = parts[p].Seen();
    const std::vector<int> own = HeldColumns(parts[p], columns[p]);
    held.insert(held.end(), own.begin(), own.end());
  }
  std::array<PartFit, 2> fits;
  for (int p = 0; p < 2; ++p) {
    const auto is_held = [&](int c) { return std::find(held.begin(), held.end(), c) != held.end(); };
    columns[p].erase(std::remove_if(columns[p].begin(), columns[p].end(), is_held), columns[p].end());
    fits[p] = FitPart(parts[p], columns[p]);
  }
  return fits;
}

SumsOfParts SumParts(const std::vector<Split>& splits, Whole* whole, AlsoSummed* also) {
  if (whole->are_held && !AreMany(whole->rows)) return {};
  PartSums summed(whole->observations.size(), whole->columns);
  for (const Split& split : splits) summed.Divide(PartitionOf(split, whole->observations.size()));
  const bool are_shared = also != nullptr && !whole->own_stream && !whole->are_held;
  if (are_shared) summed.Divide(also->partition);
  whole->valid = AddAllRows(*whole, &summed);
  SummedParts totals = summed.Totals();
  if (are_shared && whole->valid) also->sums = std::move(totals.parts.back());
  totals.parts.resize(splits.size());
  whole->sums = std::move(totals.all);
  if (!whole->are_held) {
    whole->turns.TurnSums(&whole->sums.matrix);
    for (std::vector<NormalSums>& parts : totals.parts) {
      for (NormalSums& part : parts) whole->turns.TurnSums(&part.matrix);
    }
  }
  whole->squared_residual = whole->sums.squared_residual();
  return std::move(totals.parts);
}

bool IsLarger(double ratio, double dof) {
  constexpr double kSurplus = 2.0;  // standard errors
  return ratio > 1.0 + kSurplus * std::sqrt(0.5 / dof);
}

double RatioToModel(const Whole& whole, const RobustCovariance& sandwich) {
  const Eigen::VectorXd ratios = sandwich.covariance.diagonal()
                                     .cwiseQuotient(whole.turns.VariancesOf(whole.estimate.model_covariance))
                                     .cwiseSqrt();
  return Median({ratios.begin(), ratios.end()});
}

RobustCovariance AddSandwiches(const Whole& whole, const std::vector<Split>& splits, const std::vector<int>& listed,
                               std::vector<std::array<PartFit, 2>>* fits) {
  const Linearization priors = PriorsOf(whole.estimate.parameters, whole.columns);
  const auto parts = [&](int s) {
    return std::array<std::pair<const std::vector<int>*, PartFit*>, 2>{
        {{&splits[s].first, &(*fits)[s][0]}, {&splits[s].second, &(*fits)[s][1]}}};
  };
  if (whole.are_held) {
    for (const int s : listed) {
      for (const auto& [observations, fit] : parts(s)) {
        if (fit->usable) fit->sandwich = SandwichOf(whole, *observations, *fit);
      }
    }
    Linearization fit = whole.rows;
    if (priors.num_rows() > 0) AppendPriors(whole.estimate.parameters, &fit);
    return SandwichCovariance(fit, whole.clusters);
  }
  NormalSums all = whole.sums;
  all.matrix += SumRows(priors).matrix;
  const int num_clusters = 1 + *std::max_element(whole.clusters.begin(), whole.clusters.end());
  ClusterFit of_all;
  of_all.solution = SolveLinearization(Condense(all));
  if (!of_all.solution.full_rank) return {};
  std::vector<ClusterFit> asked = {of_all};
  std::vector<int> compared;
  for (const int s : listed) {
    if (!(*fits)[s][0].usable || !(*fits)[s][1].usable) continue;
    compared.push_back(s);
    for (const auto& [observations, fit] : parts(s)) {
      ClusterFit own{fit->solution, fit->columns, fit->solution.step, std::vector<char>(num_clusters, 0)};
      for (const int k : *observations) own.has[whole.clusters[k]] = 1;
      asked.push_back(std::move(own));
    }
  }
  const Eigen::Index n = whole.num_columns();
  Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(n, n);
  whole.turns.TurnColumns(&turn);
  const Eigen::MatrixXd normal = whole.turns.TurnBack(of_all.solution.covariance);
  ClusterSandwich sandwich(whole.num_columns(), num_clusters, normal, std::move(asked), turn,
                           whole.stream->num_threads());
  whole.stream->ForEachOfClusters(
      whole.estimate.parameters, whole.columns,
      [&](const RowPiece& piece, const Share& share) { sandwich.Add(piece, whole.clusters, share); });
  for (size_t i = 0; i < compared.size(); ++i) {
    const int first = 1 + 2 * static_cast<int>(i);
    std::array<PartFit, 2>& both = (*fits)[compared[i]];
    for (int p = 0; p < 2; ++p) both[p].sandwich = sandwich.Covariance(first + p);
    const std::array<std::vector<int>, 2> decisive = WithDegrees(whole, both);
    for (int p = 0; p < 2; ++p) {
      both[p].sandwich.dof.setConstant(both[p].step().size(), std::numeric_limits<double>::infinity());
      both[p].sandwich.dof(decisive[p]) = sandwich.DegreesOf(first + p, decisive[p]);
    }
  }
  RobustCovariance result = sandwich.Covariance(0);
  const Eigen::MatrixXd stated = of_all.solution.covariance * priors.jacobian.transpose();
  result.covariance += stated * stated.transpose();
  // Degrees of freedom are fewer than the clusters.
  return IsLarger(RatioToModel(whole, result), num_clusters) ? sandwich.Result(0, priors.jacobian) : result;
}

}  // namespace sagitta
