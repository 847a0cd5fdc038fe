#include "estimator/evidence/pose_groups.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "estimator/statistics/shuffle.h"

namespace sagitta {
namespace {

constexpr unsigned kSeedOfGroups = 1;
// What may replace a member, or be one more, is asked for where it is among the first of all: so many names in each
// place, so many explanations in addition to the set. With forty in each place the same kinds of effect have 0.9 and
// more on the UR10's series D.
constexpr size_t kInPlace = 6;
constexpr size_t kFurther = 20;
// Of all that is asked: the sums of the groups are 360 MB then. The UR5 and the UR10 stay below it.
constexpr size_t kMostColumns = 1500;

// Explanations that may have a place on some poses, ascending.
std::vector<int> WorthAsking(const Evidence& evidence, const WeightedModel& leading,
                             const std::vector<std::vector<NamedProbability>>& in_places) {
  std::set<int> asked(leading.set.members.begin(), leading.set.members.end());
  const auto columns_of = [&](int k) { return evidence.list().math[static_cast<size_t>(k)].group.columns.size(); };
  size_t columns = 0;
  for (const int m : asked) columns += columns_of(m);
  const auto ask = [&](int k) {
    if (columns + columns_of(k) <= kMostColumns && asked.insert(k).second) columns += columns_of(k);
  };
  for (size_t r = 0; r < kInPlace; ++r) {
    for (const std::vector<NamedProbability>& rivals : in_places) {
      if (r < rivals.size()) ask(rivals[r].explanation);
    }
  }
  const std::vector<double> weights = evidence.SearchIn(leading.view).Additions(leading.set);
  std::vector<int> further;
  for (size_t k = 0; k < weights.size(); ++k) {
    if (std::isfinite(weights[k])) further.push_back(static_cast<int>(k));
  }
  const auto end = further.begin() + static_cast<long>(std::min(kFurther, further.size()));
  std::partial_sort(further.begin(), end, further.end(),
                    [&](int a, int b) { return weights[static_cast<size_t>(a)] > weights[static_cast<size_t>(b)]; });
  std::for_each(further.begin(), end, ask);
  return {asked.begin(), asked.end()};
}

// At random.
std::vector<int> GroupOfEach(int poses, int groups) {
  std::mt19937 random(kSeedOfGroups);
  std::vector<int> group(static_cast<size_t>(poses));
  for (size_t k = 0; k < group.size(); ++k) group[k] = static_cast<int>(k) % groups;
  Shuffle(&group, &random);
  return group;
}

}  // namespace

PoseGroups::PoseGroups(const Evidence& evidence, const WeightedModel& leading,
                       const std::vector<std::vector<NamedProbability>>& in_places)
    : evidence_(evidence),
      view_(leading.view),
      asked_(WorthAsking(evidence, leading, in_places)),
      few_(WithTheirColumns(evidence.list().math, asked_)) {
  const EvidenceColumns& columns = evidence.columns();
  const int poses = columns.num_poses();
  groups_ = columns.SumEach(evidence.views()[view_].scatter, few_.columns,
                            GroupOfEach(poses, std::min(poses, static_cast<int>(kMost))));
  all_ = groups_[0].products;
  for (size_t g = 1; g < groups_.size(); ++g) all_ += groups_[g].products;
  all_ = columns.WithPriors(std::move(all_));
}

GivenBelieved PoseGroups::Resample(std::mt19937* random) const {
  RowSums sums = RowSums::Zero(all_.rows());
  for (size_t draw = 0; draw < groups_.size(); ++draw) sums += groups_[(*random)() % groups_.size()];
  return evidence_.columns().Project(sums);
}

PoseGroups::SetColumns PoseGroups::ColumnsOf(const WeightedSet& set) const {
  const long believed = evidence_.columns().num_believed();
  SetColumns own;
  own.columns.resize(static_cast<size_t>(believed));
  std::iota(own.columns.begin(), own.columns.end(), 0L);
  std::vector<const ColumnGroup*> groups;
  long size = believed;
  for (const int m : set.members) {
    const auto place = std::lower_bound(asked_.begin(), asked_.end(), m) - asked_.begin();
    groups.push_back(&few_.explanations[static_cast<size_t>(place)].group);
    for (const int column : groups.back()->columns) own.columns.push_back(believed + column);
    size += groups.back()->size();
  }
  own.columns.push_back(all_.cols() - 1);
  own.mixing = Eigen::MatrixXd::Zero(static_cast<long>(own.columns.size()), size + 1);
  own.mixing.topLeftCorner(believed, believed).setIdentity();
  own.mixing.bottomRightCorner(1, 1).setOnes();
  own.prior = Eigen::VectorXd::Zero(size);
  long row = believed, first = believed;
  for (size_t k = 0; k < groups.size(); ++k) {
    const long height = static_cast<long>(groups[k]->columns.size()), width = groups[k]->size();
    own.mixing.block(row, first, height, width) =
        groups[k]->Mixed(Eigen::MatrixXd::Identity(height, height)).transpose();
    own.prior.segment(first, width).setConstant(1.0 / (set.scales[k] * set.scales[k]));
    row += height;
    first += width;
  }
  return own;
}

// With P the products of a group, N those of all rows and S the prior of what the set adds,
//
//   x = -(N - P + S)_xx^-1 (N - P)_xr,   P_rr + 2 x'P_xr + x'P_xx x
Eigen::VectorXd PoseGroups::ErrorsLeftOut(const WeightedSet& set) const {
  const SetColumns own = ColumnsOf(set);
  const long size = own.prior.size();
  const auto of_set = [&](const Eigen::MatrixXd& products) {
    return Eigen::MatrixXd(own.mixing.transpose() * products(own.columns, own.columns) * own.mixing);
  };
  const Eigen::MatrixXd all = of_set(all_);
  Eigen::VectorXd errors(static_cast<long>(groups_.size()));
  for (size_t g = 0; g < groups_.size(); ++g) {
    const Eigen::MatrixXd out = of_set(groups_[g].products), others = all - out;
    Eigen::MatrixXd normal = others.topLeftCorner(size, size);
    normal.diagonal() += own.prior;
    const Eigen::VectorXd x = -normal.ldlt().solve(others.col(size).head(size));
    errors[static_cast<long>(g)] =
        out(size, size) + x.dot(2.0 * out.col(size).head(size) + out.topLeftCorner(size, size) * x);
  }
  return errors;
}

}  // namespace sagitta
