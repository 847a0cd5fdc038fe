// Sentences with what to do about each, for people: those that share a remedy in one paragraph.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estimator/least_squares/identifiability.h"

namespace sagitta {

using WordsAndRemedy = std::pair<std::string, std::string>;

// Of each remedy the first `shown` sentences and how many more there are.
std::vector<std::string> GroupedByRemedy(const std::vector<WordsAndRemedy>& sentences, size_t shown);

// The same of what the data do not determine.
std::vector<std::string> DirectionsInWords(const std::vector<Direction>& directions, size_t shown);

}  // namespace sagitta
