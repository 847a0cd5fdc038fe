// Sums of the rows over groups of poses, for what may have a place in a set: each group is summed once, and every
// resample of the poses and all poses without some are sums of these.
#pragma once

#include <random>
#include <vector>

#include "estimator/evidence/posterior.h"

namespace sagitta {

class PoseGroups {
 public:
  // In the leading model's view, of the members of its set, of what may replace one of them and of what may be added
  // to them. in_places: InPlaces of the leading model.
  PoseGroups(const Evidence& evidence, const WeightedModel& leading,
             const std::vector<std::vector<NamedProbability>>& in_places);

  bool HasOnePoseEach() const { return groups_.size() < kMost; }  // poses are too few to be drawn in groups
  int view() const { return view_; }
  // Explanations that are asked for, ascending, and these by themselves: columns count among those.
  const std::vector<int>& asked() const { return asked_; }
  const std::vector<Explanation>& explanations() const { return few_.explanations; }

  // As many groups as there are, drawn with replacement.
  GivenBelieved Resample(std::mt19937* random) const;
  // Squared residuals, whitened, that a set leaves on each group when it is fitted to the others. members: all asked.
  Eigen::VectorXd ErrorsLeftOut(const WeightedSet& set) const;

 private:
  static constexpr size_t kMost = 20;

  // Columns of the sums that a set needs, [believed, coefficients, residual] of these, and 1 / variance of the prior of
  // the first two.
  struct SetColumns {
    std::vector<long> columns;
    Eigen::MatrixXd mixing;
    Eigen::VectorXd prior;
  };
  SetColumns ColumnsOf(const WeightedSet& set) const;

  const Evidence& evidence_;
  const int view_;
  const std::vector<int> asked_;
  const FewExplanations few_;
  std::vector<RowSums> groups_;  // of [believed, columns, residual]
  Eigen::MatrixXd all_;          // products of all rows, with the priors of the believed
};

}  // namespace sagitta
