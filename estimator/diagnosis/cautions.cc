#include "estimator/diagnosis/cautions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>

#include "estimator/diagnosis/noise_check.h"
#include "estimator/diagnosis/refit.h"
#include "estimator/inspection/load_lint.h"
#include "estimator/inspection/reading_lint.h"
#include "problems/split.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;
constexpr double kStill = 5.0 / kDegreesPerRadian;  // rad: a joint that moves less is taken as standing
constexpr double kStillLength = 0.05;               // m, prismatic
constexpr int kFewConfigurations = 15;
constexpr int kFewHeldOut = 3;
constexpr size_t kNamesListed = 6;
constexpr double kFarAboveFloor = 1.5;
constexpr double kFarBelow = 3.1;  // standard deviations, one in a thousand

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

// Of a problem that asks for components it is known.
void AppendNoise(const CalibrationProblem& problem, std::vector<std::string>* cautions) {
  const bool is_asked = problem.experiment.noise.from == NoiseSpec::From::kVarianceComponents;
  if (problem.sigma_is_stated() || is_asked) return;
  const std::string taken =
      RowsShareVisits(problem)
          ? ": what the rows of one arrival share is taken as joint repeatability where that says "
            "more than any effect, and the rest of the scatter that the model leaves as the instrument's noise"
          : " and nothing was measured twice: the scatter that the model leaves is taken as noise";
  cautions->push_back("No noise is stated" + taken +
                      ". Structure in it is found, a gap without structure is not, and 'consistent' means no more than "
                      "that. State sigma_mm, or measure some poses again.");
}

// The search compares chi-squares of one least-squares model: other ways to weigh the rows are not taken.
void AppendUnused(const Experiment& experiment, std::vector<std::string>* cautions) {
  std::vector<std::string> keys;
  if (experiment.loss != "none") keys.push_back("loss: " + experiment.loss);
  if (experiment.weights != "sigma") keys.push_back("weights: " + experiment.weights);
  const bool is_judged = experiment.covariance == "model" || experiment.covariance == "sandwich";
  if (!is_judged) keys.push_back("covariance: " + experiment.covariance);
  if (experiment.noise.from == NoiseSpec::From::kResiduals) keys.push_back("noise from residuals");
  if (keys.empty()) return;
  cautions->push_back("Not used by the diagnosis, which tells the noise beside the effects itself: " +
                      Enumerate(keys, kNamesListed) + ".");
}

void AppendFew(const CalibrationProblem& problem, const Counts& counts, std::vector<std::string>* cautions) {
  const int unknowns = static_cast<int>(problem.parameters.EstimatedCoordinates().size());
  const int rows = 3 * static_cast<int>(problem.CalibrationObservations().size());
  if (counts.fitted >= kFewConfigurations && rows >= 2 * unknowns) return;
  cautions->push_back("Only " + std::to_string(counts.fitted) + " different configurations (" + std::to_string(rows) +
                      " coordinates) are fitted, for " + std::to_string(unknowns) +
                      " unknowns and the whole catalogue: most effects cannot be seen in them, and what is named may "
                      "stand for something else. 40 configurations and more carry the search.");
}

void AppendStanding(const CalibrationProblem& problem, std::vector<std::string>* cautions) {
  const std::vector<std::string> standing = StandingJoints(problem);
  if (standing.empty()) return;
  const bool all = static_cast<int>(standing.size()) == problem.robot.num_joints();
  cautions->push_back(
      (all ? std::string("All configurations are alike: no joint moves")
           : Enumerate(standing, kNamesListed) + (standing.size() == 1 ? " hardly moves" : " hardly move")) +
      " (less than 5 deg or 50 mm): what depends on their position cannot be told" +
      (all ? ", and the verdict holds for this one pose." : "."));
}

struct DrivingColumn {
  std::string name;
  std::function<bool(const ShotConditions&)> is_stated;
};

std::vector<DrivingColumn> DrivingColumns(int joints) {
  std::vector<DrivingColumn> columns = {
      {"time_s", [](const ShotConditions& shot) { return shot.has_time; }},
      {"temperature_degC", [](const ShotConditions& shot) { return shot.has_temperature; }}};
  for (int j = 0; j < joints; ++j) {
    columns.push_back(
        {"approach" + std::to_string(j + 1), [j](const ShotConditions& shot) { return shot.StatesApproachOf(j); }});
  }
  return columns;
}

// An effect acts in every shot or is not looked for: a few empty cells silence a whole column.
void AppendPartlyStated(const CalibrationProblem& problem, std::vector<std::string>* cautions) {
  const Measurements& data = problem.data;
  std::vector<std::string> partly;
  for (const DrivingColumn& column : DrivingColumns(problem.robot.num_joints())) {
    const auto stating = std::count_if(problem.shot_inputs.begin(), problem.shot_inputs.end(),
                                       [&](const ShotInput& shot) { return column.is_stated(shot.conditions); });
    if (stating == 0 || stating == static_cast<long>(problem.shot_inputs.size())) continue;
    const auto empty = std::count_if(data.observations.begin(), data.observations.end(),
                                     [&](const Observation& row) { return data.Cell(row, column.name).empty(); });
    partly.push_back(column.name + " (" + std::to_string(empty) + " of " + std::to_string(data.observations.size()) +
                     " rows)");
  }
  if (partly.empty()) return;
  cautions->push_back("Columns that some rows do not state: " + Enumerate(partly, kNamesListed) +
                      ". What they drive is looked for only where every shot states it: fill the cells, or leave those "
                      "rows out.");
}

void AppendHeld(const Estimate& estimate, std::vector<std::string>* cautions) {
  if (estimate.identifiability.unidentifiable.empty()) return;
  std::vector<std::string> held;
  for (const Coordinate& coordinate : estimate.parameters.coordinates()) {
    if (coordinate.held) held.push_back(coordinate.name);
  }
  cautions->push_back(
      "The believed model already has what these data cannot tell (held: " + Enumerate(held, kNamesListed) +
      "): an effect that moves the markers like these cannot be told from them.");
}

// What the robot file states and the experiment holds is neither estimated nor a candidate.
void AppendHeldEffects(const CalibrationProblem& problem, std::vector<std::string>* cautions) {
  std::vector<std::string> held;
  for (const EffectSpec& spec : problem.robot.effects) {
    const auto& coordinates = problem.parameters.coordinates();
    const bool is_free = std::any_of(coordinates.begin(), coordinates.end(), [&](const Coordinate& coordinate) {
      return coordinate.free && IsParameterOf(spec, coordinate.name);
    });
    if (!is_free) held.push_back(spec.Path());
  }
  if (held.empty()) return;
  cautions->push_back("Held at the values of the robot file, and not looked for: " + Enumerate(held, kNamesListed) +
                      ". To ask for them, free them (estimate: {effects: all}) or take them out of the file.");
}

void AppendHoldout(const Counts& counts, std::vector<std::string>* cautions) {
  if (counts.in_both > 0) {
    cautions->push_back(
        (counts.in_both == 1 ? "1 configuration is" : std::to_string(counts.in_both) + " configurations are") +
        " fitted and held out at once (equal joint values under different names): the "
        "hold-out figures are too good by their share. Hold out whole configurations.");
  }
  if (counts.held_out == 0) {
    cautions->push_back("Nothing is held out: whether the gap shrinks on data that took no part is not known.");
  } else if (counts.held_out < kFewHeldOut) {
    const std::string held_out =
        counts.held_out == 1 ? "1 configuration is" : std::to_string(counts.held_out) + " configurations are";
    cautions->push_back("Only " + held_out + " held out: the gap figures are hardly more than an example.");
  }
}

}  // namespace

std::vector<std::string> CautionsOfReadings(const CalibrationProblem& problem) {
  std::vector<std::string> cautions;
  for (const std::vector<Finding>& findings : {LintReadings(problem).findings, LintDeflections(problem)}) {
    for (const Finding& finding : findings) {
      if (finding.severity != Severity::kSerious) continue;
      cautions.push_back("Look at this first: " + finding.words + "; " + finding.remedy + ".");
    }
  }
  return cautions;
}

std::vector<std::string> FindCautions(const CalibrationProblem& stated, const DiagnosedModel& believed) {
  const Counts counts = CountConfigurations(stated.data);
  std::vector<std::string> cautions;
  AppendNoise(stated, &cautions);
  AppendUnused(stated.experiment, &cautions);
  AppendFew(stated, counts, &cautions);
  AppendStanding(stated, &cautions);
  AppendPartlyStated(stated, &cautions);
  AppendHeld(believed.estimate, &cautions);
  AppendHeldEffects(stated, &cautions);
  AppendHoldout(counts, &cautions);
  return cautions;
}

void CautionOfHoldout(const DiagnosedModel& final, bool has_unexplained, std::vector<std::string>* cautions) {
  const double rms = final.estimate.validation.rms, floor = final.estimate.noise_floor;
  const int held_out = CountConfigurations(final.problem->data).held_out;
  if (held_out < kFewHeldOut) return;
  char words[240];
  if (!has_unexplained && rms > kFarAboveFloor * floor) {
    std::snprintf(words, sizeof words,
                  "The hold-out RMS, %.3g mm, is %.2g times what noise and parameters explain: the fitted "
                  "configurations do not tell what the held-out ones need.",
                  1e3 * rms, rms / floor);
    cautions->push_back(words);
  }
  // Relative scatter of an RMS of n numbers: 1 / sqrt(2 n). Markers of one configuration may share theirs.
  const double scatter = 1.0 / std::sqrt(2.0 * 3.0 * held_out);
  if (rms < (1.0 - kFarBelow * scatter) * floor) {
    std::snprintf(words, sizeof words,
                  "The noise floor, %.3g mm, is above the hold-out RMS, %.3g mm: these rows scatter less than the "
                  "noise that is taken, and how much of the gap is closed is an upper limit.",
                  1e3 * floor, 1e3 * rms);
    cautions->push_back(words);
  }
}

}  // namespace sagitta
