#include "estimator/agreement/part_fits.h"

#include <algorithm>
#include <limits>
#include <map>
#include <string>

#include "estimator/least_squares/identifiability.h"
#include "estimator/least_squares/sandwich.h"

namespace sagitta {
namespace {

constexpr int kFewestFree = 6;  // degrees of freedom of a part: less and its noise is not known

Linearization Rows(const Linearization& whole, const std::vector<int>& observations, const std::vector<int>& columns) {
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
    return sums != nullptr ? Condense(SelectColumns(*sums, columns)) : Rows(whole.rows, observations, columns);
  }
  // Columns that it sees at all.
  std::vector<int> Seen() const {
    const int n = whole.rows.num_columns();
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

// Of the columns that a part sees, what it cannot tell (positions in the whole).
std::vector<int> HeldColumns(const Part& part, const std::vector<int>& seen) {
  const Whole& whole = part.whole;
  const double scale = whole.is_scaled ? whole.estimate.sigma.a_posteriori : 1.0;
  const double noise = whole.estimate.sigma.stated ? scale : whole.estimate.sigma.estimated / kFallbackSigma;
  const Unidentifiable found = FindUnidentifiable(part.Of(seen), whole.estimate.parameters, noise);
  std::vector<int> held;
  for (const int c : found.columns) held.push_back(seen[c]);
  return held;
}

PartFit FitPart(const Part& part, const std::vector<int>& columns, bool with_sandwich) {
  const Whole& whole = part.whole;
  PartFit fit;
  fit.columns = columns;
  fit.freedom = static_cast<int>(3 * part.observations.size()) - static_cast<int>(columns.size());
  if (columns.empty() || fit.freedom < kFewestFree) return fit;
  const LinearSolution solution = SolveLinearization(part.Of(columns));
  if (!solution.full_rank) return fit;
  fit.step = solution.step;
  fit.model = (whole.is_scaled ? solution.residual_norm_squared / fit.freedom : 1.0) * solution.covariance;
  fit.model_dof = Eigen::VectorXd::Constant(
      fit.step.size(), whole.is_scaled ? static_cast<double>(fit.freedom) : std::numeric_limits<double>::infinity());
  fit.usable = true;
  if (!with_sandwich) return fit;
  std::vector<int> clusters;
  for (const int k : part.observations) clusters.push_back(whole.clusters[k]);
  Linearization at_its_optimum = Rows(whole.rows, part.observations, columns);
  at_its_optimum.residual += at_its_optimum.jacobian * solution.step;
  const RobustCovariance robust = SandwichCovariance(at_its_optimum, clusters);
  fit.sandwich = robust.covariance;
  fit.sandwich_dof = robust.dof;
  fit.clusters = robust.clusters;
  return fit;
}

}  // namespace

std::array<PartFit, 2> FitParts(const Whole& whole, const Split& split, const std::array<NormalSums, 2>* sums,
                                bool with_sandwich) {
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
    fits[p] = FitPart(parts[p], columns[p], with_sandwich);
  }
  return fits;
}

// Sums of the parts of all splits from one pass: observations that go together in every split are summed once.
SumsOfParts SumParts(const Linearization& rows, const std::vector<Split>& splits) {
  if (!AreMany(rows)) return {};
  std::vector<std::string> sides(rows.observations.size(), std::string(splits.size(), '-'));
  for (size_t s = 0; s < splits.size(); ++s) {
    for (const int k : splits[s].first) sides[k][s] = '0';
    for (const int k : splits[s].second) sides[k][s] = '1';
  }
  std::map<std::string, std::vector<int>> groups;
  for (size_t k = 0; k < sides.size(); ++k) groups[sides[k]].push_back(static_cast<int>(k));
  const int n = rows.num_columns() + 1;
  const NormalSums none{rows.valid, rows.columns, Eigen::MatrixXd::Zero(n, n), 0};
  SumsOfParts sums(splits.size(), {none, none});
  RowSums group(rows);
  for (const auto& [side, observations] : groups) {
    group.Clear();
    for (const int k : observations) {
      for (int axis = 0; axis < 3; ++axis) group.Add(3 * k + axis);
    }
    const Eigen::MatrixXd total = group.Total();
    for (size_t s = 0; s < splits.size(); ++s) {
      if (side[s] == '-') continue;
      NormalSums& part = sums[s][side[s] - '0'];
      part.matrix += total;
      part.rows += 3 * static_cast<int>(observations.size());
    }
  }
  return sums;
}

}  // namespace sagitta
