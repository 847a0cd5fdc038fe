#include "estimator/planning/route.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include "estimator/statistics/shuffle.h"

namespace sagitta {
namespace {

Eigen::VectorXd RangesOf(const std::vector<Eigen::VectorXd>& q) {
  Eigen::VectorXd low = q.front(), high = q.front();
  for (const Eigen::VectorXd& pose : q) {
    low = low.cwiseMin(pose);
    high = high.cwiseMax(pose);
  }
  return (high - low).cwiseMax(1e-12);
}

// All joints start and stop together: the time is that of the one with the largest share of its range to go.
double Way(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& ranges) {
  return (a - b).cwiseAbs().cwiseQuotient(ranges).maxCoeff();
}

class Route {
 public:
  Route(const std::vector<Eigen::VectorXd>& q, const Eigen::VectorXd& ranges, std::vector<int> poses)
      : q_(q), ranges_(ranges), order_(std::move(poses)) {}

  // Nearest neighbours, from the place where the arm is.
  void Grow(const Eigen::VectorXd& from) {
    const Eigen::VectorXd* here = &from;
    for (size_t k = 0; k < order_.size(); ++k) {
      const auto nearest = std::min_element(order_.begin() + k, order_.end(), [&](int a, int b) {
        return Way(q_[a], *here, ranges_) < Way(q_[b], *here, ranges_);
      });
      std::iter_swap(order_.begin() + k, nearest);
      here = &q_[order_[k]];
    }
  }

  void Improve() {
    constexpr int kRounds = 50;  // a guard: each shortens the way, and one that does not is the last
    for (int round = 0; round < kRounds; ++round) {
      if (!Reverse() && !Shift()) break;
    }
  }

  const std::vector<int>& order() const { return order_; }

 private:
  double Link(int a, int b) const {  // places in the order; beyond the ends nothing is travelled
    if (a < 0 || b >= static_cast<int>(order_.size())) return 0.0;
    return Way(q_[order_[a]], q_[order_[b]], ranges_);
  }

  bool Reverse() {
    const int n = static_cast<int>(order_.size());
    bool better = false;
    for (int i = 0; i < n; ++i) {
      for (int k = i + 1; k < n; ++k) {
        // 2-opt: turning the piece i..k round changes its two ends only.
        const double now = Link(i - 1, i) + Link(k, k + 1);
        const double then = (i > 0 ? Link(i - 1, k) : 0.0) + (k + 1 < n ? Link(i, k + 1) : 0.0);
        if (then >= now - 1e-12) continue;
        std::reverse(order_.begin() + i, order_.begin() + k + 1);
        better = true;
      }
    }
    return better;
  }

  double Length() const {
    double length = 0.0;
    for (int k = 0; k + 1 < static_cast<int>(order_.size()); ++k) length += Link(k, k + 1);
    return length;
  }

  bool Shift() {
    const int n = static_cast<int>(order_.size());
    double length = Length();
    bool better = false;
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < n; ++k) {
        std::vector<int> before = order_;
        const int pose = order_[i];
        order_.erase(order_.begin() + i);
        order_.insert(order_.begin() + k, pose);
        const double trial = Length();
        if (trial < length - 1e-12) {
          length = trial;
          better = true;
        } else {
          order_ = std::move(before);
        }
      }
      if (n > 150) break;  // n^3: of long routes the reversals must do
    }
    return better;
  }

  const std::vector<Eigen::VectorXd>& q_;
  const Eigen::VectorXd& ranges_;
  std::vector<int> order_;
};

}  // namespace

std::vector<int> ShortRoute(const std::vector<Eigen::VectorXd>& q, const std::vector<int>& kind) {
  std::vector<int> order;
  if (q.empty()) return order;
  const Eigen::VectorXd ranges = RangesOf(q);
  Eigen::VectorXd here = Eigen::VectorXd::Zero(q.front().size());
  for (const Eigen::VectorXd& pose : q) here += pose / static_cast<double>(q.size());
  const int kinds = *std::max_element(kind.begin(), kind.end()) + 1;
  for (int k = 0; k < kinds; ++k) {
    std::vector<int> own;
    for (size_t i = 0; i < q.size(); ++i) {
      if (kind[i] == k) own.push_back(static_cast<int>(i));
    }
    if (own.empty()) continue;
    Route route(q, ranges, own);
    route.Grow(here);
    route.Improve();
    order.insert(order.end(), route.order().begin(), route.order().end());
    here = q[order.back()];
  }
  return order;
}

std::vector<int> MixedRoute(int poses, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<int> order(poses);
  std::iota(order.begin(), order.end(), 0);
  Shuffle(&order, &random);
  return order;
}

double TravelOf(const std::vector<Eigen::VectorXd>& q, const std::vector<int>& order) {
  if (q.empty()) return 0.0;
  const Eigen::VectorXd ranges = RangesOf(q);
  double travel = 0.0;
  for (size_t k = 0; k + 1 < order.size(); ++k) travel += Way(q[order[k]], q[order[k + 1]], ranges);
  return travel;
}

}  // namespace sagitta
