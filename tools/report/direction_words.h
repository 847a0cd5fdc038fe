// What the data do not determine, for people: directions that share a remedy in one paragraph.
#pragma once

#include <string>
#include <vector>

#include "estimator/least_squares/identifiability.h"

namespace sagitta {

// Of each remedy the first `shown` directions and how many more there are; at most as many remedies.
std::vector<std::string> DirectionsInWords(const std::vector<Direction>& directions, size_t shown);

}  // namespace sagitta
