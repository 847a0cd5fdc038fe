// Markers that count as the ends of the compensator's spring, or do not.
#pragma once

#include <string>

namespace sagitta {

std::string MarkersAreNotTheEnds(const std::string& lever_marker, const std::string& anchor_marker);
std::string MarkersAreAssumedEnds(const std::string& lever_marker, const std::string& anchor_marker);

}  // namespace sagitta
