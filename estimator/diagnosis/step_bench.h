// One model with all its steps, linearized once, for questions about each of them: what is left where one step is taken
// out again, on all configurations or on a half of them. Taken out means: its contribution (columns times values) gone
// from the residual, its columns no longer believed, everything else estimated again, all to first order.
#pragma once

#include <vector>

#include "estimator/diagnosis/candidate_bench.h"
#include "estimator/diagnosis/selection.h"

namespace sagitta {

constexpr double kOverlapOfRivals = 0.2;  // of what a step explains; below, another effect explains something else

// All rows, or those of some configurations.
struct BenchPart {
  std::vector<int> rows;  // of the whole
  CandidateBench candidates;
  Linearization believed;  // with all steps
};

// The model without one step.
struct WithoutStep {
  ProjectedResidual residual;  // beside everything else
  Eigen::MatrixXd own;         // columns of the step that the data can tell
  bool has_spring = false;     // a compensator is left in it
};

class StepBench {
 public:
  StepBench(const DiagnosedModel& with, const std::vector<Candidate>& candidates);

  const DiagnosedModel& model() const { return with_; }
  const BenchPart& whole() const { return whole_; }
  BenchPart PartOfRows(std::vector<int> rows) const;
  // The step's contribution to the whitened rows: its columns times its values (neutral: 0). The torque of a
  // compensator is proportional to its rate.
  Eigen::VectorXd Contribution(const ChosenStep& step) const;
  // Whitened residual of all rows with the step's parameters neutral.
  Eigen::VectorXd NeutralResidual(const ChosenStep& step) const {
    return whole_.believed.residual - Contribution(step);
  }
  WithoutStep Without(const ChosenStep& step, const Eigen::VectorXd& neutral_residual, const BenchPart& part) const;
  // Columns of `believed` that are the step's own and that the data can tell; those that are not its own.
  std::vector<int> OwnColumns(const ChosenStep& step) const;
  std::vector<int> OtherColumns(const ChosenStep& step) const;

 private:
  const std::string& NameOf(int column) const;

  const DiagnosedModel& with_;
  BenchPart whole_;
};

}  // namespace sagitta
