// The two steps of the papers as printed, for the baselines of two_step.h.
#pragma once

#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// What the alternation carries from step to step. The literal base I + [r] is no
// rotation, so it stands beside the parameters.
struct StepState {
  ParameterSet parameters;
  std::vector<Pose<double>> bases;  // base_in_station as the steps use it
};

struct StepContext {
  const CalibrationProblem& problem;
  std::vector<int> observations;
  NoiseRoots noise;
  std::vector<int> base_and_markers;  // coordinates of step 1
  std::vector<int> geometry;          // coordinates of step 2

  const Observation& observation(size_t k) const { return problem.data().observations[observations[k]]; }
  const Shot& shot(size_t k) const { return problem.data().shots[observation(k).shot]; }
};

// Least squares |a x - b| with column scaling; false when the columns are dependent.
bool SolveScaled(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd* x);

// Eq. (9)-(16) about identity. False when singular or an equilibrium diverges, as
// below.
bool LiteralStepOne(const StepContext& context, StepState* state);

// The same equations on the points pulled back through the current base.
bool RelinearisedStepOne(const StepContext& context, StepState* state);

// Eq. (17)-(20): linear in the geometric errors about their current values, with
// base I + [r] and markers as step 1 left them.
bool LiteralStepTwo(const StepContext& context, StepState* state);

}  // namespace sagitta
