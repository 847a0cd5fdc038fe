#include "estimator/inspection/data_lint.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <tuple>

#include "estimator/inspection/load_lint.h"
#include "estimator/inspection/orientation.h"
#include "models/constants.h"
#include "problems/loads.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kStill = 1.0 * kDegree;        // a joint that covers less has not moved
constexpr double kStillLength = 1e-3;           // m, prismatic
constexpr double kLittleOfTheLimits = 0.2;      // share
constexpr double kLittleTurn = 30.0 * kDegree;  // joint: covers less than that
constexpr double kLittleLength = 0.05;          // m
constexpr double kConstantOrientation = 0.02;   // RMS of a unit vector's tip: 1 degree
constexpr double kOneAxis = 0.05;               // 3 degrees
constexpr double kEqualJoints = 1e-9;           // rad or m
constexpr double kOtherPose = 0.1 * kDegree;    // copies: the joints moved at least that much
constexpr double kEquationsPerUnknown = 2.0;
constexpr double kManyCopies = 0.05;  // of the rows

std::string RangeInWords(const Chain& chain, const MeasuredRange& range) {
  const bool turns = chain.joints[range.joint].type == JointType::kRevolute;
  const double unit = turns ? kDegree : 1e-3;
  return Fixed(range.least / unit, 1) + " to " + Fixed(range.most / unit, 1) + (turns ? " deg" : " mm");
}

// Configurations of the calibration rows, each with its first row.
std::map<int, int> CalibrationConfigurations(const CalibrationProblem& problem) {
  std::map<int, int> first;
  for (const int i : problem.CalibrationObservations())
    first.try_emplace(problem.data.shots[problem.data.observations[i].shot].configuration, i);
  return first;
}

void LintJoints(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const Chain& chain = problem.robot.chain;
  for (const MeasuredRange& range : MeasuredRangesOf(problem)) {
    const Joint& joint = chain.joints[range.joint];
    const bool turns = joint.type == JointType::kRevolute;
    const double covered = range.most - range.least;
    if (covered < (turns ? kStill : kStillLength)) {
      findings->push_back({Severity::kWarning,
                           "joint_never_moved",
                           "joint " + joint.name + " never moved (" + RangeInWords(chain, range) +
                               "): its axis is not seen, and the errors around it cannot be told apart",
                           "add configurations that move " + joint.name,
                           {}});
      continue;
    }
    const bool little =
        range.share > 0.0 ? range.share < kLittleOfTheLimits : covered < (turns ? kLittleTurn : kLittleLength);
    if (!little) continue;
    std::string words = "joint " + joint.name + " covers " + RangeInWords(chain, range) + " only";
    if (range.share > 0.0) words += ", " + Fixed(100.0 * range.share, 0) + " % of its limits";
    findings->push_back({Severity::kWarning,
                         "narrow_joint_range",
                         words + ": beyond it the model extrapolates",
                         "spread " + joint.name + " over the range that is used later",
                         {}});
  }
}

void LintOrientation(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  if (!problem.experiment.estimate.base || !problem.experiment.estimate.markers) return;
  bool on_flange = false;
  for (const int frame : problem.marker_frames) on_flange |= frame == problem.robot.chain.FlangeFrame();
  if (!on_flange) return;
  const OrientationVariety variety = OrientationVarietyOf(problem);
  const std::string where = variety.stations.empty() ? "" : " (station " + variety.stations + ")";
  if (variety.most < kConstantOrientation) {
    findings->push_back(
        {Severity::kSerious,
         "constant_orientation",
         "the flange has the same orientation in all configurations" + where +
             ": where the marker sits on the flange cannot be told from where the base stands; both could be "
             "shifted against each other by any amount without a trace",
         "add configurations with the flange turned about at least two axes by 30 degrees and more, or state the "
         "markers' points",
         {}});
  } else if (variety.least < kOneAxis) {
    const Vector3<double>& a = variety.still;
    findings->push_back({Severity::kWarning,
                         "one_axis_orientation",
                         "the flange turns about one axis only, (" + Fixed(a.x(), 2) + ", " + Fixed(a.y(), 2) + ", " +
                             Fixed(a.z(), 2) + ") in its own frame" + where +
                             ": the marker's place along it cannot be told from the base's",
                         "add configurations with the flange tilted about another axis, or state the markers' points",
                         {}});
  }
}

void LintCounts(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const int unknowns = static_cast<int>(problem.parameters.EstimatedCoordinates().size());
  const int equations = 3 * static_cast<int>(problem.CalibrationObservations().size());
  const int configurations = static_cast<int>(CalibrationConfigurations(problem).size());
  // What one configuration can add at most: the pose of the flange, and less with fewer markers.
  const int per_configuration = std::min<int>(6, 3 * problem.data.markers.size());
  if (equations >= kEquationsPerUnknown * unknowns && per_configuration * configurations >= unknowns) return;
  findings->push_back({Severity::kWarning,
                       "few_configurations",
                       std::to_string(configurations) + " configurations (" + std::to_string(equations) +
                           " equations) for " + std::to_string(unknowns) +
                           " unknowns: little is left to check the fit with",
                       "measure more configurations, or free less (estimate.geometry, --fixed)",
                       {}});
}

void LintDuplicatedPoses(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const auto& configurations = problem.data.configurations;
  std::vector<int> order(configurations.size());
  for (size_t c = 0; c < order.size(); ++c) order[c] = static_cast<int>(c);
  const auto less = [&](int a, int b) {
    const Eigen::VectorXd &p = configurations[a].q, &q = configurations[b].q;
    return std::lexicographical_compare(p.data(), p.data() + p.size(), q.data(), q.data() + q.size());
  };
  std::stable_sort(order.begin(), order.end(), less);
  std::map<int, int> first_row;
  for (size_t i = 0; i < problem.data.observations.size(); ++i)
    first_row.try_emplace(problem.data.shots[problem.data.observations[i].shot].configuration, static_cast<int>(i));
  Finding finding{
      Severity::kNote, "duplicated_poses", "", "give repeated arrivals the same config and another visit", {}};
  for (size_t k = 1; k < order.size(); ++k) {
    const Eigen::VectorXd difference = configurations[order[k]].q - configurations[order[k - 1]].q;
    if (difference.cwiseAbs().maxCoeff() > kEqualJoints) continue;
    finding.rows.push_back(problem.data.SourceOf(problem.data.observations[first_row[order[k]]]));
  }
  if (finding.rows.empty()) return;
  finding.words = std::to_string(finding.rows.size()) +
                  " configurations have the joint values of another one: they add repeats, no new poses";
  findings->push_back(finding);
}

// The same point to the last digit although the arm moved: a copied line, an instrument that did not update.
void LintCopiedPoints(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const Measurements& data = problem.data;
  std::map<std::tuple<int, int, double, double, double>, int> seen;
  Finding finding{Severity::kSerious, "copied_points", "", "measure these rows again or take them out", {}};
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& o = data.observations[i];
    if (!o.is_point()) continue;
    const Vector3<double>& p = o.point_in_station;
    const auto key = std::make_tuple(data.shots[o.shot].station, o.marker, p.x(), p.y(), p.z());
    const auto [entry, is_new] = seen.try_emplace(key, static_cast<int>(i));
    if (is_new) continue;
    const Observation& first = data.observations[entry->second];
    const Eigen::VectorXd moved = data.ConfigurationOf(o).q - data.ConfigurationOf(first).q;
    if (moved.cwiseAbs().maxCoeff() > kOtherPose) finding.rows.push_back(data.SourceOf(o));
  }
  if (finding.rows.empty()) return;
  if (finding.rows.size() < kManyCopies * data.observations.size()) finding.severity = Severity::kWarning;
  finding.words = std::to_string(finding.rows.size()) +
                  " rows have the point of an earlier row to the last digit, at other joint values";
  findings->push_back(finding);
}

void LintLoads(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const Measurements& data = problem.data;
  std::set<std::pair<int, int>> unloaded;  // configuration and station
  bool any_loaded = false;
  for (const Shot& shot : data.shots) {
    any_loaded |= IsLoaded(shot);
    if (!IsLoaded(shot)) unloaded.insert({shot.configuration, shot.station});
  }
  if (!any_loaded || unloaded.empty()) return;  // no unloaded row at all: the reader warns
  Finding finding{Severity::kNote,
                  "load_without_unloaded",
                  "",
                  "measure them unloaded at the same visit too: what the joints do alike in both then cancels",
                  {}};
  for (const Shot& shot : data.shots) {
    if (!IsLoaded(shot) || unloaded.count({shot.configuration, shot.station}) > 0) continue;
    finding.rows.push_back(data.SourceOf(data.observations[shot.observations.front()]));
  }
  if (finding.rows.empty()) return;
  finding.words = std::to_string(finding.rows.size()) + " loaded shots have no unloaded counterpart";
  findings->push_back(finding);
}

void Note(const std::string& code, const std::string& words, const std::string& remedy,
          std::vector<Finding>* findings) {
  findings->push_back({Severity::kNote, code, words, remedy, {}});
}

void LintColumns(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const Measurements& data = problem.data;
  const auto any = [&](const auto& has) { return std::any_of(data.shots.begin(), data.shots.end(), has); };
  std::map<int, std::set<std::string>> visits, repeats;
  for (const Shot& shot : data.shots) {
    visits[shot.configuration].insert(shot.visit);
    repeats[shot.configuration].insert(shot.visit + "/" + shot.repeat);
  }
  const bool revisited =
      std::any_of(visits.begin(), visits.end(), [](const auto& entry) { return entry.second.size() > 1; });
  if (!problem.sigma_is_stated()) {
    Note("no_sigma",
         "no standard deviation is stated: one for all coordinates is estimated, and nothing can tell a "
         "wrong model from noise",
         "add sigma_x_mm, sigma_y_mm, sigma_z_mm, state noise: {sigma_mm: …}, or give --sigma_mm", findings);
  }
  if (!any([](const Shot& shot) { return !shot.approach.empty(); })) {
    Note("no_approach", "no column says from which side the joints arrived: backlash cannot be told",
         "add approach1 … approachN (-1, 0, +1) and reach some configurations from both sides", findings);
  }
  if (!revisited) {
    Note("no_visits",
         "no configuration was visited twice: the robot's repeatability cannot be told from the "
         "instrument's noise by repeats",
         "reach some configurations again, with the same config and another visit", findings);
  }
  if (!any([](const Shot& shot) { return shot.has_time; })) {
    Note("no_time", "no column time_s: drift and slips cannot be told", "add time_s", findings);
  }
  if (!any([](const Shot& shot) { return shot.has_temperature; })) {
    Note("no_temperature", "no column temperature_degC: thermal growth cannot be told", "add temperature_degC",
         findings);
  }
  if (data.markers.size() < 3) {
    Note("few_markers",
         "fewer than three markers: the flange's orientation is not measured, and the instrument's noise "
         "cannot be checked against the markers' rigid arrangement",
         "measure three markers off one line in each shot", findings);
  }
}

}  // namespace

const char* SeverityName(Severity severity) {
  switch (severity) {
    case Severity::kSerious:
      return "serious";
    case Severity::kWarning:
      return "warning";
    case Severity::kNote:
      return "note";
  }
  return "";
}

std::vector<MeasuredRange> MeasuredRangesOf(const CalibrationProblem& problem) {
  std::vector<MeasuredRange> ranges;
  const std::map<int, int> configurations = CalibrationConfigurations(problem);
  for (int j = 0; j < problem.robot.num_joints(); ++j) {
    MeasuredRange range;
    range.joint = j;
    bool first = true;
    for (const auto& [c, row] : configurations) {
      const double q = problem.data.configurations[c].q[j];
      range.least = first ? q : std::min(range.least, q);
      range.most = first ? q : std::max(range.most, q);
      first = false;
    }
    const Joint& joint = problem.robot.chain.joints[j];
    if (joint.min && joint.max && *joint.max > *joint.min)
      range.share = (range.most - range.least) / (*joint.max - *joint.min);
    ranges.push_back(range);
  }
  return ranges;
}

std::vector<Finding> LintData(const CalibrationProblem& problem) {
  std::vector<Finding> findings;
  for (const std::string& warning : problem.data.warnings)
    findings.push_back({Severity::kWarning, "reader", warning, "", {}});
  LintCopiedPoints(problem, &findings);
  LintOrientation(problem, &findings);
  LintJoints(problem, &findings);
  LintCounts(problem, &findings);
  LintDuplicatedPoses(problem, &findings);
  LintLoads(problem, &findings);
  for (Finding& finding : LintDeflections(problem)) findings.push_back(std::move(finding));
  LintColumns(problem, &findings);
  return findings;
}

}  // namespace sagitta
