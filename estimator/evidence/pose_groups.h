// Sums of the rows over groups of poses, for what may have a place in a set: each group is summed once, and every
// resample of the poses and all poses without some are sums of these.
#pragma once

#include <random>
#include <vector>

#include "estimator/evidence/posterior.h"

namespace sagitta {

// What a set adds to the believed: coefficients of unit prior behind those, by rows (products) that are for [believed,
// columns, more]. groups: within the columns.
struct SetCoefficients {
  std::vector<const ColumnGroup*> groups;
  std::vector<double> scales;
  long believed = 0;

  long size() const;  // the believed included
  // Rows for [believed, coefficients].
  Eigen::MatrixXd Of(const Eigen::MatrixXd& rows) const;
  // Of products of [believed, columns, residual]: those of [believed, coefficients] with themselves and the residual,
  // without the prior.
  Eigen::MatrixXd NormalOf(const Eigen::MatrixXd& products) const;
  void AddPrior(Eigen::MatrixXd* normal) const { normal->diagonal().tail(size() - believed).array() += 1.0; }
};

class PoseGroups {
 public:
  // In the leading model's view, of the members of its set, of what may replace one of them and of what may be added
  // to them. in_places: InPlaces of the leading model.
  PoseGroups(const Evidence& evidence, const WeightedModel& leading,
             const std::vector<std::vector<NamedProbability>>& in_places);

  bool HasFewPoses() const { return groups_.size() < kMost; }  // fewer than groups
  int view() const { return view_; }
  // Explanations that are asked for, ascending, and these by themselves: columns count among those.
  const std::vector<int>& asked() const { return asked_; }
  const std::vector<Explanation>& explanations() const { return few_.explanations; }

  // As many groups as there are, drawn with replacement.
  GivenBelieved Resample(std::mt19937* random) const;
  // Squared residuals, whitened, that a set leaves on each group when it is fitted to the others. members: all asked.
  Eigen::VectorXd ErrorsLeftOut(const WeightedSet& set) const;

 private:
  // Groups: from their scatter a standard deviation is known to 1 / sqrt(2 20) = 16 %; sums of more need more memory.
  static constexpr size_t kMost = 20;

  const Evidence& evidence_;
  const int view_;
  const std::vector<int> asked_;
  const FewExplanations few_;
  std::vector<RowSums> groups_;  // of [believed, columns, residual]
  Eigen::MatrixXd all_;          // products of all rows, with the priors of the believed
};

// What is weighed, averaged over resamples of the poses.
//
// A probability assumes that the cause is in the list and that the noise is as said. Given a rest without a name that
// is known to be wrong: of several sums of effects that describe the rest about as well, one is far ahead on these
// poses and another one would be on others. Posteriors that are averaged over bootstrap samples (bagged) say how much
// of that is chance, and say the same on other data (Huggins and Miller, Bayesian Analysis 18 (2023) 79; Reproducible
// model selection using bagged posteriors).
//
// The evidence's models, averaged with what shares the probability on each of kResamples resamples in the leading
// model's view; all poses as they are count as one of them. The search begins with nothing on each, among what the
// groups ask for. Where the leading set holds nothing, or poses are too few, these are the evidence's models as they
// are.
std::vector<WeightedModel> BaggedModels(const Evidence& evidence, const WeightedModel& leading,
                                        const PoseGroups& groups);

constexpr int kResamples = 10;  // one moves a probability by 0.09, less than chance does from resample to resample

}  // namespace sagitta
