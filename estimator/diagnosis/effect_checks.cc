#include "estimator/diagnosis/effect_checks.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

constexpr double kRank = 1e-6;  // of the largest eigenvalue: directions below are rounding
// Of the prior variance, what is left of a parameter that the data hardly tell. A direction that they do not tell at
// all may lie along all four parameters of an effect: each keeps a quarter.
constexpr double kPoorlyDetermined = 0.2;
// Of the same: above, the prior stays in the refit. Below, a tenth of its width, it would move a value of three typical
// sizes by less than a third of its standard deviation, and is left out.
constexpr double kPriorMatters = 0.01;
constexpr double kTakesItsPlace = 0.5;  // of what the effect explains
constexpr size_t kRivalsOnHalves = 40;  // names that are asked on a half

WeightedSet Without(const Evidence& evidence, const WeightedModel& model, int member) {
  std::vector<int> members;
  std::vector<double> scales;
  for (size_t k = 0; k < model.set.members.size(); ++k) {
    if (model.set.members[k] == member) continue;
    members.push_back(model.set.members[k]);
    scales.push_back(model.set.scales[k]);
  }
  return evidence.SearchIn(model.view).Evaluate(members, scales);
}

// Log weights of the set with each explanation in the member's place.
std::vector<double> InItsPlace(const Evidence& evidence, const WeightedModel& model, int member) {
  return evidence.SearchIn(model.view).Additions(Without(evidence, model, member));
}

std::vector<NamedProbability> ByName(const Evidence& evidence, const std::vector<double>& weights) {
  const double sum = LogSumExp(weights);
  std::map<std::string, NamedProbability> names;
  std::map<std::string, double> most;
  for (size_t k = 0; k < weights.size(); ++k) {
    const double p = std::exp(weights[k] - sum);
    if (!(p > 1e-12)) continue;
    const std::string& name = evidence.list().name[k];
    NamedProbability& entry = names.emplace(name, NamedProbability{name, static_cast<int>(k), 0.0}).first->second;
    entry.probability += p;
    if (p > most[name]) {
      most[name] = p;
      entry.explanation = static_cast<int>(k);
    }
  }
  std::vector<NamedProbability> list;
  for (const auto& [name, entry] : names) list.push_back(entry);
  std::stable_sort(list.begin(), list.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  return list;
}

// Eigenvectors and values of what a group can tell.
struct Told {
  Eigen::MatrixXd vectors;
  Eigen::VectorXd values;
};

Told Tell(const Eigen::MatrixXd& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  const double least = kRank * std::max(1e-300, eigen.eigenvalues().maxCoeff());
  const int rank = static_cast<int>((eigen.eigenvalues().array() > least).count());
  return {eigen.eigenvectors().rightCols(rank), eigen.eigenvalues().tail(rank)};
}

Eigen::VectorXd Solve(const Told& told, const Eigen::VectorXd& gradient) {
  return told.vectors * (told.vectors.transpose() * gradient).cwiseQuotient(told.values);
}

ColumnGroup Joined(const ColumnGroup& a, const ColumnGroup& b) {
  ColumnGroup both;
  both.columns = a.columns;
  both.columns.insert(both.columns.end(), b.columns.begin(), b.columns.end());
  both.mixing.setZero(static_cast<long>(both.columns.size()), a.size() + b.size());
  const auto put = [&both](const ColumnGroup& group, long row, long column) {
    const long height = static_cast<long>(group.columns.size());
    both.mixing.block(row, column, height, group.size()) =
        group.mixing.size() > 0 ? group.mixing : Eigen::MatrixXd::Identity(height, height);
  };
  put(a, 0, 0);
  put(b, static_cast<long>(a.columns.size()), a.size());
  return both;
}

}  // namespace

std::vector<NamedProbability> InPlaceOf(const Evidence& evidence, const WeightedModel& model, int member) {
  return ByName(evidence, InItsPlace(evidence, model, member));
}

std::vector<NamedProbability> ShapesInPlaceOf(const Evidence& evidence, const WeightedModel& model, int member) {
  const std::vector<double> weights = InItsPlace(evidence, model, member);
  std::vector<NamedProbability> shapes;
  for (size_t k = 0; k < weights.size(); ++k) {
    if (evidence.list().name[k] != evidence.list().name[member]) continue;
    shapes.push_back({evidence.list().name[k], static_cast<int>(k), weights[k]});
  }
  std::stable_sort(shapes.begin(), shapes.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  return shapes;
}

// With c = A a the effect's contribution, a its values given the others:  |P_rival c|^2 / |c|^2.
std::vector<Alternative> FindAlternatives(const Evidence& evidence, const Posterior& posterior,
                                          const WeightedModel& model, int member,
                                          const std::vector<NamedProbability>& in_place) {
  const WeightedSet others = Without(evidence, model, member);
  const Sweep sweep(evidence.views()[model.view].beside.normal, evidence.GroupsOf(others), others.scales);
  const ColumnGroup& own = evidence.list().math[member].group;
  const Eigen::MatrixXd information = sweep.Information(own);
  const Eigen::VectorXd values = Solve(Tell(information), sweep.Gradient(own));
  const double size = std::max(1e-300, values.dot(information * values));
  std::vector<Alternative> alternatives;
  for (const NamedProbability& rival : in_place) {
    if (rival.probability < kWorthListing || rival.name == evidence.list().name[member]) continue;
    if (evidence.list().IsUnnamed(rival.explanation)) continue;
    const Eigen::MatrixXd both = sweep.Information(Joined(own, evidence.list().math[rival.explanation].group));
    const long n = own.size(), m = both.cols() - n;
    const Eigen::VectorXd across = both.bottomLeftCorner(m, n) * values;
    const double overlap = across.dot(Solve(Tell(both.bottomRightCorner(m, m)), across)) / size;
    if (overlap < kTakesItsPlace) continue;  // it would be added, not put in its place
    alternatives.push_back(
        {evidence.list().start[rival.explanation], posterior.Of(rival.name), std::min(1.0, overlap)});
  }
  return alternatives;
}

double ResidualAtBest(const Evidence& evidence, const WeightedModel& model) {
  const ProjectedNormal& normal = evidence.views()[model.view].beside.normal;
  if (model.set.members.empty()) return normal.residual;
  const std::vector<const ColumnGroup*> groups = evidence.GroupsOf(model.set);
  std::vector<double> scales = model.set.scales;
  for (size_t k = 0; k < groups.size(); ++k) {
    const bool is_spring = IsGravityCompensator(evidence.list().start[model.set.members[k]]);
    if (!is_spring) scales[k] = kScales[kNumScales - 1];
  }
  const Eigen::VectorXd values = -ValuesOf(normal, groups, scales).values;  // measured minus predicted
  ColumnGroup all = *groups[0];
  for (size_t k = 1; k < groups.size(); ++k) all = Joined(all, *groups[k]);
  const Sweep sweep(normal, {}, {});
  return normal.residual - 2.0 * values.dot(sweep.Gradient(all)) + values.dot(sweep.Information(all) * values);
}

MemberFit FitOf(const Evidence& evidence, const WeightedModel& model, int member) {
  const WeightedSet others = Without(evidence, model, member);
  const Sweep sweep(evidence.views()[model.view].beside.normal, evidence.GroupsOf(others), others.scales);
  const ColumnGroup& own = evidence.list().math[member].group;
  const Eigen::MatrixXd information = sweep.Information(own);
  const Eigen::VectorXd gradient = sweep.Gradient(own);
  const Told told = Tell(information);
  MemberFit fit;
  fit.reduction = gradient.dot(Solve(told, gradient));
  fit.parameters = static_cast<int>(told.values.size());
  if (own.mixing.size() > 0 || evidence.list().IsUnnamed(member)) return fit;
  const double variance = kScales[kNumScales - 1] * kScales[kNumScales - 1];
  const Eigen::MatrixXd precision =
      information + Eigen::MatrixXd::Identity(information.rows(), information.cols()) / variance;
  const Eigen::VectorXd left =
      precision.llt().solve(Eigen::MatrixXd(Eigen::MatrixXd::Identity(precision.rows(), precision.cols()))).diagonal();
  for (long c = 0; c < left.size(); ++c) {
    const std::string& name = evidence.columns().Name(own.columns[static_cast<size_t>(c)]);
    if (left[c] > kPoorlyDetermined * variance) fit.poorly_determined.push_back(name);
    if (left[c] > kPriorMatters * variance) fit.loose.push_back(name);
  }
  return fit;
}

Confirmation Confirm(const Evidence& evidence, const WeightedModel& model, int member,
                     const std::vector<NamedProbability>& in_place) {
  const EvidenceColumns& columns = evidence.columns();
  // The set, then the rivals.
  std::vector<int> asked = model.set.members;
  for (const NamedProbability& rival : in_place) {
    if (asked.size() >= model.set.members.size() + kRivalsOnHalves) break;
    if (rival.name != evidence.list().name[member]) asked.push_back(rival.explanation);
  }
  const FewExplanations few = WithTheirColumns(evidence.list().math, asked);
  const int own = static_cast<int>(std::find(asked.begin(), asked.end(), member) - asked.begin());
  Confirmation confirmation;
  for (int half = 0; half < 2; ++half) {
    const int middle = columns.num_poses() / 2;
    std::vector<int> poses(half == 0 ? middle : columns.num_poses() - middle);
    std::iota(poses.begin(), poses.end(), half == 0 ? 0 : middle);
    if (poses.empty()) continue;
    const ViewedNormal& view = evidence.views()[model.view];
    const BesideBelieved beside = columns.Project(columns.Sum(view.scatter, &few.columns, poses));
    const SetSearch search(beside.normal, few.explanations, evidence.prior(), evidence.Likelihood(beside.normal.dof));
    WeightedSet others;
    std::vector<const ColumnGroup*> groups;
    std::vector<double> scales;
    for (size_t k = 0; k < model.set.members.size(); ++k) {
      groups.push_back(&few.explanations[k].group);
      scales.push_back(kScales[kNumScales - 1]);
      if (static_cast<int>(k) == own) continue;
      others.members.push_back(static_cast<int>(k));
      others.scales.push_back(model.set.scales[k]);
    }
    const std::vector<double> weights = search.Additions(search.Evaluate(others.members, others.scales));
    const double sum = LogSumExp(weights);
    HalfResult result;
    const auto best = std::max_element(weights.begin(), weights.end());
    result.best = evidence.list().name[asked[static_cast<size_t>(best - weights.begin())]];
    for (size_t k = 0; k < asked.size(); ++k) {
      if (evidence.list().name[asked[k]] == evidence.list().name[member])
        result.probability += std::exp(weights[k] - sum);
    }
    const GroupValues values = ValuesOf(beside.normal, groups, scales);
    long first = 0;
    for (int k = 0; k < own; ++k) first += few.explanations[static_cast<size_t>(k)].group.size();
    const long size = few.explanations[static_cast<size_t>(own)].group.size();
    result.values = values.values.segment(first, size);
    result.covariance = values.covariance.block(first, first, size, size);
    confirmation.halves.push_back(std::move(result));
  }
  confirmation.compatible_p = std::numeric_limits<double>::quiet_NaN();
  if (confirmation.halves.size() < 2) return confirmation;
  const Eigen::VectorXd apart = confirmation.halves[0].values - confirmation.halves[1].values;
  const Eigen::LLT<Eigen::MatrixXd> joint(
      Eigen::MatrixXd(confirmation.halves[0].covariance + confirmation.halves[1].covariance));
  if (joint.info() == Eigen::Success) {
    confirmation.compatible_p = ChiSquareSurvival(apart.dot(joint.solve(apart)), static_cast<double>(apart.size()));
  }
  return confirmation;
}

}  // namespace sagitta
