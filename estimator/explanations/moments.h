// When something may have changed: moments between visits, first thinned, then all around those that matter.
#pragma once

#include <string>
#include <vector>

#include "estimator/explanations/candidates.h"

namespace sagitta {

// Middles between the times of consecutive fitted visits, s of the campaign's clock, thinned; settings of kMoment.
std::vector<std::string> ChangePoints(const CalibrationProblem& problem);

// The moments between the thinned ones, around the best of each effect on each target that alone is more likely
// than nothing by e^3: rows on the wrong side of a moment leave what a hundred other explanations would absorb.
std::vector<Candidate> RefinedMoments(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      const CandidateList& list);

}  // namespace sagitta
