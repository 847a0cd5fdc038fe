#include "estimator/changes/sparse_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "models/dense_algebra.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

constexpr double kNegligible = 12.0;  // a set e^-12 below the best is not followed
// Sets that are followed at a time; after four rounds of them only those within e^-2 of the best, in all sixteen times
// as many. A choice that bounds the time.
constexpr size_t kBeam = 12;
// Prior probabilities: that nothing changed, and of each change after the first, as of causes
// (problems/prior_masses.h).
constexpr double kNothingChanged = 0.5, kFurtherChange = 0.3;

// Group and index of its scale, sorted.
using GroupSet = std::vector<std::pair<int, int>>;

class Search {
 public:
  Search(const Eigen::MatrixXd& columns, const Eigen::VectorXd& left, const std::vector<SparseGroup>& groups,
         const Eigen::VectorXd& applied)
      : gram_(columns.transpose() * columns),
        gradient_(columns.transpose() * left),
        left_(left.squaredNorm()),
        groups_(groups),
        applied_(applied.size() > 0 ? applied : Eigen::VectorXd::Zero(columns.cols())) {}

  SparsePosterior Run();

 private:
  struct Solved {
    std::vector<int> columns;
    Eigen::VectorXd scale;
    Eigen::LLT<Eigen::MatrixXd> factor;  // of I + G
    Eigen::VectorXd scaled_gradient;
    double squares = 0.0;  // r'r
  };
  Solved Solve(const GroupSet& set) const;
  double LogPosterior(const GroupSet& set);
  // Sets by one more, one less, one exchanged.
  std::vector<GroupSet> Neighbours(const GroupSet& set) const;

  // Whether a group and a part of it are in the set: a step of the search, and no answer.
  bool HasPartOfMember(const GroupSet& set) const {
    return std::any_of(set.begin(), set.end(), [&](const auto& part) {
      const auto is_whole = [&](const auto& member) { return groups_[part.first].part_of == member.first; };
      return std::any_of(set.begin(), set.end(), is_whole);
    });
  }

  SparsePosterior Summarise();
  void AddMembers(GroupSet set, SparsePosterior* posterior) const;
  double ScaleOf(int group, int scale) const {
    if (scale < kNumChangeScales) return kChangeScales[scale];
    return groups_[group].beyond == BeyondTypical::kLarge ? kLargeSize : kAnySize;
  }
  int NumScales(int group) const {
    return groups_[group].beyond == BeyondTypical::kNone ? kNumChangeScales : kNumChangeScales + 1;
  }
  bool IsAnywhere(int group, int scale) const {
    return scale == kNumChangeScales && groups_[group].beyond == BeyondTypical::kAnywhere;
  }

  const Eigen::MatrixXd gram_;
  const Eigen::VectorXd gradient_;  // of what is left
  const double left_;
  const std::vector<SparseGroup>& groups_;
  const Eigen::VectorXd applied_;
  std::map<GroupSet, double> seen_;
};

Search::Solved Search::Solve(const GroupSet& set) const {
  Solved solved;
  std::vector<double> scales;
  Eigen::VectorXd way = applied_;
  for (const auto& [group, scale] : set) {
    for (const int column : groups_[group].columns) {
      solved.columns.push_back(column);
      scales.push_back(ScaleOf(group, scale));
      if (IsAnywhere(group, scale)) way[column] = 0.0;
    }
  }
  const Eigen::VectorXd gradient_of_way = gram_ * way;
  solved.squares = left_ + way.dot(2.0 * gradient_ + gradient_of_way);
  solved.scale = Eigen::Map<const Eigen::VectorXd>(scales.data(), static_cast<long>(scales.size()));
  const Eigen::MatrixXd g =
      solved.scale.asDiagonal() * gram_(solved.columns, solved.columns) * solved.scale.asDiagonal();
  solved.factor.compute(g + Eigen::MatrixXd::Identity(g.rows(), g.cols()));
  solved.scaled_gradient = solved.scale.cwiseProduct((gradient_ + gradient_of_way)(solved.columns));
  return solved;
}

double Search::LogPosterior(const GroupSet& set) {
  const auto [entry, is_new] = seen_.try_emplace(set, 0.0);
  if (!is_new) return entry->second;
  if (set.empty()) {
    const double squares = left_ + applied_.dot(2.0 * gradient_ + gram_ * applied_);
    return entry->second = std::log(kNothingChanged) - 0.5 * squares;
  }
  const Solved solved = Solve(set);
  // Changes x ~ N(0, D^2) seen by y = J x + N(0, 1):  ln p(y | set) = 1/2 b'(1 + G)^-1 b - 1/2 ln|1 + G| + const, G = D
  // J'J D, b = D J'y.
  const double log_det = LogDeterminant(solved.factor);
  const double gain = solved.scaled_gradient.dot(solved.factor.solve(solved.scaled_gradient));
  double prior = std::log(1.0 - kNothingChanged) + (static_cast<double>(set.size()) - 1.0) * std::log(kFurtherChange);
  for (const auto& [group, scale] : set) prior -= std::log(static_cast<double>(groups_.size()) * NumScales(group));
  return entry->second = 0.5 * (gain - solved.squares) - 0.5 * log_det + prior;
}

std::vector<GroupSet> Search::Neighbours(const GroupSet& set) const {
  std::vector<GroupSet> from = {set};
  for (size_t i = 0; i < set.size(); ++i) {
    from.push_back(set);
    from.back().erase(from.back().begin() + static_cast<long>(i));
  }
  std::vector<GroupSet> neighbours(from.begin() + 1, from.end());
  for (const GroupSet& base : from) {
    const auto is_near = [this](const auto& member) { return !IsAnywhere(member.first, member.second); };
    const bool is_full = std::count_if(base.begin(), base.end(), is_near) >= kMostChangedGroups;
    for (int g = 0; g < static_cast<int>(groups_.size()); ++g) {
      if (std::any_of(base.begin(), base.end(), [g](const auto& member) { return member.first == g; })) continue;
      for (int s = 0; s < NumScales(g); ++s) {
        if (is_full && !IsAnywhere(g, s)) continue;
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
  return Summarise();
}

SparsePosterior Search::Summarise() {
  for (auto entry = seen_.begin(); entry != seen_.end();) {
    entry = HasPartOfMember(entry->first) ? seen_.erase(entry) : std::next(entry);
  }
  const auto lower = [](const auto& a, const auto& b) { return a.second < b.second; };
  const double best = std::max_element(seen_.begin(), seen_.end(), lower)->second;
  SparsePosterior posterior;
  posterior.log_best = best;
  posterior.probability.setZero(static_cast<long>(groups_.size()));
  posterior.nothing = 0.0;
  double sum = 0.0;
  std::map<std::vector<int>, double> by_groups;
  const auto members_of = [](const GroupSet& set) {
    std::vector<int> members;
    for (const auto& [group, scale] : set) members.push_back(group);
    return members;
  };
  for (const auto& [set, log] : seen_) {
    const double weight = std::exp(log - best);
    sum += weight;
    for (const auto& [group, scale] : set) posterior.probability[group] += weight;
    if (set.empty()) posterior.nothing += weight;
    by_groups[members_of(set)] += weight;
  }
  posterior.probability /= sum;
  posterior.nothing /= sum;
  const auto top = std::max_element(by_groups.begin(), by_groups.end(), lower);
  const GroupSet* most = nullptr;
  for (const auto& [set, log] : seen_) {
    if (members_of(set) == top->first && (most == nullptr || log > seen_.at(*most))) most = &set;
  }
  if (!most->empty()) AddMembers(*most, &posterior);
  return posterior;
}

// Which groups, the scales decide; how much, the data: at the widest scale nothing is drawn towards 0, and intervals
// hold.
void Search::AddMembers(GroupSet set, SparsePosterior* posterior) const {
  for (auto& member : set) member.second = std::max(member.second, kNumChangeScales - 1);
  const Solved solved = Solve(set);
  const Eigen::VectorXd mean = solved.scale.cwiseProduct(solved.factor.solve(solved.scaled_gradient));
  const Eigen::MatrixXd inverse = solved.factor.solve(Eigen::MatrixXd::Identity(mean.size(), mean.size()).eval());
  const Eigen::MatrixXd covariance = solved.scale.asDiagonal() * inverse * solved.scale.asDiagonal();
  long first = 0;
  for (const auto& [group, scale] : set) {
    const auto n = static_cast<long>(groups_[group].columns.size());
    posterior->best.push_back(
        {group, IsAnywhere(group, scale), mean.segment(first, n), covariance.block(first, first, n, n)});
    first += n;
  }
}

}  // namespace

bool SparsePosterior::IsFull() const {
  const auto is_near = [](const Member& member) { return !member.anywhere; };
  return std::count_if(best.begin(), best.end(), is_near) >= kMostChangedGroups;
}

SparsePosterior SearchSparse(const Eigen::MatrixXd& columns, const Eigen::VectorXd& left,
                             const std::vector<SparseGroup>& groups, const Eigen::VectorXd& applied) {
  return Search(columns, left, groups, applied).Run();
}

}  // namespace sagitta
