// What changed between two estimates, in words.
#pragma once

#include <string>
#include <vector>

#include "estimator/changes/changes.h"

namespace sagitta {

std::string ChangeInWords(const Change& change);

// What the rotation of a motion adds, mrad.
std::string TurnedInWords(double angle_mrad);

// All changes in one sentence, with their probabilities.
std::string ChangesInWords(const Changes& changes);

// Parameters that one file estimates and the other assumes.
std::string ChangesOpen(const std::string& file, const std::vector<std::string>& parameters);

}  // namespace sagitta
