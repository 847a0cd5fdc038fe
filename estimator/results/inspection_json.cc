#include "estimator/results/inspection_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/results/torques_json.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

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
  for (const MeasuredRange& range : inspection.joints) {
    const Joint& joint = problem.robot().chain.joints[range.joint];
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
    if (row.conditional) json.back()["unconditional_sigma"] = row.unconditional_sigma / traits.si_per_unit;
    json.back()["identifiable"] = row.identifiable;
    json.back()["weak"] = row.weak;
  }
  return json;
}

Json LeverageToJson(const CalibrationProblem& problem, const Inspection& inspection) {
  Json json = Json::array();
  for (const ConfigurationLeverage& entry : inspection.leverage) {
    json.push_back({{"config", problem.data().configurations[entry.configuration].id},
                    {"leverage", entry.mean},
                    {"largest", entry.most}});
  }
  return json;
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
  json["data"] = {{"observations", problem.data().NumRows()},
                  {"configurations", problem.data().configurations.size()},
                  {"stations", problem.data().stations},
                  {"markers", problem.data().markers},
                  {"not_read", problem.data().unread_columns}};
  json["aligned"] = {{"rms_mm", 1e3 * inspection.aligned.rms},
                     {"max_mm", 1e3 * inspection.aligned.max},
                     {"distance_rms_mm", 1e3 * inspection.aligned.distance_rms},
                     {"distance_max_mm", 1e3 * inspection.aligned.distance_max}};
  json["readings"] = Json::array();
  for (const ReadingMisfit& reading : inspection.reading.readings)
    json["readings"].push_back({{"reading", reading.reading}, {"distance_rms_mm", 1e3 * reading.rms}});
  json["joints"] = JointsToJson(problem, inspection);
  if (!inspection.torques.joints.empty()) json["torques"] = TorquesToJson(problem, inspection.torques);
  json["orientation"] = {{"least", inspection.orientation.least}, {"most", inspection.orientation.most}};
  json["noise"] = {{"stated", inspection.sigma_is_stated},
                   {"stated_rms_mm", inspection.sigma_is_stated ? Json(1e3 * inspection.stated.point) : Json(nullptr)},
                   {"linear_fit_rms_mm", 1e3 * inspection.linear.point},
                   {"scale", inspection.sigma_is_stated ? Json(inspection.scale) : Json(nullptr)}};
  if (inspection.linear.rotation > 0.0) {
    json["noise"]["stated_rotation_rms_mrad"] =
        inspection.sigma_is_stated ? Json(1e3 * inspection.stated.rotation) : Json(nullptr);
    json["noise"]["linear_fit_rotation_rms_mrad"] = 1e3 * inspection.linear.rotation;
  }
  json["identifiability"] = IdentifiabilityToJson(problem, inspection.identifiability);
  json["identifiability"]["unknowns"] = inspection.unknowns;
  json["parameters"] = ParametersToJson(inspection);
  json["correlation_groups"] = Json::array();
  for (const CorrelationGroup& group : inspection.groups)
    json["correlation_groups"].push_back({{"parameters", group.names}, {"largest", group.largest}});
  json["leverage"] = LeverageToJson(problem, inspection);
  return json;
}

}  // namespace sagitta
