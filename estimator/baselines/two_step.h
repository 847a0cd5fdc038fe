// The two-step identification of papers 000 and 002, as a comparison: base and
// markers with the geometry held, then the geometry with base and markers held,
// and again. Three variants of the same alternation:
//
//   literal       paper 000 eq. (9)-(16) and (17)-(20) as printed, defects kept:
//                 * eq. (11) writes R_robot (R_base p_tool) where eq. (8) has
//                   R_base R_robot p_tool: the two rotations are commuted,
//                 * hence the r_base column is [p_robot]^T and lacks the tool's
//                   lever arm, [p_robot + R_robot p_tool]^T,
//                 * R_base = I + [r], eq. (9), about identity, never relinearised.
//                 Its fixed point is biased, the more the larger the base rotation.
//   relinearised  the literal stage 1 on data pulled back through the current base,
//                 R_base^T (p - p_base): r_base tends to zero, the estimate is
//                 consistent, but the wrong Jacobian stops it away from the optimum.
//   exact         the correct Jacobian of each half: block Gauss-Newton. It reaches
//                 the joint optimum at the rate c1^2 (canonical_rate.h).
//
// What the papers leave open, as done here:
// * Rows are whitened by their own sigmas; with equal sigmas that is the papers'
//   unweighted least squares.
// * Several stations: one (p_base, r_base) each in eq. (16), one u_tool per marker
//   for all; p_tool = R_base^T u_tool, eq. (14), is averaged over the stations that
//   see the marker, by number of rows.
// * r_base is stated as rotation vector, R_base = exp([r]), in the result.
// * literal starts from its own stage 1 at nominal geometry; the others from the
//   aligned nominal robot.
// literal and relinearised want every marker on the flange and all of base and
// markers estimated; otherwise they return without having run, and say why. What
// the data do not determine must be held before (RunMethod adopts the joint decision).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

enum class TwoStepVariant { kLiteral, kRelinearised, kExact };

struct TwoStepOptions {
  TwoStepVariant variant = TwoStepVariant::kExact;
  int max_iterations = 2000;  // at a rate of 0.99, slower than any in docs/THEORY.md, 2e-9 is left
  // Stops where the distance left, step * rate / (1 - rate), is below this many
  // standard deviations in every coordinate (1e-6 between two methods asks for less).
  double tolerance = 1e-7;
  std::function<void(const std::string&)> progress;  // may be empty
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const TwoStepOptions& options);

struct TwoStepResult {
  // Intervals come from the joint linearization at the point reached: for literal
  // and relinearised they ignore the bias (a warning says so).
  Estimate estimate;
  std::vector<double> steps;  // per iteration, largest change in standard deviations
  double rate = 0.0;          // measured: ratio of successive steps at the end; NaN: too few iterations
};

TwoStepResult EstimateInTwoSteps(const CalibrationProblem& problem, const TwoStepOptions& options = {});

}  // namespace sagitta
