#include "estimator/results/loading_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/results/json_numbers.h"
#include "problems/loads.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 3> kFrameNames = {"measurement", "base", "flange"};
constexpr std::array<const char*, 2> kGravityFrames = {"base", "measurement"}, kTorques = {"measured", "model"};
constexpr std::array<WrenchFrame, 3> kFrames = {WrenchFrame::kMeasurement, WrenchFrame::kBase, WrenchFrame::kFlange};

Json Numbers(const Vector3<double>& v) { return Json::array({v.x(), v.y(), v.z()}); }

Vector3<double> Metres(const JsonValue& millimetres) { return millimetres.Triple() / 1e3; }

Json LoadToJson(const LoadSpec& load) {
  Json json = Json::object();
  if (load.mass) json["mass_kg"] = *load.mass;
  if (load.point) json["point_mm"] = Millimetres(*load.point);
  for (size_t i = 0; i < kFrames.size(); ++i) {
    if (load.frame == kFrames[i]) json["frame"] = kFrameNames[i];
  }
  return json;
}

// Where a text stands in a list; fails where it is none of them.
template <size_t n>
size_t PlaceAmong(const JsonValue& json, const std::array<const char*, n>& names) {
  const std::string text = json.Text();
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end())
    json.Fail("'" + text + "' is not known", "known: " + Joined(std::vector<std::string>(names.begin(), names.end())));
  return static_cast<size_t>(found - names.begin());
}

LoadSpec ReadLoad(const JsonValue& json) {
  LoadSpec load;
  if (const auto mass = json.Find("mass_kg")) load.mass = mass->NotNegativeNumber();
  if (const auto point = json.Find("point_mm")) load.point = Metres(*point);
  if (const auto frame = json.Find("frame")) load.frame = kFrames[PlaceAmong(*frame, kFrameNames)];
  return load;
}

void ReadGravity(const JsonValue& json, Experiment* experiment) {
  experiment->gravity_direction = json.Get("direction").Triple();
  if (!(std::abs(experiment->gravity_direction.norm() - 1.0) < 1e-6)) {
    json.Get("direction").Fail("a direction of length 1 is expected");
  }
  experiment->gravity_in_base = PlaceAmong(json.Get("frame"), kGravityFrames) == 0;
  experiment->gravity = json.Get("m_per_s2").PositiveNumber();
}

ConditionOrigins ReadOrigins(const JsonValue& json) {
  ConditionOrigins origins;
  for (const auto& [station, time] : json.Get("first_time_s").Entries()) origins.first_time[station] = time.Number();
  origins.mean_temperature = json.Get("mean_temperature_degC").Number();
  if (const auto time = json.Find("campaign_time_s")) origins.campaign_time = time->Number();
  return origins;
}

}  // namespace

Json LoadingToJson(const Experiment& experiment, const Measurements& data) {
  Json json = Json::object();
  if (experiment.load_point) json["load_point_mm"] = Millimetres(*experiment.load_point);
  json["loads"] = Json::object();
  for (const auto& [name, load] : experiment.loads) json["loads"][name] = LoadToJson(load);
  json["tool"] = {{"mass_kg", experiment.tool_mass}, {"com_mm", Millimetres(experiment.tool_com)}};
  json["gravity"] = {{"direction", Numbers(experiment.gravity_direction)},
                     {"frame", kGravityFrames[experiment.gravity_in_base ? 0 : 1]},
                     {"m_per_s2", experiment.gravity}};
  json["torques"] = kTorques[experiment.torques_measured ? 0 : 1];
  const ConditionOrigins origins = OriginsOf(data, experiment);
  json["origins"] = {{"first_time_s", origins.first_time}, {"mean_temperature_degC", origins.mean_temperature}};
  if (origins.campaign_time) json["origins"]["campaign_time_s"] = *origins.campaign_time;
  return json;
}

void ReadLoading(const JsonValue& json, Experiment* experiment) {
  if (const auto point = json.Find("load_point_mm")) experiment->load_point = Metres(*point);
  for (const auto& [name, load] : json.Get("loads").Entries()) experiment->loads[name] = ReadLoad(load);
  const JsonValue tool = json.Get("tool");
  experiment->tool_mass = tool.Get("mass_kg").NotNegativeNumber();
  experiment->tool_com = Metres(tool.Get("com_mm"));
  ReadGravity(json.Get("gravity"), experiment);
  if (const auto torques = json.Find("torques")) experiment->torques_measured = PlaceAmong(*torques, kTorques) == 0;
  if (const auto origins = json.Find("origins")) experiment->origins = ReadOrigins(*origins);
}

}  // namespace sagitta
