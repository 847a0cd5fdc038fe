#include "tools/report/inspection_report.h"

#include <algorithm>
#include <cmath>

#include "estimator/report/inspection_words.h"
#include "problems/io/units.h"
#include "tools/report/charts.h"
#include "tools/report/remedies.h"
#include "tools/report/report_html.h"

namespace sagitta {
namespace {

constexpr size_t kShownRows = 5;
constexpr size_t kShownGroups = 8;
constexpr size_t kShownLeverage = 8;
constexpr size_t kShownNames = 8;

std::string NoiseInWords(const Inspection& inspection) {
  if (!inspection.sigma_is_stated) return "No sigma is stated: that is assumed to be the noise in what follows.";
  std::string words = "The stated sigmas are " + Fixed(1e3 * inspection.stated.point, 4) + " mm RMS";
  if (inspection.stated.rotation > 0.0)
    words += " per coordinate of a point and " + Significant(1e3 * inspection.stated.rotation, 4) +
             " mrad per axis of a rotation";
  if (inspection.scale < 1.05) return words + ".";
  words += "; what follows assumes them " + Significant(inspection.scale, 3) + " times as large";
  if (!inspection.sigma_differs) return words + ".";
  return words +
         ". Where the arm scatters by more than these, 'sagitta calibrate' weighs by both: its figure before may be "
         "another.";
}

std::string MisfitInWords(const Inspection& inspection) {
  const double misfit = inspection.aligned.distance_rms;
  if (!std::isfinite(misfit))
    return "The nominal robot finds no equilibrium under its loads: nothing can be predicted.";
  const std::string how = inspection.sigma_differs ? " fitted with the rows' sigmas as weights" : " fitted";
  std::string words = "The nominal robot, base and markers" + how + ", misses by " + Fixed(1e3 * misfit, 3) +
                      " mm; a linear fit of all unknowns would leave " +
                      Fixed(1e3 * std::sqrt(3.0) * inspection.linear.point, 3) + " mm (both RMS of distances)";
  if (inspection.linear.rotation > 0.0)
    words += ", and of rotations " + Significant(1e3 * inspection.linear.rotation, 3) + " mrad (RMS per axis)";
  return words + ". " + NoiseInWords(inspection);
}

Section Overview(const CalibrationProblem& problem, const Inspection& inspection) {
  const auto count = [&](Severity severity) { return std::to_string(inspection.Count(severity)); };
  Section section;
  section.title = (problem.robot().name.empty() ? "Robot" : problem.robot().name) + ": the data before any estimate";
  section.paragraphs = {Plural(static_cast<int>(problem.data().NumRows()), "observation") + " of " +
                            Plural(static_cast<int>(problem.data().configurations.size()), "configuration") + ", " +
                            Plural(static_cast<int>(problem.data().stations.size()), "station") + ", " +
                            Plural(static_cast<int>(problem.data().markers.size()), "marker") + ".",
                        "Findings: " + count(Severity::kSerious) + " serious, " +
                            Plural(inspection.Count(Severity::kWarning), "warning") + ", " +
                            Plural(inspection.Count(Severity::kNote), "note") + ".",
                        MisfitInWords(inspection)};
  const std::string unread = NotReadInWords(problem.data().unread_columns);
  if (!unread.empty()) section.paragraphs.push_back(unread);
  return section;
}

Section FindingSection(const Inspection& inspection, Severity severity, const std::string& title) {
  Section section;
  section.title = title;
  std::vector<WordsAndRemedy> of_all_rows;
  for (const Finding& finding : inspection.findings) {
    if (finding.severity != severity) continue;
    if (finding.rows.empty() && !finding.remedy.empty()) {
      of_all_rows.emplace_back(finding.words, finding.remedy);
      continue;
    }
    std::string words = "- " + finding.words + (finding.words.back() == '?' ? "" : ".");
    if (!finding.remedy.empty()) words += " Remedy: " + finding.remedy + ".";
    if (!finding.rows.empty()) words += " Rows: " + Enumerate(finding.rows, kShownRows) + ".";
    section.paragraphs.push_back(words);
  }
  for (const std::string& words : GroupedByRemedy(of_all_rows, kShownRows)) section.paragraphs.push_back(words);
  return section;
}

Section ReadingSection(const Inspection& inspection) {
  Section section;
  section.title = "Readings of robot and rows";
  section.header = {"reading", "aligned RMS distance mm"};
  for (const ReadingMisfit& reading : inspection.reading.readings)
    section.rows.push_back({reading.reading, Fixed(1e3 * reading.rms, 3)});
  return section;
}

Section JointSection(const CalibrationProblem& problem, const Inspection& inspection) {
  Section section;
  section.title = "Joint ranges covered";
  section.header = {"joint", "from", "to", "unit", "of the limits"};
  for (const MeasuredRange& range : inspection.joints) {
    const Joint& joint = problem.robot().chain.joints[range.joint];
    const JointUnit unit = UnitOf(joint);
    section.rows.push_back({joint.name, Fixed(unit.factor * range.least, 1), Fixed(unit.factor * range.most, 1),
                            unit.name, range.share > 0.0 ? Fixed(100.0 * range.share, 0) + " %" : "-"});
  }
  return section;
}

Section ParameterSection(const Inspection& inspection) {
  Section section;
  section.title = "Identifiability: standard deviations to expect";
  section.header = {"name", "sigma", "unit", ""};
  for (const ParameterEstimate& row : inspection.parameters) {
    const QuantityTraits& traits = TraitsOf(row.quantity);
    section.rows.push_back({row.name, row.identifiable ? Significant(row.sigma / traits.si_per_unit, 2) : "-",
                            traits.unit,
                            !row.identifiable ? "not determined"
                            : row.weak        ? "weak"
                                              : ""});
  }
  section.paragraphs = {"Rank " + std::to_string(inspection.identifiability.rank) + " of " +
                        std::to_string(inspection.unknowns) + " unknowns, condition " +
                        Significant(inspection.identifiability.condition, 3) + " of the column-normalised Jacobian."};
  for (size_t i = 0; i < std::min(kShownGroups, inspection.groups.size()); ++i) {
    const CorrelationGroup& group = inspection.groups[i];
    section.paragraphs.push_back("- hand in hand (correlation up to " + Fixed(group.largest, 3) +
                                 "): " + Enumerate(group.names, kShownNames) + ".");
  }
  return section;
}

Section LeverageSection(const CalibrationProblem& problem, const Inspection& inspection) {
  Section section;
  section.title = "Leverage of configurations, highest first";
  section.header = {"config", "mean", "largest"};
  for (size_t i = 0; i < std::min(kShownLeverage, inspection.leverage.size()); ++i) {
    const ConfigurationLeverage& entry = inspection.leverage[i];
    section.rows.push_back(
        {problem.data().configurations[entry.configuration].id, Fixed(entry.mean, 3), Fixed(entry.most, 3)});
  }
  section.paragraphs = {
      "mean: over its rows, of 1 at most. largest: of any combination of its rows; at 1 no other configuration checks "
      "it."};
  return section;
}

}  // namespace

std::vector<Section> SummariseInspection(const CalibrationProblem& problem, const Inspection& inspection) {
  std::vector<Section> sections = {Overview(problem, inspection)};
  const auto add = [&](const Section& section) {
    if (!section.paragraphs.empty() || !section.rows.empty()) sections.push_back(section);
  };
  add(FindingSection(inspection, Severity::kSerious, "Serious"));
  add(FindingSection(inspection, Severity::kWarning, "Warnings"));
  add(FindingSection(inspection, Severity::kNote, "Notes: what these data cannot answer"));
  if (inspection.reading.readings.size() > 1) add(ReadingSection(inspection));
  add(JointSection(problem, inspection));
  if (!inspection.parameters.empty()) add(ParameterSection(inspection));
  if (!inspection.leverage.empty()) add(LeverageSection(problem, inspection));
  return sections;
}

std::string InspectionToHtml(const CalibrationProblem& problem, const Inspection& inspection,
                             const Provenance& provenance) {
  std::vector<Section> sections = SummariseInspection(problem, inspection);
  std::vector<double> rank, leverage;
  for (const ConfigurationLeverage& entry : inspection.leverage) {
    rank.push_back(static_cast<double>(rank.size() + 1));
    leverage.push_back(entry.mean);
  }
  if (leverage.size() > 1) {
    sections.back().pictures = {
        CurvePicture("Leverage of all configurations, highest first", "rank", rank, "mean leverage", leverage)};
  }
  return SectionsToPage(sections, provenance);
}

}  // namespace sagitta
