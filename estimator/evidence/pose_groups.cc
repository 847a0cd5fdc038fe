#include "estimator/evidence/pose_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "estimator/evidence/nameless_cause.h"
#include "estimator/statistics/shuffle.h"

namespace sagitta {
namespace {

constexpr unsigned kSeedOfGroups = 1, kSeedOfResamples = 2;
// What may replace a member, or be one more, is asked for where it is among the first of all: so many names in each
// place, so many explanations in addition to the set. With forty in each place the same kinds of effect have 0.9 and
// more on the UR10's series D.
constexpr size_t kInPlace = 6;
constexpr size_t kFurther = 20;
// Of all that is asked: the sums of the groups are 360 MB then. The UR5 and the UR10 stay below it.
constexpr size_t kMostColumns = 1500;
// Log units: a twentieth of the best moves an average of eleven by half a percent.
constexpr double kWorthSharing = 3.0;

// Explanations that may have a place on some poses, ascending.
std::vector<int> WorthAsking(const Evidence& evidence, const WeightedModel& leading,
                             const std::vector<std::vector<NamedProbability>>& in_places) {
  std::set<int> asked(leading.set.members.begin(), leading.set.members.end());
  const auto columns_of = [&](int k) { return evidence.list().math[k].group.columns.size(); };
  size_t columns = 0;
  for (const int m : asked) columns += columns_of(m);
  const auto ask = [&](int one) {
    for (const int k : {evidence.list().math[one].needs, one}) {
      if (k != kNoExplanation && columns + columns_of(k) <= kMostColumns && asked.insert(k).second)
        columns += columns_of(k);
    }
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
  std::partial_sort(further.begin(), end, further.end(), [&](int a, int b) { return weights[a] > weights[b]; });
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

// What shares the probability by these sums, the most probable set read as so many causes and as one without a name,
// too; probabilities sum to 1. Of explanations that are the same on all poses none wins on every resample.
std::vector<WeightedModel> ModelsBy(const Evidence& evidence, const PoseGroups& groups, const ProjectedNormal& normal,
                                    NamelessCauses* causes) {
  SetSearch search = evidence.SearchAmong(groups.explanations(), normal);
  search.ClimbFrom();
  std::vector<WeightedModel> models;
  for (const WeightedSet& set : search.Met(kWorthSharing)) {
    models.push_back({groups.view(), set, 1.0, set.log_weight - search.Best().log_weight});
    for (int& m : models.back().set.members) m = groups.asked()[m];
  }
  WeightedModel as_one = models.front();
  const auto one = causes->ReadAsOne(as_one.set.members, search.Best(), groups.explanations(), normal,
                                     evidence.Likelihood(normal.dof));
  if (one) {
    as_one.pieces = one->pieces;
    as_one.log_weight = one->gain;
    models.push_back(as_one);
  }
  Normalise(&models);
  return models;
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
  std::vector<int> times(groups_.size(), 0);
  for (size_t draw = 0; draw < groups_.size(); ++draw) ++times[(*random)() % groups_.size()];
  RowSums sums = RowSums::Zero(all_.rows());
  for (size_t g = 0; g < groups_.size(); ++g) {
    if (times[g] > 0) sums.AddUpper(groups_[g], times[g]);
  }
  return evidence_.columns().Project(sums);
}

long SetCoefficients::size() const {
  return std::accumulate(groups.begin(), groups.end(), believed,
                         [](long sum, const ColumnGroup* group) { return sum + group->size(); });
}

Eigen::MatrixXd SetCoefficients::Of(const Eigen::MatrixXd& rows) const {
  Eigen::MatrixXd mixed(size(), rows.cols());
  mixed.topRows(believed) = rows.topRows(believed);
  const auto of_columns = rows.bottomRows(rows.rows() - believed);
  long first = believed;
  for (size_t k = 0; k < groups.size(); ++k) {
    mixed.middleRows(first, groups[k]->size()) =
        groups[k]->Mixed(scales[k] * of_columns(groups[k]->columns, Eigen::all));
    first += groups[k]->size();
  }
  return mixed;
}

Eigen::MatrixXd SetCoefficients::NormalOf(const Eigen::MatrixXd& products) const {
  const Eigen::MatrixXd half = Of(products);
  Eigen::MatrixXd normal(size(), size() + 1);
  normal << Of(half.leftCols(half.cols() - 1).transpose()), half.rightCols(1);
  return normal;
}

// With P the products of a group, N those of all rows and S the prior of what the set adds,
//
//   x = -(N - P + S)_xx^-1 (N - P)_xr,   P_rr + 2 x'P_xr + x'P_xx x
Eigen::VectorXd PoseGroups::ErrorsLeftOut(const WeightedSet& set) const {
  SetCoefficients own{{}, set.scales, evidence_.columns().num_believed()};
  for (const int m : set.members) own.groups.push_back(&few_.explanations[PlaceIn(asked_, m)].group);
  const Eigen::MatrixXd all = own.NormalOf(all_);
  Eigen::VectorXd errors(groups_.size());
  for (size_t g = 0; g < groups_.size(); ++g) {
    const Eigen::MatrixXd out = own.NormalOf(groups_[g].products), others = all - out;
    Eigen::MatrixXd normal = others.leftCols(own.size());
    own.AddPrior(&normal);
    const Eigen::VectorXd x = -normal.ldlt().solve(others.col(own.size()));
    const double square = groups_[g].products(all_.rows() - 1, all_.cols() - 1);
    errors[g] = square + x.dot(2.0 * out.col(own.size()) + out.leftCols(own.size()) * x);
  }
  return errors;
}

std::vector<WeightedModel> BaggedModels(const Evidence& evidence, const WeightedModel& leading,
                                        const PoseGroups& groups) {
  std::vector<WeightedModel> models = evidence.models();
  if (leading.set.members.empty() || groups.HasFewPoses()) return models;
  NamelessCauses causes(evidence.robot(), evidence.list(), evidence.masses().further);
  std::mt19937 random(kSeedOfResamples);
  for (int resample = 0; resample < kResamples; ++resample) {
    const GivenBelieved sums = groups.Resample(&random);
    for (const WeightedModel& model : ModelsBy(evidence, groups, sums.normal, &causes)) models.push_back(model);
  }
  for (WeightedModel& model : models) model.log_weight = std::log(model.probability);
  Normalise(&models);
  return models;
}

}  // namespace sagitta
