// What a diagnosis proposes to measure next, for people.
#pragma once

#include <string>

#include "estimator/evidence/next_poses.h"

namespace sagitta {

// Between which answers, what it is expected to decide, and how the file is used. is_consistent: nothing is missing
// that shows; the poses are for those who want to exclude what is possible all the same.
std::string NextInWords(const CalibrationProblem& problem, const NextPoses& next, bool is_consistent);

// Names of what a set holds: "A", "A with B and C".
std::vector<std::string> NamesOf(const Robot& robot, const NamedSet& set);
std::string WithOneAnother(const std::vector<std::string>& names);

}  // namespace sagitta
