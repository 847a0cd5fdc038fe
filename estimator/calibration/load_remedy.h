// Which experiment would determine what the loads at hand do not: words for
// directions in which a compliance or the compensator is unidentifiable.
//
// A held coordinate k is determined by further rows with the derivatives b (by k) and
// A (by what is estimated, covariance C so far) to
//
//   1 / sigma_k^2 = i0 + b~' (I + A C A' + L L')^-1 b~,   b~ = b - A w
//
// in whitened units: w = C J'J_k is how the others follow k in the data at hand,
// i0 what those determine of k already, L the joints' repeatability at a new visit.
// The rows are those of the data's own markers in the data's own configurations
// under a sideways pull (or the load at hand, displaced): candidates are added
// one by one, the most informative first.
#pragma once

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// One experiment proposed and what it would determine.
struct LoadPlan {
  std::vector<std::string> configurations;  // ids
  std::vector<AppliedWrench> wrenches;      // one per configuration
  double sigma = 0.0;                       // of the held coordinate afterwards, SI; infinity: determines nothing
};

// Sideways pulls of `force` (N) at the load point in `count` of the data's own
// configurations. `held`: a coordinate that the estimate holds.
LoadPlan PlanPulls(const CalibrationProblem& problem, const Estimate& estimate, int held, double force, int count = 3);

// Fills Direction::remedy of the unidentifiable directions that a load (or a
// measurement of the spring) would determine. The estimate must have been judged.
void AddLoadRemedies(const CalibrationProblem& problem, Estimate* estimate);

// "load 'V250' at configuration 'C3' (loads.csv:12)": the first shot whose
// deflections find no equilibrium at `parameters`; "" if all do.
std::string FoldedShot(const CalibrationProblem& problem, const ParameterSet& parameters);

// That shot in a sentence, with what to check.
std::string FoldedInWords(const CalibrationProblem& problem, const ParameterSet& parameters);

}  // namespace sagitta
