#include "tools/inspection_json.h"

#include <algorithm>
#include <cmath>

#include "tools/charts.h"
#include "tools/report_html.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr size_t kShownRows = 5;
constexpr size_t kShownGroups = 8;
constexpr size_t kShownLeverage = 8;
constexpr size_t kShownNames = 8;

struct JointUnit {
  double factor;
  const char* name;
};
JointUnit UnitOf(const Joint& joint) {
  return joint.type == JointType::kRevolute ? JointUnit{1.0 / kDegree, "deg"} : JointUnit{1e3, "mm"};
}

Json FindingsToJson(const std::vector<Finding>& findings) {
  Json json = Json::array();
  for (const Finding& finding : findings) {
    json.push_back({{"severity", SeverityName(finding.severity)},
                    {"code", finding.code},
                    {"words", finding.words},
                    {"remedy", finding.remedy},
                    {"rows", finding.rows}});
  }
  return json;
}

Json JointsToJson(const CalibrationProblem& problem, const Inspection& inspection) {
  Json json = Json::array();
  for (const JointRange& range : inspection.joints) {
    const Joint& joint = problem.robot.chain.joints[range.joint];
    const JointUnit unit = UnitOf(joint);
    json.push_back({{"name", joint.name},
                    {"min", unit.factor * range.least},
                    {"max", unit.factor * range.most},
                    {"unit", unit.name}});
    json.back()["share_of_limits"] = range.share > 0.0 ? Json(range.share) : Json(nullptr);
  }
  return json;
}

Json ParametersToJson(const Inspection& inspection) {
  Json json = Json::array();
  for (const ParameterEstimate& row : inspection.parameters) {
    const QuantityTraits& traits = TraitsOf(row.quantity);
    json.push_back({{"name", row.name}, {"unit", traits.unit}});
    json.back()["expected_sigma"] = row.identifiable ? Json(row.sigma / traits.si_per_unit) : Json(nullptr);
    json.back()["identifiable"] = row.identifiable;
    json.back()["weak"] = row.weak;
  }
  return json;
}

Json LeverageToJson(const CalibrationProblem& problem, const Inspection& inspection) {
  Json json = Json::array();
  for (const ConfigurationLeverage& entry : inspection.leverage) {
    json.push_back({{"config", problem.data.configurations[entry.configuration].id},
                    {"leverage", entry.mean},
                    {"largest", entry.most}});
  }
  return json;
}

std::string Joined(const std::vector<std::string>& names, size_t shown) {
  std::string text;
  for (size_t i = 0; i < std::min(shown, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > shown) text += " and " + std::to_string(names.size() - shown) + " more";
  return text;
}

std::string NoiseInWords(const Inspection& inspection) {
  if (!inspection.sigma_is_stated) return "No sigma is stated: that is taken as the noise in what follows.";
  std::string words = "The stated sigmas are " + Fixed(1e3 * inspection.stated_rms, 4) + " mm RMS";
  if (inspection.scale < 1.05) return words + ".";
  return words + "; what follows takes them " + Significant(inspection.scale, 3) + " times as large.";
}

std::string MisfitInWords(const Inspection& inspection) {
  const double misfit = inspection.aligned.distance_rms;
  if (!std::isfinite(misfit))
    return "The nominal robot finds no equilibrium under its loads: nothing can be predicted.";
  return "The aligned nominal robot misses by " + Fixed(1e3 * misfit, 3) +
         " mm RMS distance; a linear fit of all unknowns would leave " + Fixed(1e3 * inspection.linear_rms, 4) +
         " mm RMS per coordinate. " + NoiseInWords(inspection);
}

Section Overview(const CalibrationProblem& problem, const Inspection& inspection) {
  const auto count = [&](Severity severity) { return std::to_string(inspection.Count(severity)); };
  Section section;
  section.title = (problem.robot.name.empty() ? "Robot" : problem.robot.name) + ": the data before any estimate";
  section.paragraphs = {std::to_string(problem.data.observations.size()) + " observations of " +
                            std::to_string(problem.data.configurations.size()) + " configurations, " +
                            std::to_string(problem.data.stations.size()) + " station(s), " +
                            std::to_string(problem.data.markers.size()) + " marker(s).",
                        "Findings: " + count(Severity::kSerious) + " serious, " + count(Severity::kWarning) +
                            " warnings, " + count(Severity::kNote) + " notes.",
                        MisfitInWords(inspection)};
  return section;
}

Section FindingSection(const Inspection& inspection, Severity severity, const std::string& title) {
  Section section;
  section.title = title;
  for (const Finding& finding : inspection.findings) {
    if (finding.severity != severity) continue;
    std::string words = "- " + finding.words + ".";
    if (!finding.remedy.empty()) words += " Remedy: " + finding.remedy + ".";
    if (!finding.rows.empty()) words += " Rows: " + Joined(finding.rows, kShownRows) + ".";
    section.paragraphs.push_back(words);
  }
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
  for (const JointRange& range : inspection.joints) {
    const Joint& joint = problem.robot.chain.joints[range.joint];
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
                            !row.identifiable ? "not told"
                            : row.weak        ? "weak"
                                              : ""});
  }
  section.paragraphs = {"Rank " + std::to_string(inspection.identifiability.rank) + " of " +
                        std::to_string(inspection.unknowns) + " unknowns, condition " +
                        Significant(inspection.identifiability.condition, 3) + " of the column-normalised Jacobian."};
  for (size_t i = 0; i < std::min(kShownGroups, inspection.groups.size()); ++i) {
    const CorrelationGroup& group = inspection.groups[i];
    section.paragraphs.push_back("- hand in hand (correlation up to " + Fixed(group.largest, 3) +
                                 "): " + Joined(group.names, kShownNames) + ".");
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
        {problem.data.configurations[entry.configuration].id, Fixed(entry.mean, 3), Fixed(entry.most, 3)});
  }
  section.paragraphs = {
      "mean: over its rows, of 1 at most. largest: of any combination of its rows; at 1 no other configuration checks "
      "it."};
  return section;
}

}  // namespace

Json InspectionToJson(const CalibrationProblem& problem, const Inspection& inspection, const Provenance& provenance) {
  Json json = {{"schema", "sagitta/inspection/1"}, {"version", SAGITTA_VERSION}, {"command", provenance.command}};
  json["inputs"] = Json::array();
  for (const InputFile& input : provenance.inputs)
    json["inputs"].push_back({{"file", input.path}, {"sha256", input.sha256}});
  json["serious"] = inspection.Count(Severity::kSerious);
  json["warnings"] = inspection.Count(Severity::kWarning);
  json["notes"] = inspection.Count(Severity::kNote);
  json["findings"] = FindingsToJson(inspection.findings);
  json["data"] = {{"observations", problem.data.observations.size()},
                  {"configurations", problem.data.configurations.size()},
                  {"stations", problem.data.stations},
                  {"markers", problem.data.markers}};
  json["aligned"] = {{"rms_mm", 1e3 * inspection.aligned.rms},
                     {"max_mm", 1e3 * inspection.aligned.max},
                     {"distance_rms_mm", 1e3 * inspection.aligned.distance_rms},
                     {"distance_max_mm", 1e3 * inspection.aligned.distance_max}};
  json["readings"] = Json::array();
  for (const ReadingMisfit& reading : inspection.reading.readings)
    json["readings"].push_back({{"reading", reading.reading}, {"distance_rms_mm", 1e3 * reading.rms}});
  json["joints"] = JointsToJson(problem, inspection);
  json["orientation"] = {{"least", inspection.orientation.least}, {"most", inspection.orientation.most}};
  json["noise"] = {{"stated", inspection.sigma_is_stated},
                   {"stated_rms_mm", inspection.sigma_is_stated ? Json(1e3 * inspection.stated_rms) : Json(nullptr)},
                   {"linear_fit_rms_mm", 1e3 * inspection.linear_rms},
                   {"scale", inspection.sigma_is_stated ? Json(inspection.scale) : Json(nullptr)}};
  json["identifiability"] = IdentifiabilityToJson(problem, inspection.identifiability);
  json["identifiability"]["unknowns"] = inspection.unknowns;
  json["parameters"] = ParametersToJson(inspection);
  json["correlation_groups"] = Json::array();
  for (const CorrelationGroup& group : inspection.groups)
    json["correlation_groups"].push_back({{"parameters", group.names}, {"largest", group.largest}});
  json["leverage"] = LeverageToJson(problem, inspection);
  return json;
}

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
  std::vector<double> leverage;
  for (const ConfigurationLeverage& entry : inspection.leverage) leverage.push_back(entry.mean);
  std::string charts;
  if (leverage.size() > 1) charts = LineChart("leverage of all configurations, highest first", leverage, 3);
  return SectionsToPage(SummariseInspection(problem, inspection), charts, provenance);
}

}  // namespace sagitta
