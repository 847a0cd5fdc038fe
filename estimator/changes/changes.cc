#include "estimator/changes/changes.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/changes/sparse_search.h"
#include "estimator/report/changes_words.h"
#include "estimator/statistics/distributions.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Gauss-Newton rounds: a millimetre or a milliradian leaves a nanometre after the second.
constexpr int kRounds = 3;
constexpr double kWorthAWord = 0.05;

// value: of one parameter as it is; of a motion the length of its translation, or its angle where that is all there is.
Change DescribeChange(const ChangeGroup& group, const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                      double probability) {
  const double k = NormalQuantile(0.975);
  Change change;
  change.kind = group.kind;
  change.target = group.target;
  change.probability = probability;
  Eigen::VectorXd factor(group.size());
  for (int i = 0; i < group.size(); ++i) factor[i] = group.typical[i] / group.unit[i];
  const Eigen::VectorXd value = factor.cwiseProduct(mean);
  const Eigen::MatrixXd spread = factor.asDiagonal() * covariance * factor.asDiagonal();
  change.unit = group.units[0];
  if (group.size() == 1) {
    const double sigma = std::sqrt(spread(0, 0));
    change.value = value[0];
    change.ci95[0] = value[0] - k * sigma, change.ci95[1] = value[0] + k * sigma;
    change.words = ChangeInWords(change);
    return change;
  }
  for (int i = 0; i < group.size(); ++i) {
    const double sigma = std::sqrt(spread(i, i));
    change.parts.push_back({group.names[i], value[i], group.units[i], {value[i] - k * sigma, value[i] + k * sigma}});
  }
  change.value = value.head(3).norm();
  const Eigen::VectorXd along = value.head(3) / std::max(change.value, 1e-300);
  const double sigma = std::sqrt(along.dot(spread.topLeftCorner(3, 3) * along));
  change.ci95[0] = std::max(0.0, change.value - k * sigma), change.ci95[1] = change.value + k * sigma;
  change.words = ChangeInWords(change);
  if (group.size() == 6) change.words += TurnedInWords(value.tail(3).norm());
  return change;
}

nlohmann::ordered_json ToJson(const Change& change) {
  nlohmann::ordered_json json = {{"what", WordOf(change.kind)},
                                 {"target", change.target},
                                 {"value", change.value},
                                 {"unit", change.unit},
                                 {"ci95", {change.ci95[0], change.ci95[1]}},
                                 {"probability", change.probability},
                                 {"words", change.words}};
  if (change.parts.empty()) return json;
  json["parts"] = nlohmann::ordered_json::array();
  for (const Change::Part& part : change.parts) {
    json["parts"].push_back(
        {{"name", part.name}, {"value", part.value}, {"unit", part.unit}, {"ci95", {part.ci95[0], part.ci95[1]}}});
  }
  return json;
}

}  // namespace

Changes FindChanges(const KnownRobot& old_estimate, const KnownRobot& new_estimate) {
  EstimateComparison comparison(old_estimate, new_estimate);
  Changes result;
  result.notes = comparison.notes();
  result.before_rms = comparison.Rms();
  const std::vector<ChangeGroup>& groups = comparison.groups();
  SparsePosterior posterior;
  for (int round = 0; round < kRounds; ++round) {
    const EstimateComparison::Linear linear = comparison.Linearise();
    posterior = SearchSparse(linear.columns, linear.difference, linear.of_group);
    std::vector<Eigen::VectorXd> applied;
    for (const ChangeGroup& group : groups) applied.push_back(Eigen::VectorXd::Zero(group.size()));
    for (size_t i = 0; i < posterior.best.size(); ++i) applied[posterior.best[i]] = posterior.mean[i];
    comparison.MoveTo(applied);
  }
  result.after_rms = comparison.Rms();
  result.nothing = posterior.nothing;
  for (size_t i = 0; i < posterior.best.size(); ++i) {
    const int g = posterior.best[i];
    result.changes.push_back(
        DescribeChange(groups[g], posterior.mean[i], posterior.covariance[i], posterior.probability[g]));
  }
  for (size_t g = 0; g < groups.size(); ++g) {
    const double p = posterior.probability[static_cast<long>(g)];
    if (p < kWorthAWord ||
        std::find(posterior.best.begin(), posterior.best.end(), static_cast<int>(g)) != posterior.best.end()) {
      continue;
    }
    Change other;
    other.kind = groups[g].kind, other.target = groups[g].target, other.probability = p;
    result.alternatives.push_back(other);
  }
  const auto likelier = [](const Change& a, const Change& b) { return a.probability > b.probability; };
  std::sort(result.changes.begin(), result.changes.end(), likelier);
  std::sort(result.alternatives.begin(), result.alternatives.end(), likelier);
  result.words = ChangesInWords(result);
  return result;
}

nlohmann::ordered_json ChangesToJson(const Changes& changes) {
  nlohmann::ordered_json json = {{"schema", "sagitta/changed/1"}, {"words", changes.words}};
  json["changes"] = nlohmann::ordered_json::array();
  for (const Change& change : changes.changes) json["changes"].push_back(ToJson(change));
  json["nothing"] = changes.nothing;
  json["alternatives"] = nlohmann::ordered_json::array();
  for (const Change& other : changes.alternatives) {
    json["alternatives"].push_back(
        {{"what", WordOf(other.kind)}, {"target", other.target}, {"probability", other.probability}});
  }
  json["apart_rms_mm"] = {{"before", 1e3 * changes.before_rms}, {"after", 1e3 * changes.after_rms}};
  json["notes"] = changes.notes;
  return json;
}

}  // namespace sagitta
