// The two stages of the papers as printed, for the baselines of two_step.h.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// What the alternation carries from stage to stage. The literal base I + [r] is no
// rotation, so it stands next to the parameters.
struct StageState {
  ParameterSet parameters;
  std::vector<Pose<double>> bases;  // base_in_station as the stages use it
};

struct StageContext {
  const CalibrationProblem& problem;
  std::vector<int> observations;
  NoiseRoots noise;
  std::vector<int> base_and_markers;  // coordinates of stage 1
  std::vector<int> geometry;          // coordinates of stage 2

  const Observation& observation(size_t k) const { return problem.data().observations[observations[k]]; }
  const Shot& shot(size_t k) const { return problem.data().shots[observation(k).shot]; }
};

// Least squares |a x - b| with column scaling; false when the columns are dependent.
bool SolveScaled(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd* x);

// Eq. (9)-(16) about identity. False when singular or an equilibrium diverges, as
// below.
bool LiteralStageOne(const StageContext& context, StageState* state);

// The same equations on the points pulled back through the current base.
bool RelinearisedStageOne(const StageContext& context, StageState* state);

// Eq. (17)-(20): linear in the geometric errors about their current values, with
// base I + [r] and markers as stage 1 left them.
bool LiteralStageTwo(const StageContext& context, StageState* state);

// The reason why there is no estimate, or why it ends here.
void Stop(Status status, const std::string& message, Estimate* estimate);

}  // namespace sagitta
