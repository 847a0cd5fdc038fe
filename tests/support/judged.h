// Judgements of an estimate or of rows alone, where nothing is at hand that was summed before.
#pragma once

#include <cstdint>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/validation/trust.h"

namespace sagitta::test {

inline Trust JudgeTrust(const CalibrationProblem& problem, std::uint64_t seed, Estimate* estimate,
                        const BetweenParts& between = {}) {
  const FittedStream fitted(problem);
  return sagitta::JudgeTrust(problem, fitted, PlanFolds(problem, fitted, seed), estimate, between);
}

inline CrossValidation CrossValidate(const CalibrationProblem& problem, const Estimate& estimate, std::uint64_t seed) {
  const FittedStream fitted(problem);
  return sagitta::CrossValidate(problem, fitted, estimate, PlanFolds(problem, fitted, seed));
}

inline Plausibility CheckPlausible(const CalibrationProblem& problem) {
  return sagitta::CheckPlausible(problem, AlignedSample(problem));
}

}  // namespace sagitta::test
