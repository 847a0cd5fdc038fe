#include "estimator/inspection/data_lint.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "estimator/inspection/load_lint.h"
#include "estimator/inspection/orientation.h"
#include "models/constants.h"
#include "problems/interruption.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

// A joint that covers less has not moved: even a worn one stands within a thirtieth of a degree (500 urad).
constexpr double kUnmovedAngle = 1.0 * kDegree;
constexpr double kUnmovedLength = 1e-3;  // m, prismatic: slides return within some 10 um
// Share of the limits, a choice; without limits a turn by 30 deg, over which an arc is a line to 3 % (1 - cos 15 deg),
// or m of a slide.
constexpr double kLittleOfTheLimits = 0.2;
constexpr double kLittleTurn = 30.0 * kDegree;
constexpr double kLittleLength = 0.05;
constexpr double kConstantOrientation = 0.02;  // RMS of a unit vector's tip: 1 degree
constexpr double kOneAxis = 0.05;              // 3 degrees
constexpr double kEqualJoints = 1e-9;          // rad or m
constexpr double kOtherPose = 0.1 * kDegree;   // copies: the joints moved at least that much, 1.7 mm at 1 m
constexpr double kEquationsPerUnknown = 2.0;   // half of its own error is then left in a residual, in the mean
constexpr double kManyCopies = 0.05;           // of the rows: a choice, more than a slip of single rows

// A configuration of the calibration rows and the first of these.
struct FirstRow {
  int configuration = 0, row = 0;
};

std::vector<FirstRow> CalibrationConfigurations(const CalibrationProblem& problem) {
  constexpr int kNone = -1;
  std::vector<int> first(problem.data().configurations.size(), kNone);
  for (const int i : problem.CalibrationObservations()) {
    int& own = first[problem.data().shots[problem.data().observations[i].shot].configuration];
    if (own == kNone) own = i;
  }
  std::vector<FirstRow> found;
  for (size_t c = 0; c < first.size(); ++c) {
    if (first[c] != kNone) found.push_back({static_cast<int>(c), first[c]});
  }
  return found;
}

// A joint that could have moved.
bool IsStill(const CalibrationProblem& problem, const MeasuredRange& range) {
  const Joint& joint = problem.robot().chain.joints[range.joint];
  const bool turns = joint.type == JointType::kRevolute;
  return !joint.IsHeld() && range.most - range.least < (turns ? kUnmovedAngle : kUnmovedLength);
}

// Values that the joint cannot have: another joint's column, another zero or unit, or limits of another robot.
void LintLimits(const CalibrationProblem& problem, const MeasuredRange& range, std::vector<Finding>* findings) {
  const Joint& joint = problem.robot().chain.joints[range.joint];
  const double slack = joint.type == JointType::kRevolute ? kUnmovedAngle : kUnmovedLength;
  const auto is_beyond = [&](double q) {
    return (joint.min && q < *joint.min - slack) || (joint.max && q > *joint.max + slack);
  };
  if (!is_beyond(range.least) && !is_beyond(range.most)) return;
  std::vector<std::string> rows;
  for (const auto& [c, row] : CalibrationConfigurations(problem)) {
    if (is_beyond(problem.data().configurations[c].q[range.joint]))
      rows.push_back(problem.data().SourceOf(problem.data().observations[row]));
  }
  findings->push_back(
      Found(Severity::kWarning, "beyond_limits", JointBeyondLimits(joint, range.least, range.most), rows));
}

void LintJoints(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const Chain& chain = problem.robot().chain;
  for (const MeasuredRange& range : MeasuredRangesOf(problem)) {
    const Joint& joint = chain.joints[range.joint];
    const bool turns = joint.type == JointType::kRevolute;
    const double covered = range.most - range.least;
    LintLimits(problem, range, findings);
    if (joint.IsHeld()) continue;
    if (IsStill(problem, range)) {
      findings->push_back(
          Found(Severity::kWarning, "joint_never_moved", JointNeverMoved(joint, range.least, range.most)));
      continue;
    }
    const bool little =
        range.share > 0.0 ? range.share < kLittleOfTheLimits : covered < (turns ? kLittleTurn : kLittleLength);
    if (!little) continue;
    findings->push_back(Found(Severity::kWarning, "narrow_joint_range",
                              JointCoversLittle(joint, range.least, range.most, range.share)));
  }
}

void LintOrientation(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  if (!problem.experiment().estimate.base || !problem.experiment().estimate.markers) return;
  const bool on_flange = !problem.MarkersOnFlange().empty();
  if (!on_flange) return;
  const OrientationVariety variety = OrientationVarietyOf(problem);
  if (variety.most < kConstantOrientation) {
    findings->push_back(Found(Severity::kSerious, "constant_orientation", OrientationIsConstant(variety.stations)));
  } else if (variety.least < kOneAxis) {
    findings->push_back(
        Found(Severity::kWarning, "one_axis_orientation", OrientationAboutOneAxis(variety.still, variety.stations)));
  }
}

void LintCounts(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const int unknowns = static_cast<int>(problem.parameters.EstimatedCoordinates().size());
  const int equations = 3 * static_cast<int>(problem.CalibrationObservations().size());
  const int configurations = static_cast<int>(CalibrationConfigurations(problem).size());
  // What one configuration can add at most: the pose of the flange, and less with fewer markers.
  const int per_configuration = std::min<int>(6, 3 * problem.data().markers.size());
  if (equations >= kEquationsPerUnknown * unknowns && per_configuration * configurations >= unknowns) return;
  findings->push_back(
      Found(Severity::kWarning, "few_configurations", FewConfigurations(configurations, equations, unknowns)));
}

void LintDuplicatedPoses(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const auto& configurations = problem.data().configurations;
  std::vector<int> order(configurations.size());
  for (size_t c = 0; c < order.size(); ++c) order[c] = static_cast<int>(c);
  const auto less = [&](int a, int b) {
    const Eigen::VectorXd &p = configurations[a].q, &q = configurations[b].q;
    return std::lexicographical_compare(p.data(), p.data() + p.size(), q.data(), q.data() + q.size());
  };
  std::stable_sort(order.begin(), order.end(), less);
  std::map<int, int> first_row;
  for (size_t i = 0; i < problem.data().observations.size(); ++i)
    first_row.try_emplace(problem.data().shots[problem.data().observations[i].shot].configuration, static_cast<int>(i));
  std::vector<std::string> rows;
  for (size_t k = 1; k < order.size(); ++k) {
    const Eigen::VectorXd difference = configurations[order[k]].q - configurations[order[k - 1]].q;
    if (difference.cwiseAbs().maxCoeff() > kEqualJoints) continue;
    rows.push_back(problem.data().SourceOf(problem.data().observations[first_row[order[k]]]));
  }
  if (rows.empty()) return;
  findings->push_back(Found(Severity::kNote, "duplicated_poses", PosesAreRepeated(rows.size()), rows));
}

// The same point to the last digit although the arm moved: a copied line, an instrument that did not update.
void LintCopiedPoints(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const Measurements& data = problem.data();
  std::map<std::tuple<int, int, double, double, double>, int> seen;
  std::vector<std::string> rows;
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& o = data.observations[i];
    if (!o.is_point()) continue;
    const Vector3<double>& p = o.point_in_station;
    const auto key = std::make_tuple(data.shots[o.shot].station, o.marker, p.x(), p.y(), p.z());
    const auto [entry, is_new] = seen.try_emplace(key, static_cast<int>(i));
    if (is_new) continue;
    const Observation& first = data.observations[entry->second];
    const Eigen::VectorXd moved = data.ConfigurationOf(o).q - data.ConfigurationOf(first).q;
    if (moved.cwiseAbs().maxCoeff() > kOtherPose) rows.push_back(data.SourceOf(o));
  }
  if (rows.empty()) return;
  const bool are_many = rows.size() >= kManyCopies * data.observations.size();
  findings->push_back(
      Found(are_many ? Severity::kSerious : Severity::kWarning, "copied_points", PointsAreCopied(rows.size()), rows));
}

void LintLoads(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const Measurements& data = problem.data();
  std::set<std::pair<int, int>> unloaded;  // configuration and station
  bool any_loaded = false;
  for (const Shot& shot : data.shots) {
    any_loaded |= IsLoaded(shot);
    if (!IsLoaded(shot)) unloaded.insert({shot.configuration, shot.station});
  }
  if (!any_loaded || unloaded.empty()) return;  // no unloaded row at all: the reader warns
  std::vector<std::string> rows;
  for (const Shot& shot : data.shots) {
    if (!IsLoaded(shot) || unloaded.count({shot.configuration, shot.station}) > 0) continue;
    rows.push_back(data.SourceOf(data.observations[shot.observations.front()]));
  }
  if (rows.empty()) return;
  findings->push_back(Found(Severity::kNote, "load_without_unloaded", LoadedWithoutUnloaded(rows.size()), rows));
}

void LintColumns(const CalibrationProblem& problem, std::vector<Finding>* findings) {
  const Measurements& data = problem.data();
  const auto any = [&](const auto& has) { return std::any_of(data.shots.begin(), data.shots.end(), has); };
  std::map<int, std::set<std::string>> visits, repeats;
  for (const Shot& shot : data.shots) {
    visits[shot.configuration].insert(shot.visit);
    repeats[shot.configuration].insert(shot.visit + "/" + shot.repeat);
  }
  const bool revisited =
      std::any_of(visits.begin(), visits.end(), [](const auto& entry) { return entry.second.size() > 1; });
  const auto note = [findings](bool is_missing, const char* code, Missing what) {
    if (is_missing) findings->push_back(Found(Severity::kNote, code, MissingFromData(what)));
  };
  note(!problem.sigma_is_stated(), "no_sigma", Missing::kSigma);
  note(!any([](const Shot& shot) { return !shot.approach.empty(); }), "no_approach", Missing::kApproach);
  note(!revisited, "no_visits", Missing::kVisits);
  note(!any([](const Shot& shot) { return shot.has_time; }), "no_time", Missing::kTime);
  note(!any([](const Shot& shot) { return shot.has_temperature; }), "no_temperature", Missing::kTemperature);
  const bool any_pose = std::any_of(data.observations.begin(), data.observations.end(),
                                    [](const Observation& row) { return !row.is_point(); });
  note(data.markers.size() < 3 && !any_pose, "few_markers", Missing::kMarkers);
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
  const std::vector<FirstRow> configurations = CalibrationConfigurations(problem);
  for (int j = 0; j < problem.robot().num_joints(); ++j) {
    MeasuredRange range;
    range.joint = j;
    bool first = true;
    for (const auto& [c, row] : configurations) {
      const double q = problem.data().configurations[c].q[j];
      range.least = first ? q : std::min(range.least, q);
      range.most = first ? q : std::max(range.most, q);
      first = false;
    }
    const Joint& joint = problem.robot().chain.joints[j];
    if (joint.min && joint.max && *joint.max > *joint.min)
      range.share = (range.most - range.least) / (*joint.max - *joint.min);
    ranges.push_back(range);
  }
  return ranges;
}

std::vector<MeasuredRange> StillJointsOf(const CalibrationProblem& problem) {
  std::vector<MeasuredRange> still;
  for (const MeasuredRange& range : MeasuredRangesOf(problem)) {
    if (IsStill(problem, range)) still.push_back(range);
  }
  return still;
}

std::vector<Finding> LintData(const CalibrationProblem& problem) {
  std::vector<Finding> findings;
  for (const std::string& warning : problem.data().warnings)
    findings.push_back({Severity::kWarning, "reader", warning, "", {}});
  for (const auto lint : {LintCopiedPoints, LintOrientation, LintJoints, LintCounts, LintDuplicatedPoses, LintLoads}) {
    CheckInterruption();
    lint(problem, &findings);
  }
  for (Finding& finding : LintDeflections(problem)) findings.push_back(std::move(finding));
  LintColumns(problem, &findings);
  return findings;
}

}  // namespace sagitta
