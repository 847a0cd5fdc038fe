#include "estimator/changes/sparse_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "models/dense_algebra.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

constexpr double kNegligible = 12.0;      // a set e^-12 below the best is not followed
constexpr size_t kBeam = 12;              // sets that are followed at a time
constexpr size_t kMostChangedGroups = 6;  // in a set

// Group and index of its scale, sorted.
using GroupSet = std::vector<std::pair<int, int>>;

class Search {
 public:
  Search(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual, const std::vector<std::vector<int>>& groups,
         const SparsePrior& prior)
      : gram_(columns.transpose() * columns),
        gradient_(columns.transpose() * residual),
        groups_(groups),
        prior_(prior) {}

  SparsePosterior Run();

 private:
  struct Solved {
    std::vector<int> columns;
    Eigen::VectorXd scale;
    Eigen::LLT<Eigen::MatrixXd> factor;  // of I + G
    Eigen::VectorXd scaled_gradient;
  };
  Solved Solve(const GroupSet& set) const;
  double LogPosterior(const GroupSet& set);
  // Sets by one more, one less, one exchanged.
  std::vector<GroupSet> Neighbours(const GroupSet& set) const;

  const Eigen::MatrixXd gram_;
  const Eigen::VectorXd gradient_;
  const std::vector<std::vector<int>>& groups_;
  const SparsePrior prior_;
  std::map<GroupSet, double> seen_;
};

Search::Solved Search::Solve(const GroupSet& set) const {
  Solved solved;
  std::vector<double> scales;
  for (const auto& [group, scale] : set) {
    for (const int column : groups_[group]) {
      solved.columns.push_back(column);
      scales.push_back(kChangeScales[scale]);
    }
  }
  solved.scale = Eigen::Map<const Eigen::VectorXd>(scales.data(), static_cast<long>(scales.size()));
  const Eigen::MatrixXd g =
      solved.scale.asDiagonal() * gram_(solved.columns, solved.columns) * solved.scale.asDiagonal();
  solved.factor.compute(g + Eigen::MatrixXd::Identity(g.rows(), g.cols()));
  solved.scaled_gradient = solved.scale.cwiseProduct(gradient_(solved.columns));
  return solved;
}

double Search::LogPosterior(const GroupSet& set) {
  const auto [entry, is_new] = seen_.try_emplace(set, 0.0);
  if (!is_new) return entry->second;
  if (set.empty()) return entry->second = std::log(prior_.nothing);
  const Solved solved = Solve(set);
  // Changes x ~ N(0, D^2) seen by y = J x + N(0, 1):  ln p(y | set) = 1/2 b'(1 + G)^-1 b - 1/2 ln|1 + G| + const, G = D
  // J'J D, b = D J'y.
  const double log_det = LogDeterminant(solved.factor);
  const double gain = solved.scaled_gradient.dot(solved.factor.solve(solved.scaled_gradient));
  const double each = std::log(1.0 / (static_cast<double>(groups_.size()) * kNumChangeScales));
  const auto size = static_cast<double>(set.size());
  return entry->second = 0.5 * gain - 0.5 * log_det + std::log(1.0 - prior_.nothing) +
                         (size - 1.0) * std::log(prior_.further) + size * each;
}

std::vector<GroupSet> Search::Neighbours(const GroupSet& set) const {
  std::vector<GroupSet> from = {set};
  for (size_t i = 0; i < set.size(); ++i) {
    from.push_back(set);
    from.back().erase(from.back().begin() + static_cast<long>(i));
  }
  std::vector<GroupSet> neighbours(from.begin() + 1, from.end());
  for (const GroupSet& base : from) {
    if (base.size() >= kMostChangedGroups) continue;
    for (int g = 0; g < static_cast<int>(groups_.size()); ++g) {
      if (std::any_of(base.begin(), base.end(), [g](const auto& member) { return member.first == g; })) continue;
      for (int s = 0; s < kNumChangeScales; ++s) {
        neighbours.push_back(base);
        neighbours.back().insert(std::lower_bound(neighbours.back().begin(), neighbours.back().end(), std::pair(g, s)),
                                 {g, s});
      }
    }
  }
  return neighbours;
}

SparsePosterior Search::Run() {
  std::vector<GroupSet> beam = {{}};
  double best = LogPosterior({});
  std::map<GroupSet, bool> expanded;
  while (!beam.empty()) {
    for (const GroupSet& set : beam) {
      expanded[set] = true;
      for (const GroupSet& neighbour : Neighbours(set)) best = std::max(best, LogPosterior(neighbour));
    }
    std::vector<std::pair<double, GroupSet>> open;
    for (const auto& [set, log] : seen_) {
      if (log > best - kNegligible && !expanded.count(set)) open.push_back({-log, set});
    }
    std::sort(open.begin(), open.end());
    if (open.size() > kBeam) open.resize(kBeam);
    beam.clear();
    // A set is worth a look while it is among the best; below, only what lies next to them counts.
    for (const auto& [log, set] : open) {
      if (expanded.size() < 4 * kBeam || -log > best - 2.0) beam.push_back(set);
    }
    if (expanded.size() > 16 * kBeam) break;
  }
  SparsePosterior posterior;
  posterior.probability.setZero(static_cast<long>(groups_.size()));
  posterior.nothing = 0.0;
  double sum = 0.0;
  GroupSet most;
  std::map<std::vector<int>, double> by_groups;
  for (const auto& [set, log] : seen_) {
    const double weight = std::exp(log - best);
    sum += weight;
    std::vector<int> members;
    for (const auto& [group, scale] : set) {
      posterior.probability[group] += weight;
      members.push_back(group);
    }
    if (set.empty()) posterior.nothing += weight;
    by_groups[members] += weight;
  }
  posterior.probability /= sum;
  posterior.nothing /= sum;
  const auto top = std::max_element(by_groups.begin(), by_groups.end(),
                                    [](const auto& a, const auto& b) { return a.second < b.second; });
  double most_log = -1e300;
  for (const auto& [set, log] : seen_) {
    std::vector<int> members;
    for (const auto& [group, scale] : set) members.push_back(group);
    if (members == top->first && log > most_log) most = set, most_log = log;
  }
  if (most.empty()) return posterior;
  // Which groups, the scales decide; how much, the data: at the widest scale nothing is drawn towards 0, and intervals
  // hold.
  for (auto& [group, scale] : most) scale = kNumChangeScales - 1;
  const Solved solved = Solve(most);
  const Eigen::VectorXd mean = solved.scale.cwiseProduct(solved.factor.solve(solved.scaled_gradient));
  const Eigen::MatrixXd inverse = solved.factor.solve(Eigen::MatrixXd::Identity(mean.size(), mean.size()).eval());
  const Eigen::MatrixXd covariance = solved.scale.asDiagonal() * inverse * solved.scale.asDiagonal();
  long first = 0;
  for (const auto& [group, scale] : most) {
    const auto n = static_cast<long>(groups_[group].size());
    posterior.best.push_back(group);
    posterior.mean.push_back(mean.segment(first, n));
    posterior.covariance.push_back(covariance.block(first, first, n, n));
    first += n;
  }
  return posterior;
}

}  // namespace

SparsePosterior SearchSparse(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                             const std::vector<std::vector<int>>& groups, const SparsePrior& prior) {
  return Search(columns, residual, groups, prior).Run();
}

}  // namespace sagitta
