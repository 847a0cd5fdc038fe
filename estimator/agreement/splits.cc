#include "estimator/agreement/splits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "estimator/statistics/shuffle.h"

namespace sagitta {
namespace {

// rad or m: a joint that covers less divides nothing; about the degree below which it has not moved (data_lint.cc).
constexpr double kDividesNothing = 0.02;
// Of the configurations: a quarter and the rest differ by 1 / sqrt(3/4) = 1.15 times what halves differ by.
constexpr double kSmallestPart = 0.25;
// Stations that are compared two by two; more: each against the others, so that there are no more than six.
constexpr size_t kMostPairs = 4;

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
    AddRegions();
    AddStations();
    AddTime();
    AddMarkers();
    AddLoads();
    return std::move(splits_);
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

  // Means over the rows of each configuration, a column for each of `numbers`. add(row, column): adds the numbers of an
  // observation to those of its configuration.
  template <typename Add>
  Eigen::MatrixXd MeansOf(int numbers, const Add& add) const {
    Eigen::MatrixXd means = Eigen::MatrixXd::Zero(numbers, num_clusters_);
    for (size_t k = 0; k < rows_.size(); ++k) add(rows_[k], means.col(clusters_[k]));
    for (int c = 0; c < num_clusters_; ++c) means.col(c) /= rows_of_cluster_[c];
    return means.transpose();
  }

  void Add(SplitBy by, const std::string& key, const Clusters& first) {
    const auto many = static_cast<double>(std::count(first.begin(), first.end(), 1));
    const double least = std::max<double>(kFewestOfPart, kSmallestPart * num_clusters_);
    if (std::min(many, num_clusters_ - many) < least) return;
    Split split{by, key, {}, {}};
    TakeRows(first, 1, &split.first);
    TakeRows(first, 0, &split.second);
    splits_.push_back(std::move(split));
  }

  // Positions of the rows whose clusters are marked by `mark`.
  void TakeRows(const Clusters& of, char mark, std::vector<int>* positions) const {
    positions->resize(rows_.size());
    size_t count = 0;
    for (size_t k = 0; k < rows_.size(); ++k) {
      (*positions)[count] = static_cast<int>(k);
      count += of[clusters_[k]] == mark ? 1 : 0;
    }
    positions->resize(count);
    positions->shrink_to_fit();
  }

  void AddRandom(std::mt19937_64* random) {
    std::vector<int> order(num_clusters_);
    std::iota(order.begin(), order.end(), 0);
    Shuffle(&order, random);
    Clusters first(num_clusters_, 0);
    for (int i = 0; i < num_clusters_ / 2; ++i) first[order[i]] = 1;
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
    Clusters first;
    first.reserve(value.size());
    for (const double number : value) first.push_back(number < limit ? 1 : 0);
    Add(by, key, first);
  }

  // By each joint, and by where the points are along each axis of the base.
  void AddRegions() {
    const Measurements& data = problem_.data();
    const int joints = problem_.robot().num_joints();
    const std::vector<Pose<double>> bases = Bases();
    const Eigen::MatrixXd means = MeansOf(joints + 3, [&](int i, Eigen::Ref<Eigen::VectorXd> sum) {
      const Shot& shot = ShotOf(i);
      const Pose<double>& base = bases[shot.station];
      sum.head(joints) += data.configurations[shot.configuration].q;
      const Vector3<double> from_base = data.observations[i].point_in_station - base.translation;
      for (int axis = 0; axis < 3; ++axis) sum[joints + axis] += base.rotation.col(axis).dot(from_base);
    });
    for (int c = 0; c < joints + 3 && means.rows() > 0; ++c) {
      const bool is_joint = c < joints;
      if (is_joint && means.col(c).maxCoeff() - means.col(c).minCoeff() < kDividesNothing) continue;
      const std::string name = is_joint ? problem_.robot().chain.joints[c].name : std::string(1, "xyz"[c - joints]);
      AddMedian(SplitBy::kRegion, name, {means.col(c).begin(), means.col(c).end()});
    }
  }

  using Groups = std::vector<int>;  // of each row, positions in a list of names

  // Stations, of few of them two by two.
  void AddStations() {
    const std::vector<std::string>& stations = problem_.data().stations;
    Groups groups;
    for (const int i : rows_) groups.push_back(ShotOf(i).station);
    if (stations.size() > kMostPairs) return AddEachAgainstTheOthers(SplitBy::kStation, stations, groups);
    for (size_t a = 0; a < stations.size(); ++a) {
      for (size_t b = a + 1; b < stations.size(); ++b)
        AddRows(SplitBy::kStation, stations[a] + " and " + stations[b], groups, static_cast<int>(a),
                static_cast<int>(b));
    }
  }

  // A mount that gives way is the same in every region and at every time.
  void AddMarkers() {
    Groups groups;
    for (const int i : rows_) groups.push_back(problem_.data().observations[i].marker);
    AddEachAgainstTheOthers(SplitBy::kMarker, problem_.data().markers, groups);
  }

  // A mass that is not what is stated makes other springs of the joints than another load does.
  void AddLoads() {
    std::vector<std::string> loads;
    Groups groups;
    for (const int i : rows_) {
      const std::string& load = ShotOf(i).load;
      if (groups.empty() || load != loads[groups.back()]) {
        groups.push_back(static_cast<int>(std::find(loads.begin(), loads.end(), load) - loads.begin()));
        if (groups.back() == static_cast<int>(loads.size())) loads.push_back(load);
      } else {
        groups.push_back(groups.back());
      }
    }
    AddEachAgainstTheOthers(SplitBy::kLoad, loads, groups);
  }

  static constexpr int kOthers = -1;

  void AddEachAgainstTheOthers(SplitBy by, const std::vector<std::string>& names, const Groups& groups) {
    const size_t count = names.size();
    for (size_t g = 0; g < count && (g == 0 || count > 2); ++g)
      AddRows(by, names[g] + " and " + (count == 2 ? names[1] : "the others"), groups, static_cast<int>(g), kOthers);
  }

  // Rows of one group and of another, or of all others. What the robot does at a pose is common to rows of one
  // configuration, which brings two parts that share it together, so that their rows count as independent. Intervals by
  // whole configurations and marginalised deviations of joints count on that share: no such split there.
  void AddRows(SplitBy by, const std::string& key, const Groups& groups, int first, int second) {
    Split split{by, key, {}, {}};
    std::vector<char> seen(static_cast<size_t>(num_clusters_), 0);  // sides of each configuration, as bits
    std::array<size_t, 2> configurations = {0, 0};
    bool share = false;
    for (size_t k = 0; k < rows_.size(); ++k) {
      const char side = groups[k] == first ? 1 : groups[k] == second || second == kOthers ? 2 : 0;
      if (side == 0) continue;
      (side == 1 ? split.first : split.second).push_back(static_cast<int>(k));
      char& sides = seen[clusters_[k]];
      if ((sides & side) == 0) ++configurations[side - 1];
      sides |= side;
      share = share || sides == 3;
    }
    if (std::min(configurations[0], configurations[1]) < kFewestOfPart) return;
    if (share && (estimate_.intervals.is_empirical() || !problem_.latent.empty())) return;
    splits_.push_back(std::move(split));
  }

  // Time counts from each station's first row.
  void AddTime() {
    if (rows_.empty() || problem_.data().stations.size() > 1) return;
    if (!std::all_of(rows_.begin(), rows_.end(), [&](int i) { return ShotOf(i).has_time; })) return;
    const Eigen::MatrixXd means = MeansOf(1, [&](int i, Eigen::Ref<Eigen::VectorXd> sum) { sum[0] += ShotOf(i).time; });
    AddMedian(SplitBy::kTime, "", {means.data(), means.data() + means.size()});
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
