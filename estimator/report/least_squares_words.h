// What is said of directions that the data do not determine.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sagitta {

// A direction with a large spread: one parameter, or several that trade off as `words` say.
std::string PoorlyDetermined(const std::vector<std::pair<std::string, double>>& components, const std::string& words);

// What to measure or to state, by the families of the names; components: as in Direction (identifiability.h).
std::string RemedyFor(const std::vector<std::pair<std::string, double>>& components);

// Markers that count as the ends of the compensator's spring, or do not.
std::string MarkersAreNotTheEnds(const std::string& lever_marker, const std::string& anchor_marker);
std::string MarkersAreAssumedEnds(const std::string& lever_marker, const std::string& anchor_marker);

}  // namespace sagitta
