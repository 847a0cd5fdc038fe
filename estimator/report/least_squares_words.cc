#include "estimator/report/least_squares_words.h"

#include <cmath>

#include "estimator/least_squares/identifiability.h"
#include "models/effects/catalogue.h"
#include "problems/parameter_set.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kMostHeldNames = 6;

// A stated point alone is where the search starts.
constexpr const char* kHoldTheMarker =
    "state a marker's point and hold the coordinate of it that is named here (--fixed=NAME, or priors: in the "
    "experiment file)";

std::string MarkersOfTie(const std::string& lever, const std::string& anchor) {
  return "markers '" + lever + "' and '" + anchor + "' ";
}

std::string RemedyForEffect(EffectDriver driver) {
  switch (driver) {
    case EffectDriver::kTime:
      return "measure for longer, every part of the workspace early and late, or leave the effect out";
    case EffectDriver::kTemperature:
      return "measure at more different temperatures, or leave the effect out";
    case EffectDriver::kJoint:
      break;
  }
  return "move the joints that drive the effect over a wider range, and load the arm where it answers to loads; what "
         "moves every point as another parameter does no pose separates: leave one of the two out";
}

}  // namespace

std::string RemedyFor(const std::vector<std::pair<std::string, double>>& components) {
  bool base = false, marker = false, geometry = false;
  for (const auto& [name, value] : components) {
    const std::optional<CoordinateKind> kind = CoordinateKindOf(name);
    base |= kind == CoordinateKind::kBase;
    marker |= kind == CoordinateKind::kMarker;
    geometry |= kind == CoordinateKind::kGeometry;
  }
  if (!components.empty() && CoordinateKindOf(components[0].first) == CoordinateKind::kCompliance) {
    return "load the arm more heavily in configurations in which the load acts on this joint, or state a prior";
  }
  if (!components.empty() && EffectOfName(components[0].first) == &Payload()) {
    return "measure with this load where it turns the joints as much as a load of known mass does (where torques: "
           "measured is stated, loads drive nothing, and torques: model is what can determine it), or weigh it";
  }
  for (const auto& [name, value] : components) {
    if (const EffectDefinition* effect = EffectOfName(name)) return RemedyForEffect(effect->DrivenBy({}));
  }
  if (base && marker) {
    return std::string("measure with the flange turned about at least two axes (wrist joints spread over 60 degrees ") +
           "or more) where the arm can turn it so, or " + kHoldTheMarker;
  }
  if (marker && geometry)
    return std::string("only where the marker ends up matters: leave the error at nominal, or ") + kHoldTheMarker;
  if (base && geometry)
    return "only where the robot ends up matters: leave the error at nominal, or state the base pose and hold it "
           "(--fixed=NAME)";
  if (marker) return "observe the marker at more configurations with different flange orientations";
  if (base) return "observe from this station at more configurations spread over the workspace";
  return "move the joints near these transforms over a wider range, or leave the error at nominal";
}

std::string DirectionInWords(const std::vector<std::pair<std::string, double>>& components) {
  if (components.empty()) return "";
  if (components.size() == 1) return components[0].first + " is not measured by these data";
  std::vector<std::string> names;
  for (const auto& [name, weight] : components) names.push_back(name);
  const std::string listed = Enumerate(names, kMostHeldNames);
  if (components.size() > 2) {
    return listed + " move together: only " + std::to_string(components.size() - 1) +
           " combinations of them are measured";
  }
  const double ratio = -components[1].second / components[0].second;
  const bool alike = std::abs(std::abs(ratio) - 1.0) < 0.05;
  const std::string kind = ratio > 0.0 ? "sum" : "difference";
  return listed + " move together: only their " + (alike ? "" : "weighted ") + kind + " is measured";
}

std::string PoorlyDetermined(const std::vector<std::pair<std::string, double>>& components, const std::string& words) {
  return components.size() == 1 ? components[0].first + " is measured poorly" : "poorly separated: " + words;
}

std::string MarkersAreNotTheEnds(const std::string& lever_marker, const std::string& anchor_marker) {
  return MarkersOfTie(lever_marker, anchor_marker) +
         "ride on the links of the compensator's spring, but not where the robot file has its ends: they are "
         "not used for it; state spring: lever and spring: anchor if they are its ends";
}

std::string MarkersAreAssumedEnds(const std::string& lever_marker, const std::string& anchor_marker) {
  return MarkersOfTie(lever_marker, anchor_marker) +
         "are assumed to be the very ends of the compensator's spring; state how well they sit there "
         "(spring_sigma_mm), or spring: none if they are something else";
}

}  // namespace sagitta
