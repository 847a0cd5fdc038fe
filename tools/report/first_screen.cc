#include "tools/report/first_screen.h"

#include <algorithm>
#include <cmath>

#include "estimator/report/validation_words.h"
#include "models/constants.h"
#include "problems/text.h"
#include "tools/report/histograms.h"
#include "tools/report/remedies.h"
#include "tools/report/summary.h"

namespace sagitta {
namespace {

constexpr size_t kShown = 10;         // suspect rows
constexpr size_t kShownOfRemedy = 3;  // of one remedy

// Of a length of that size (m) in mm: a micrometre, and two digits of what is smaller.
int DecimalsOf(double length) { return std::max(3, DecimalsFor(1e3 * length)); }

// "33 poses", "33 poses (144 positions)": each marker, station, load and approach of a pose by itself.
std::string PosesInWords(int poses, int positions) {
  std::string words = std::to_string(poses) + (poses == 1 ? " pose" : " poses");
  if (positions == poses) return words;
  return words + " (" + std::to_string(positions) + " positions of markers)";
}

// In the words of ISO 9283:1998.
std::string IsoInWords(const Trust& trust) {
  const PoseAccuracy& accuracy = trust.Quoted().pose_accuracy;
  const PoseRepeatability& repeatability = trust.repeatability;
  const int decimals = DecimalsOf(trust.Quoted().rms);
  std::string words = "ISO 9283: pose accuracy AP " + Millimetres(accuracy.mean, decimals) + " mm in the mean, " +
                      Millimetres(accuracy.largest, decimals) + " mm at most, of " +
                      PosesInWords(accuracy.poses, accuracy.positions) + " not fitted; ";
  if (accuracy.scatter > accuracy.mean) {
    words += "the readings of one arrival, of which it goes by the mean, scatter by " +
             Millimetres(accuracy.scatter, decimals) + " mm (RMS); ";
  }
  const std::string limited = RepeatabilityIsLimited(repeatability);
  if (repeatability.poses == 0) return words + "pose repeatability RP: " + limited + ".";
  const std::string fewest = std::to_string(repeatability.fewest), most = std::to_string(repeatability.most);
  return words + "pose repeatability RP " + Millimetres(repeatability.mean, decimals) + " mm in the mean, " +
         Millimetres(repeatability.largest, decimals) + " mm at most, of " +
         PosesInWords(repeatability.poses, repeatability.positions) + " with " + fewest +
         (fewest == most ? "" : " to " + most) + " arrivals (the standard asks for 30" +
         (limited.empty() ? "" : "; " + limited) + "), the instrument's noise included.";
}

bool HasUnseen(const Trust& trust) { return trust.Quoted().points > 0; }

Section Unseen(const Trust& trust) {
  const UnseenPoints& quoted = trust.Quoted();
  Section section;
  const bool is_holdout = trust.holdout.points > 0;
  section.title = "On points that were not fitted (" + std::to_string(quoted.points) + ", " +
                  (is_holdout ? "held out" : std::to_string(trust.cross_validation.folds) + "-fold cross-validation") +
                  "), distances in mm";
  section.header = {"mm", "RMS", "P50", "P95", "max"};
  const int decimals = DecimalsOf(quoted.rms);
  const auto mm = [decimals](double metres) { return Millimetres(metres, decimals); };
  const auto add = [&](const std::string& name, const UnseenPoints& points) {
    if (points.points == 0) return;
    section.rows.push_back(
        {name, mm(points.distance_rms), mm(points.distance_p50), mm(points.distance_p95), mm(points.distance_max)});
  };
  add("before (nominal robot)", trust.nominal);
  add("after", quoted);
  if (is_holdout) add("after, cross-validation of the rest", trust.cross_validation.unseen);
  std::vector<std::string> worst;
  for (const FarPose& pose : quoted.worst) worst.push_back(pose.configuration + " " + mm(pose.distance));
  section.paragraphs = {"Worst poses: " + Joined(worst) + " mm."};
  if (quoted.predicted_rms > 0.0) {
    section.paragraphs.push_back("Coordinate RMS " + mm(quoted.rms) + " mm, predicted " + mm(quoted.predicted_rms) +
                                 " mm (" + PValueInWords(quoted.p_value) + ").");
  }
  const std::string left_out = LeftOutInWords(trust.cross_validation.unpredictable);
  if (!left_out.empty()) section.paragraphs.push_back(left_out);
  section.paragraphs.push_back(IsoInWords(trust));
  section.pictures = BeforeAndAfter(trust.nominal, quoted);
  return section;
}

std::vector<Section> Held(const Estimate& estimate) {
  std::vector<Section> sections;
  const std::vector<Direction> open = LeftOpen(estimate);
  const size_t for_stated = estimate.identifiability.unidentifiable.size() - open.size();
  if (!open.empty()) {
    Section section;
    section.title = "Not measured (held): " + std::to_string(open.size());
    section.paragraphs = DirectionsInWords(open, kShownOfRemedy);
    sections.push_back(section);
  }
  if (for_stated == 0) return sections;
  Section section;
  section.title = "Held for the stated standard deviations alone: " + std::to_string(for_stated);
  section.paragraphs = {
      "With noise as small as the residuals these data determine them. Remedy: state the standard deviations that the "
      "readings have, in the unit of their column, or none, and calibrate again."};
  sections.push_back(section);
  return sections;
}

// What the noise, the intervals and the agreement of parts hold with: a robust loss leaves outliers out.
std::string WhatSuspectsDo(const Calibration& calibration) {
  const NoiseReport& noise = calibration.estimate.noise_report;
  const std::vector<Suspect>& suspects = calibration.trust.suspects;
  const auto is_left_out = [&](const Suspect& suspect) {
    return !noise.systematic && std::any_of(noise.outliers.begin(), noise.outliers.end(), [&](const Outlier& outlier) {
      return outlier.observation == suspect.observation;
    });
  };
  const auto left_out = static_cast<size_t>(std::count_if(suspects.begin(), suspects.end(), is_left_out));
  const std::string first = "Decide on these rows first: ";
  const std::string all = "what is said of the noise, the intervals and the agreement of parts holds with ";
  if (left_out == 0) return first + all + "them.";
  const std::string loss = " left out of all figures by the loss of the experiment";
  if (left_out == suspects.size()) {
    const bool is_one = left_out == 1;
    return (is_one ? "This row is" : "These rows are") + loss + ": " + all + "the others alone. " +
           (is_one ? "Correct it or leave it out for good." : "Correct them or leave them out for good.");
  }
  return first + std::to_string(left_out) + (left_out == 1 ? " is" : " are") + loss + "; " + all + "the rest of them.";
}

}  // namespace

Section SuspectRows(const Calibration& calibration, const std::string& where) {
  const Trust& trust = calibration.trust;
  Section section;
  section.title = "Suspect rows: " + std::to_string(trust.suspects.size());
  for (size_t i = 0; i < std::min(kShown, trust.suspects.size()); ++i)
    section.paragraphs.push_back("- " + trust.suspects[i].row + ": " + trust.suspects[i].words);
  if (trust.suspects.size() > kShown)
    section.paragraphs.push_back("- and " + std::to_string(trust.suspects.size() - kShown) + " more" + where);
  section.paragraphs.push_back(WhatSuspectsDo(calibration));
  return section;
}

std::vector<Section> FirstScreen(const Calibration& calibration) {
  const Trust& trust = calibration.trust;
  Section first;
  first.title = calibration.problem.robot().name.empty() ? "Calibration" : calibration.problem.robot().name;
  first.paragraphs = {trust.verdict.words};
  if (!trust.model_error_words.empty()) first.paragraphs.push_back("Model error: " + trust.model_error_words + ".");
  if (!trust.torques.words.empty()) first.paragraphs.push_back(trust.torques.words);
  std::vector<Section> sections = {first};
  if (HasUnseen(trust)) sections.push_back(Unseen(trust));
  for (Section& section : Held(calibration.estimate)) sections.push_back(std::move(section));
  if (!trust.suspects.empty()) sections.push_back(SuspectRows(calibration, ", in estimate.json under suspects"));
  return sections;
}

size_t SizeOfFirstScreen(const Calibration& calibration) {
  const size_t not_measured = Held(calibration.estimate).size();
  const size_t suspects = calibration.trust.suspects.empty() ? 0 : 1;
  return 1 + (HasUnseen(calibration.trust) ? 1 : 0) + not_measured + suspects;
}

namespace {

// Of the errors in a table of links those that are held, "" where none is.
std::string HeldInTable(const Estimate& estimate) {
  std::vector<std::string> held;
  for (const ParameterEstimate& row : estimate.table) {
    if (!row.identifiable && CoordinateKindOf(row.name) == CoordinateKind::kGeometry) held.push_back(row.name);
  }
  return held.empty() ? ""
                      : "Held where the data fit best, and meaning nothing by themselves: " + Enumerate(held) + ".";
}

}  // namespace

std::vector<Section> CorrectedTable(const Calibration& calibration) {
  const Robot& nominal = calibration.problem.robot();
  const Robot robot = calibration.problem.RobotWith(calibration.estimate.parameters);
  if (!nominal.dh || !robot.dh) return {};
  Section section;
  section.title = "Corrected table, " + WordOf(robot.dh->convention) + " DH";
  section.header = {"joint",     "a, mm",  "alpha, deg",  "d, mm",  "theta, deg",
                    "beta, deg", "Δa, mm", "Δalpha, deg", "Δd, mm", "Δtheta, deg"};
  for (size_t i = 0; i < robot.dh->links.size(); ++i) {
    const DhLink &now = robot.dh->links[i], &before = nominal.dh->links[i];
    const auto length = [](double metres) { return Fixed(1e3 * metres, 4); };
    const auto angle = [](double radians) { return Fixed(radians / kDegree, 5); };
    section.rows.push_back({robot.chain.joints[now.joint].name, length(now.a), angle(now.alpha), length(now.d),
                            angle(now.theta), angle(now.beta), length(now.a - before.a),
                            angle(now.alpha - before.alpha), length(now.d - before.d),
                            angle(now.theta - before.theta)});
  }
  const std::string not_measured = HeldInTable(calibration.estimate);
  if (!not_measured.empty()) section.paragraphs = {not_measured};
  return {section};
}

std::vector<Section> CalibrationSections(const Calibration& calibration) {
  std::vector<Section> sections = FirstScreen(calibration);
  for (Section& section : CorrectedTable(calibration)) sections.push_back(std::move(section));
  std::vector<Section> rest = Summarise(calibration.problem, calibration.estimate, calibration.trust.model_error_sigma);
  rest.front().title = "Estimate";
  // What the first screen has said in full is not said again.
  const auto is_said = [&](const Section& section) {
    return !section.paragraphs.empty() && section.header.empty() &&
           std::any_of(sections.begin(), sections.end(),
                       [&](const Section& other) { return other.paragraphs == section.paragraphs; });
  };
  for (Section& section : rest) {
    if (!is_said(section)) sections.push_back(std::move(section));
  }
  return sections;
}

}  // namespace sagitta
