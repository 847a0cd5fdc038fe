#include "estimator/evidence/pose_choice.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "estimator/statistics/mutual_information.h"

namespace sagitta {
namespace {

// The best ones by themselves, asked again after each choice: a fifth of those weighed, which bounds the time.
constexpr size_t kPosesKept = 80;

}  // namespace

PoseChoice::PoseChoice(std::vector<RivalRows> rivals, std::vector<long> first_row)
    : rivals_(std::move(rivals)), first_row_(std::move(first_row)) {
  CHECK_GE(first_row_.size(), 2u);
  probabilities_.resize(static_cast<long>(rivals_.size()));
  for (size_t i = 0; i < rivals_.size(); ++i) {
    probabilities_[i] = rivals_[i].probability;
    names_.push_back(rivals_[i].name);
  }
  asked_.resize(first_row_.size() - 1);
  std::iota(asked_.begin(), asked_.end(), size_t{0});
}

Eigen::MatrixXd PoseChoice::Apart(const std::vector<size_t>& poses, double visits) const {
  std::vector<long> rows;
  for (const size_t pose : poses) {
    for (long row = first_row_[pose]; row < first_row_[pose + 1]; ++row) rows.push_back(row);
  }
  std::vector<Eigen::MatrixXd> halves;  // Y'Y / 2 of each rival
  for (const RivalRows& rival : rivals_) {
    const Eigen::MatrixXd spread = rival.spread(Eigen::all, rows);
    halves.emplace_back(0.5 * spread.transpose() * spread);
  }
  const long n = static_cast<long>(rivals_.size());
  Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(n, n);
  for (long i = 0; i < n; ++i) {
    for (long j = 0; j < i; ++j) {
      if (names_[i] == names_[j]) continue;
      Eigen::MatrixXd covariance = halves[i] + halves[j];
      covariance.diagonal().array() += 1.0 / visits;
      const Eigen::VectorXd difference = rivals_[i].means(rows) - rivals_[j].means(rows);
      apart(i, j) = apart(j, i) = difference.dot(covariance.llt().solve(difference));
    }
  }
  return apart;
}

size_t PoseChoice::Take() {
  std::vector<std::pair<double, size_t>> worths;
  std::vector<size_t> with = taken_;
  with.push_back(0);
  for (const size_t pose : asked_) {
    with.back() = pose;
    worths.emplace_back(-MutualInformation(probabilities_, names_, Apart(with, 1.0)), pose);
  }
  std::sort(worths.begin(), worths.end());
  worths.resize(std::min(worths.size(), kPosesKept));
  asked_.clear();
  for (const auto& [worth, pose] : worths) asked_.push_back(pose);
  taken_.push_back(asked_.front());
  asked_.erase(asked_.begin());
  return taken_.back();
}

double PoseChoice::Decides(double visits) const {
  return ExpectedProbability(probabilities_, names_, Apart(taken_, visits));
}

int PoseChoice::Needed(double wanted, int most) const {
  const double poses = static_cast<double>(taken_.size());
  if (Decides(most / poses) < wanted) return 0;
  int low = 0, high = most;  // too few, enough
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (Decides(middle / poses) < wanted ? low : high) = middle;
  }
  return high;
}

}  // namespace sagitta
