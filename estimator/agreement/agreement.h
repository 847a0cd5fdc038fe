// Intervals say how far an estimate would move if the same experiment were done again. Where the model is not
// perfect there is more: fitted to another region, another series or another day, it would give other values, by more
// than the intervals allow. That shows in the data at hand: parts of the configurations, each fitted alone,
//
//   x_p = x - (J_p' J_p)^-1 J_p' r_p          (one Gauss-Newton step from the estimate)
//
// are independent, so that x_a - x_b has the covariance C_a + C_b. Random halves share every model error: they test the
// noise. Halves by a joint or by the place of the flange, stations, times, and markers and loads (each against the
// others) do not: what their differences have beyond noise is the model's error (between_parts.h).
//
// Both parts hold what either does not determine; priors are left out, the parts would share them. All differences of
// one split at once are tested by Hotelling's F (the model's covariance: the Chow test).
#pragma once

#include "estimator/agreement/between_parts.h"
#include "estimator/estimate/agreement_report.h"
#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/part_sums.h"
#include "estimator/least_squares/row_stream.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct AgreementOptions {
  unsigned long long seed = 1;
  int random_halves = 20;
};

// Fills estimate->agreement of a judged estimate (with its intervals), words included. Returns the model error where
// parts contradict each other. fitted: the rows that were fitted where they are at hand; also: summed in the same pass
// where there is one.
BetweenParts CheckAgreement(const CalibrationProblem& problem, const AgreementOptions& options, Estimate* estimate,
                            const FittedStream* fitted = nullptr, AlsoSummed* also = nullptr);

}  // namespace sagitta
