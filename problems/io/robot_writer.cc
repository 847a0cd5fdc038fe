#include <nlohmann/json.hpp>

#include "problems/io/effect_entries.h"
#include "problems/io/robot_file.h"
#include "problems/io/units.h"
#include "problems/io/yaml_writer.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

double Millimetres(double metres) { return ToUnit(metres, UnitNamed("mm")); }
double Degrees(double radians) { return ToUnit(radians, UnitNamed("deg")); }
double Micro(double si) { return ToUnit(si, UnitNamed("urad")); }

// A value whose key names its unit: deg for rotations, mm for translations.
void Put(const std::string& stem, bool is_angle, double si, Json* map) {
  (*map)[stem + (is_angle ? "_deg" : "_mm")] = is_angle ? Degrees(si) : Millimetres(si);
}

Json TripleToJson(const Vector3<double>& si, double (*convert)(double)) {
  return Json::array({convert(si.x()), convert(si.y()), convert(si.z())});
}

Json JointToJson(const Joint& joint) {
  const bool revolute = joint.type == JointType::kRevolute;
  Json json = {{"name", joint.name}, {"type", revolute ? "revolute" : "prismatic"}};
  if (joint.min) Put("min", revolute, *joint.min, &json);
  if (joint.max) Put("max", revolute, *joint.max, &json);
  return json;
}

Json TransformToJson(const Chain& chain, const ElementaryTransform& transform) {
  const std::string name = std::string(transform.is_rotation() ? "R" : "T") + "xyz"[static_cast<int>(transform.axis)];
  Json json;
  if (transform.has_joint()) {
    json[name] = chain.joints[transform.joint].name;
    if (transform.sign < 0) json["sign"] = -1;
    if (transform.nominal != 0.0) Put("offset", transform.is_rotation(), transform.nominal, &json);
  } else {
    Put(name, transform.is_rotation(), transform.nominal, &json);
  }
  if (!transform.error.empty()) json["error"] = transform.error;
  return json;
}

Json ChainToJson(const Chain& chain) {
  Json json = Json::array();
  for (const ElementaryTransform& transform : chain.transforms) {
    if (!transform.tilt_slot) json.push_back(TransformToJson(chain, transform));
  }
  return json;
}

Json DhToJson(const Chain& chain, const DhTable& table) {
  Json links = Json::array();
  for (const DhLink& link : table.links) {
    Json json = {{"joint", chain.joints[link.joint].name}};
    Put("a", false, link.a, &json);
    Put("alpha", true, link.alpha, &json);
    Put("d", false, link.d, &json);
    Put("theta", true, link.theta, &json);
    if (link.beta != 0.0) Put("beta", true, link.beta, &json);
    links.push_back(json);
  }
  Json json;
  json["convention"] = WordOf(table.convention);
  json["links"] = links;
  if (!table.flange_xyz.isZero(0.0) || !table.flange_rpy.isZero(0.0)) {
    json["flange"]["xyz_mm"] = TripleToJson(table.flange_xyz, Millimetres);
    json["flange"]["rpy_deg"] = TripleToJson(table.flange_rpy, Degrees);
  }
  return json;
}

Json KinematicsToJson(const Chain& chain, const std::optional<DhTable>& dh) {
  return dh ? Json{{"dh", DhToJson(chain, *dh)}} : Json{{"chain", ChainToJson(chain)}};
}

Json ComplianceToJson(const Joint& joint, const JointCompliance& compliance) {
  const bool revolute = joint.type == JointType::kRevolute;
  const std::string key = revolute ? "k_urad_per_Nm" : "k_um_per_N";
  if (!compliance.is_table) return {{key, Micro(compliance.nodes.front().k)}};
  Json table = Json::array();
  for (const JointCompliance::Node& node : compliance.nodes) {
    Json entry;
    Put("q", revolute, node.q, &entry);
    entry[key] = Micro(node.k);
    table.push_back(entry);
  }
  return {{"table", table}};
}

Json CompensatorToJson(const Chain& chain, const GravityCompensator& compensator) {
  Json json = {{"joint", chain.joints[compensator.joint].name}, {"type", "spring"}};
  Put("L", false, compensator.L, &json);
  Put("a_x", false, compensator.a_x, &json);
  Put("a_y", false, compensator.a_y, &json);
  Put("s0", false, compensator.s0, &json);
  json["Kc_N_per_mm"] = ToUnit(compensator.Kc, Unit{"N_per_mm", 1e3, 1.0});
  json["preload"] = compensator.preload;
  if (compensator.zero) Put("zero", true, *compensator.zero, &json);
  PutPriors(SpringParameters(), compensator.prior_sigmas, &json);
  return json;
}

}  // namespace

Json RobotToJson(const Robot& robot) {
  const Chain& chain = robot.chain;
  Json json;
  json["schema"] = "sagitta/robot/1";
  if (!robot.name.empty()) json["name"] = robot.name;
  json["joints"] = Json::array();
  for (const Joint& joint : chain.joints) json["joints"].push_back(JointToJson(joint));
  json["kinematics"] = KinematicsToJson(chain, robot.dh);
  for (const Coupling& coupling : chain.couplings) {
    json["coupling"].push_back({{"joint", chain.joints[coupling.joint].name},
                                {"driver", chain.joints[coupling.driver].name},
                                {"ratio", coupling.ratio}});
  }
  for (const JointCompliance& compliance : robot.compliances) {
    const Joint& joint = chain.joints[compliance.joint];
    json["compliance"][joint.name] = ComplianceToJson(joint, compliance);
  }
  if (robot.gravity_compensator) json["gravity_compensator"] = CompensatorToJson(chain, *robot.gravity_compensator);
  json["effects"] = Json::array();
  for (const EffectSpec& effect : robot.effects) json["effects"].push_back(EffectToJson(robot, effect));
  if (robot.controller) {
    json["controller_kinematics"] = KinematicsToJson(robot.controller->chain, robot.controller->dh);
  }
  if (robot.reference_temperature) json["reference_temperature_degC"] = *robot.reference_temperature;
  return json;
}

std::string RobotToYaml(const Robot& robot) { return JsonToYaml(RobotToJson(robot)); }

}  // namespace sagitta
