#include "estimator/report/least_squares_tie_words.h"

namespace sagitta {
namespace {

std::string Markers(const std::string& lever, const std::string& anchor) {
  return "markers '" + lever + "' and '" + anchor + "' ";
}

}  // namespace

std::string MarkersAreNotTheEnds(const std::string& lever_marker, const std::string& anchor_marker) {
  return Markers(lever_marker, anchor_marker) +
         "ride on the links of the compensator's spring, but not where the robot file has its ends: they are "
         "not used for it; state spring: lever and spring: anchor if they are its ends";
}

std::string MarkersAreAssumedEnds(const std::string& lever_marker, const std::string& anchor_marker) {
  return Markers(lever_marker, anchor_marker) +
         "are assumed to be the very ends of the compensator's spring; state how well they sit there "
         "(spring_sigma_mm), or spring: none if they are something else";
}

}  // namespace sagitta
