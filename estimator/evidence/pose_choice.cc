#include "estimator/evidence/pose_choice.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "estimator/statistics/mutual_information.h"

namespace sagitta {
namespace {

constexpr size_t kPosesKept = 80;  // asked again after each choice

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
  for (const RivalRows& rival : rivals_) own_.push_back(OwnOf(rival.spread));
}

// Blocks of Y'Y / 2 of each pose's rows, side by side.
Eigen::MatrixXd PoseChoice::OwnOf(const Eigen::MatrixXd& spread) const {
  long most = 0;
  for (const size_t pose : asked_) most = std::max(most, RowsOf(pose).size);
  Eigen::MatrixXd own(most, spread.cols());
  for (const size_t pose : asked_) {
    const Block rows = RowsOf(pose);
    const auto of_pose = spread.middleCols(rows.first, rows.size);
    own.block(0, rows.first, rows.size, rows.size) = 0.5 * of_pose.transpose() * of_pose;
  }
  return own;
}

std::vector<long> PoseChoice::RowsOf(const std::vector<size_t>& poses) const {
  std::vector<long> rows;
  for (const size_t pose : poses) {
    for (long row = first_row_[pose]; row < first_row_[pose + 1]; ++row) rows.push_back(row);
  }
  return rows;
}

// With V of the rows chosen (1) and those of one pose (2), V_11 = L L', B = L^-1 V_12, y = L^-1 d_1:
// D = y'y + e' (V_22 - B'B)^-1 e,  e = d_2 - B'y.
std::vector<Eigen::MatrixXd> PoseChoice::ApartWith(const std::vector<size_t>& poses) const {
  const long n = static_cast<long>(rivals_.size());
  const std::vector<long> rows_taken = RowsOf(taken_), rows_asked = RowsOf(poses);
  std::vector<Eigen::MatrixXd> across, taken;  // of each rival, halved
  std::vector<Eigen::VectorXd> means, taken_means;
  for (const RivalRows& rival : rivals_) {
    const Eigen::MatrixXd spread = rival.spread(Eigen::all, rows_taken);
    across.push_back(0.5 * spread.transpose() * rival.spread(Eigen::all, rows_asked).eval());
    taken.push_back(0.5 * spread.transpose() * spread);
    means.push_back(rival.means(rows_asked));
    taken_means.push_back(rival.means(rows_taken));
  }
  std::vector<Eigen::MatrixXd> aparts(poses.size(), Eigen::MatrixXd::Zero(n, n));
  Eigen::MatrixXd left;  // of one pose, as its root: their memory serves all
  Eigen::LLT<Eigen::MatrixXd> root;
  Eigen::VectorXd difference;
  for (size_t i = 0; i < rivals_.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (names_[i] == names_[j]) continue;
      Eigen::MatrixXd known = taken[i] + taken[j];
      known.diagonal().array() += 1.0;
      const Eigen::LLT<Eigen::MatrixXd> factor(known);
      Eigen::MatrixXd shared = across[i] + across[j];
      factor.matrixL().solveInPlace(shared);
      Eigen::VectorXd seen = taken_means[i] - taken_means[j];
      factor.matrixL().solveInPlace(seen);
      const Eigen::VectorXd fresh = means[i] - means[j] - shared.transpose() * seen;
      long at = 0;
      for (size_t k = 0; k < poses.size(); ++k) {
        const Block rows = RowsOf(poses[k]);
        const auto before = shared.middleCols(at, rows.size);
        left = own_[i].block(0, rows.first, rows.size, rows.size) + own_[j].block(0, rows.first, rows.size, rows.size);
        left.diagonal().array() += 1.0;
        left -= before.transpose().lazyProduct(before);
        root.compute(left);
        difference = fresh.segment(at, rows.size);
        root.matrixL().solveInPlace(difference);
        const double apart = seen.squaredNorm() + difference.squaredNorm();
        aparts[k](static_cast<long>(i), static_cast<long>(j)) = apart;
        aparts[k](static_cast<long>(j), static_cast<long>(i)) = apart;
        at += rows.size;
      }
    }
  }
  return aparts;
}

size_t PoseChoice::Take() {
  std::vector<std::pair<double, size_t>> worths;
  const std::vector<Eigen::MatrixXd> aparts = ApartWith(asked_);
  for (size_t k = 0; k < asked_.size(); ++k) {
    worths.emplace_back(-MutualInformation(probabilities_, names_, aparts[k]), asked_[k]);
  }
  std::sort(worths.begin(), worths.end());
  worths.resize(std::min(worths.size(), kPosesKept));
  asked_.clear();
  for (const auto& [worth, pose] : worths) asked_.push_back(pose);
  taken_.push_back(asked_.front());
  asked_.erase(asked_.begin());
  return taken_.back();
}

Eigen::MatrixXd PoseChoice::ApartAfter(double visits) const {
  const long n = static_cast<long>(rivals_.size());
  const std::vector<long> rows = RowsOf(taken_);
  Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(n, n);
  for (long i = 0; i < n; ++i) {
    for (long j = 0; j < i; ++j) {
      if (names_[i] == names_[j]) continue;
      const Eigen::MatrixXd one = rivals_[i].spread(Eigen::all, rows), other = rivals_[j].spread(Eigen::all, rows);
      Eigen::MatrixXd covariance = 0.5 * (one.transpose() * one + other.transpose() * other);
      covariance.diagonal().array() += 1.0 / visits;
      const Eigen::VectorXd difference = rivals_[i].means(rows) - rivals_[j].means(rows);
      apart(i, j) = apart(j, i) = difference.dot(covariance.llt().solve(difference));
    }
  }
  return apart;
}

double PoseChoice::Decides(double visits) const {
  return ExpectedProbability(probabilities_, names_, ApartAfter(visits));
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
