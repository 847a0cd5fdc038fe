#include "estimator/results/loading_json.h"

#include <array>

#include "problems/io/units.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 3> kFrameNames = {"measurement", "base", "flange"};
constexpr std::array<WrenchFrame, 3> kFrames = {WrenchFrame::kMeasurement, WrenchFrame::kBase, WrenchFrame::kFlange};

Json Numbers(const Vector3<double>& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json Millimetres(const Vector3<double>& metres) {
  Json json = Json::array();
  for (const double metre : metres) json.push_back(ToUnit(metre, UnitNamed("mm")));
  return json;
}

Vector3<double> Triple(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

Vector3<double> Metres(const Json& millimetres) { return Triple(millimetres) / 1e3; }

Json LoadToJson(const LoadSpec& load) {
  Json json = Json::object();
  if (load.mass) json["mass_kg"] = *load.mass;
  if (load.point) json["point_mm"] = Millimetres(*load.point);
  for (size_t i = 0; i < kFrames.size(); ++i) {
    if (load.frame == kFrames[i]) json["frame"] = kFrameNames[i];
  }
  return json;
}

LoadSpec ReadLoad(const Json& json) {
  LoadSpec load;
  if (json.contains("mass_kg")) load.mass = json.at("mass_kg").get<double>();
  if (json.contains("point_mm")) load.point = Metres(json.at("point_mm"));
  for (size_t i = 0; i < kFrames.size(); ++i) {
    if (json.value("frame", "") == kFrameNames[i]) load.frame = kFrames[i];
  }
  return load;
}

}  // namespace

Json LoadingToJson(const Experiment& experiment, const Measurements& data) {
  Json json = Json::object();
  if (experiment.load_point) json["load_point_mm"] = Millimetres(*experiment.load_point);
  json["loads"] = Json::object();
  for (const auto& [name, load] : experiment.loads) json["loads"][name] = LoadToJson(load);
  json["tool"] = {{"mass_kg", experiment.tool_mass}, {"com_mm", Millimetres(experiment.tool_com)}};
  json["gravity"] = {{"direction", Numbers(experiment.gravity_direction)},
                     {"frame", experiment.gravity_in_base ? "base" : "measurement"},
                     {"m_per_s2", experiment.gravity}};
  json["torques"] = experiment.torques_measured ? "measured" : "model";
  const ConditionOrigins origins = OriginsOf(data, experiment);
  json["origins"] = {{"first_time_s", origins.first_time}, {"mean_temperature_degC", origins.mean_temperature}};
  if (origins.campaign_time) json["origins"]["campaign_time_s"] = *origins.campaign_time;
  return json;
}

void ReadLoading(const Json& json, Experiment* experiment) {
  if (json.contains("load_point_mm")) experiment->load_point = Metres(json.at("load_point_mm"));
  for (const auto& [name, load] : json.at("loads").items()) experiment->loads[name] = ReadLoad(load);
  experiment->tool_mass = json.at("tool").at("mass_kg").get<double>();
  experiment->tool_com = Metres(json.at("tool").at("com_mm"));
  experiment->gravity_direction = Triple(json.at("gravity").at("direction"));
  experiment->gravity_in_base = json.at("gravity").at("frame") == "base";
  experiment->gravity = json.at("gravity").at("m_per_s2").get<double>();
  experiment->torques_measured = json.value("torques", "model") == "measured";
  if (!json.contains("origins")) return;
  const Json& origins = json.at("origins");
  experiment->origins = {{},
                         origins.at("first_time_s").get<std::map<std::string, double>>(),
                         origins.at("mean_temperature_degC").get<double>()};
  if (origins.contains("campaign_time_s"))
    experiment->origins->campaign_time = origins.at("campaign_time_s").get<double>();
}

}  // namespace sagitta
