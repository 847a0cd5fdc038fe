#include "estimator/diagnosis/cautions.h"

#include <cmath>
#include <set>

#include "problems/loads.h"
#include "problems/split.h"

namespace sagitta {
namespace {

constexpr double kDegree = 57.29577951308232;
constexpr double kStill = 5.0 / kDegree;  // rad: a joint that moves less is taken as standing
constexpr double kStillLength = 0.05;     // m, prismatic
constexpr int kFewConfigurations = 15;
constexpr int kFewHeldOut = 3;
constexpr size_t kNamesListed = 6;

// Configurations with equal joint values count once.
struct Counts {
  int fitted = 0;
  int held_out = 0;
  int in_both = 0;
};

Counts CountConfigurations(const Measurements& data) {
  Counts counts;
  for (const std::vector<int>& group : GroupsOfEqualJointValues(data)) {
    bool fitted = false, held_out = false;
    for (const int c : group) (data.configurations[c].is_validation ? held_out : fitted) = true;
    counts.fitted += fitted;
    counts.held_out += held_out;
    counts.in_both += fitted && held_out;
  }
  return counts;
}

std::string Listed(const std::vector<std::string>& names) {
  std::string words;
  for (size_t i = 0; i < names.size() && i < kNamesListed; ++i) words += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kNamesListed) words += " and " + std::to_string(names.size() - kNamesListed) + " more";
  return words;
}

// Joints that hardly move over the fitted configurations.
std::vector<std::string> StandingJoints(const CalibrationProblem& problem) {
  std::vector<std::string> standing;
  for (int j = 0; j < problem.robot.num_joints(); ++j) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Configuration& configuration : problem.data.configurations) {
      if (configuration.is_validation) continue;
      low = std::min(low, configuration.q[j]);
      high = std::max(high, configuration.q[j]);
    }
    const Joint& joint = problem.robot.chain.joints[j];
    if (high - low < (joint.type == JointType::kRevolute ? kStill : kStillLength)) standing.push_back(joint.name);
  }
  return standing;
}

bool HasRepeats(const Measurements& data) {
  std::set<std::vector<int>> seen;
  for (const Observation& observation : data.observations) {
    const Shot& shot = data.shots[observation.shot];
    if (!seen.insert({shot.configuration, shot.station, observation.marker, IsLoaded(shot) ? 1 : 0}).second)
      return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> FindCautions(const DiagnosedModel& believed) {
  const CalibrationProblem& problem = *believed.problem;
  std::vector<std::string> cautions;
  if (!problem.sigma_is_stated()) {
    cautions.push_back(
        std::string("No noise is stated") + (HasRepeats(problem.data) ? "" : " and nothing was measured twice") +
        ": the scatter that the model leaves is taken as noise. Structure in it is found, a gap without structure is "
        "not, and 'consistent' means no more than that. State sigma_mm, or measure some poses again.");
  }
  const Counts counts = CountConfigurations(problem.data);
  const int unknowns = static_cast<int>(problem.parameters.EstimatedCoordinates().size());
  const int rows = 3 * static_cast<int>(problem.CalibrationObservations().size());
  if (counts.fitted < kFewConfigurations || rows < 2 * unknowns) {
    cautions.push_back("Only " + std::to_string(counts.fitted) + " different configurations (" + std::to_string(rows) +
                       " coordinates) are fitted, for " + std::to_string(unknowns) +
                       " unknowns and the whole catalogue: most effects cannot be seen in them, and what is named may "
                       "stand for something else. 40 configurations and more carry the search.");
  }
  const std::vector<std::string> standing = StandingJoints(problem);
  if (!standing.empty()) {
    const bool all = static_cast<int>(standing.size()) == problem.robot.num_joints();
    cautions.push_back(
        (all ? std::string("All configurations are alike: no joint moves") : Listed(standing) + " hardly move") +
        " (less than 5 deg or 50 mm): what depends on their position cannot be told" +
        (all ? ", and the verdict holds for this one pose." : "."));
  }
  if (!believed.estimate.identifiability.unidentifiable.empty()) {
    std::vector<std::string> held;
    for (const Coordinate& coordinate : believed.estimate.parameters.coordinates()) {
      if (coordinate.held) held.push_back(coordinate.name);
    }
    cautions.push_back("The believed model already has what these data cannot tell (held: " + Listed(held) +
                       "): an effect that moves the markers like these cannot be told from them.");
  }
  if (counts.in_both > 0) {
    cautions.push_back(
        std::to_string(counts.in_both) +
        " configurations are fitted and held out at once (equal joint values under different names): the "
        "hold-out figures are too good by their share. Hold out whole configurations.");
  }
  if (counts.held_out > 0 && counts.held_out < kFewHeldOut) {
    const std::string held_out =
        counts.held_out == 1 ? "1 configuration is" : std::to_string(counts.held_out) + " configurations are";
    cautions.push_back("Only " + held_out + " held out: the gap figures are hardly more than an example.");
  }
  return cautions;
}

}  // namespace sagitta
