#include "estimator/agreement/splits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace sagitta {
namespace {

constexpr double kDividesNothing = 0.02;  // rad or m: a joint that covers less divides nothing
constexpr double kSmallestPart = 0.25;    // of the configurations
constexpr int kFewestOfPart = 5;          // configurations of a part
constexpr size_t kMostPairs = 4;          // stations that are compared two by two; more: each against the rest

class Splitter {
 public:
  Splitter(const CalibrationProblem& problem, const Estimate& estimate, const std::vector<int>& clusters)
      : problem_(problem), estimate_(estimate), clusters_(clusters), rows_(problem.CalibrationObservations()) {
    num_clusters_ = clusters.empty() ? 0 : 1 + *std::max_element(clusters.begin(), clusters.end());
    rows_of_cluster_.assign(static_cast<size_t>(num_clusters_), 0);
    for (const int c : clusters) ++rows_of_cluster_[c];
  }

  std::vector<Split> All(unsigned long long seed, int random_halves) {
    std::mt19937_64 random(seed);
    for (int i = 0; i < random_halves; ++i) AddRandom(&random);
    for (int j = 0; j < problem_.robot().num_joints(); ++j) AddJoint(j);
    const std::vector<Pose<double>> bases = Bases();
    for (int axis = 0; axis < 3; ++axis) {
      AddMedian(SplitBy::kRegion, std::string(1, "xyz"[axis]), MeanOf([&](int i) { return PlaceOf(i, axis, bases); }));
    }
    AddStations();
    AddTime();
    return splits_;
  }

 private:
  using Clusters = std::vector<char>;  // of each: 1 where it belongs

  const Shot& ShotOf(int i) const { return problem_.data().shots[problem_.data().observations[i].shot]; }

  // Of each station.
  std::vector<Pose<double>> Bases() const {
    std::vector<Pose<double>> bases;
    for (int s = 0; s < estimate_.parameters.num_stations(); ++s)
      bases.push_back(estimate_.parameters.BaseInStation(s));
    return bases;
  }

  // Of an observation, base frame.
  double PlaceOf(int i, int axis, const std::vector<Pose<double>>& bases) const {
    const Pose<double>& base = bases[ShotOf(i).station];
    return base.rotation.col(axis).dot(problem_.data().observations[i].point_in_station - base.translation);
  }

  // Mean over the rows of each configuration.
  template <typename Number>
  std::vector<double> MeanOf(const Number& number) const {
    std::vector<double> sum(num_clusters_, 0.0);
    for (size_t k = 0; k < rows_.size(); ++k) sum[clusters_[k]] += number(rows_[k]);
    for (int c = 0; c < num_clusters_; ++c) sum[c] /= rows_of_cluster_[c];
    return sum;
  }

  void Add(SplitBy by, const std::string& key, const std::vector<bool>& first) {
    const auto many = static_cast<double>(std::count(first.begin(), first.end(), true));
    const double least = std::max<double>(kFewestOfPart, kSmallestPart * num_clusters_);
    if (std::min(many, num_clusters_ - many) < least) return;
    Split split{by, key, {}, {}};
    for (size_t k = 0; k < rows_.size(); ++k) {
      (first[clusters_[k]] ? split.first : split.second).push_back(static_cast<int>(k));
    }
    splits_.push_back(std::move(split));
  }

  void AddRandom(std::mt19937_64* random) {
    std::vector<int> order(num_clusters_);
    std::iota(order.begin(), order.end(), 0);
    for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[(*random)() % i]);
    std::vector<bool> first(num_clusters_, false);
    for (int i = 0; i < num_clusters_ / 2; ++i) first[order[i]] = true;
    Add(SplitBy::kRandom, "", first);
  }

  void AddMedian(SplitBy by, const std::string& key, const std::vector<double>& value) {
    if (value.empty() || std::all_of(value.begin(), value.end(), [&](double v) { return v == value[0]; })) return;
    // The gap nearest to the middle, so that a grid's planes stay whole.
    const size_t middle = value.size() / 2;
    std::vector<double> sorted = value;  // as far as the middle's place asks for
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<long>(middle), sorted.end());
    double limit = sorted[middle], next = std::numeric_limits<double>::infinity();
    size_t below = 0, above = 0;  // how many are smaller; how many are not larger
    for (const double number : value) {
      below += number < limit ? 1 : 0;
      above += number <= limit ? 1 : 0;
      if (number > limit) next = std::min(next, number);
    }
    if (above < value.size() && above - middle < middle - below) limit = next;
    std::vector<bool> first;
    for (const double number : value) first.push_back(number < limit);
    Add(by, key, first);
  }

  void AddJoint(int j) {
    const std::vector<double> q =
        MeanOf([&](int i) { return problem_.data().ConfigurationOf(problem_.data().observations[i]).q[j]; });
    if (q.empty() || *std::max_element(q.begin(), q.end()) - *std::min_element(q.begin(), q.end()) < kDividesNothing)
      return;
    AddMedian(SplitBy::kRegion, problem_.robot().chain.joints[j].name, q);
  }

  // Series: stations that share no configuration; else their rows share the robot's error there.
  void AddStations() {
    const auto n = problem_.data().stations.size();
    std::vector<Clusters> seen(n, Clusters(static_cast<size_t>(num_clusters_), 0));
    for (size_t k = 0; k < rows_.size(); ++k) seen[ShotOf(rows_[k]).station][clusters_[k]] = 1;
    for (size_t a = 0; a < n; ++a) {
      for (size_t b = a + 1; b < n && n <= kMostPairs; ++b) {
        AddRows(SplitBy::kStation, problem_.data().stations[a] + " and " + problem_.data().stations[b], seen[a],
                seen[b]);
      }
      if (n <= kMostPairs) continue;
      Clusters rest(static_cast<size_t>(num_clusters_), 0);
      for (size_t b = 0; b < n; ++b) {
        for (size_t c = 0; b != a && c < rest.size(); ++c) rest[c] |= seen[b][c];
      }
      AddRows(SplitBy::kStation, problem_.data().stations[a] + " and the others", seen[a], rest);
    }
  }

  void AddRows(SplitBy by, const std::string& key, const Clusters& a, const Clusters& b) {
    if (std::min(std::count(a.begin(), a.end(), 1), std::count(b.begin(), b.end(), 1)) < kFewestOfPart) return;
    for (size_t c = 0; c < a.size(); ++c) {
      if (a[c] != 0 && b[c] != 0) return;
    }
    Split split{by, key, {}, {}};
    for (size_t k = 0; k < rows_.size(); ++k) {
      if (a[clusters_[k]] != 0) split.first.push_back(static_cast<int>(k));
      if (b[clusters_[k]] != 0) split.second.push_back(static_cast<int>(k));
    }
    splits_.push_back(std::move(split));
  }

  // Time counts from each station's first row.
  void AddTime() {
    if (rows_.empty() || problem_.data().stations.size() > 1) return;
    if (!std::all_of(rows_.begin(), rows_.end(), [&](int i) { return ShotOf(i).has_time; })) return;
    AddMedian(SplitBy::kTime, "", MeanOf([&](int i) { return ShotOf(i).time; }));
  }

  const CalibrationProblem& problem_;
  const Estimate& estimate_;
  const std::vector<int>& clusters_;
  std::vector<int> rows_;
  int num_clusters_ = 0;
  std::vector<int> rows_of_cluster_;
  std::vector<Split> splits_;
};

}  // namespace

std::vector<Split> MakeSplits(const CalibrationProblem& problem, const Estimate& estimate,
                              const std::vector<int>& clusters, unsigned long long seed, int random_halves) {
  return Splitter(problem, estimate, clusters).All(seed, random_halves);
}

}  // namespace sagitta
