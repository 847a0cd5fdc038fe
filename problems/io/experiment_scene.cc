// Loads, tool, gravity, markers and stations of an experiment file.
#include "problems/io/experiment_parts.h"
#include "problems/io/load_names.h"

namespace sagitta {
namespace {

WrenchFrame ReadWrenchFrame(const YamlValue& value) {
  const std::string frame = value.OneOf({"measurement", "base", "flange"});
  if (frame == "base") return WrenchFrame::kBase;
  return frame == "flange" ? WrenchFrame::kFlange : WrenchFrame::kMeasurement;
}

double ReadMass(const YamlValue& value) {
  const double mass = value.Number();
  CheckIn(allowed::kMass, mass, value);
  return mass;
}

}  // namespace

std::map<std::string, LoadSpec> ReadLoads(const YamlValue& value) {
  std::map<std::string, LoadSpec> loads;
  for (const auto& [id, entry] : value.Entries()) {
    YamlMap map(entry);
    LoadSpec load;
    if (const auto mass = map.Find("mass_kg")) load.mass = ReadMass(*mass);
    load.point = map.FindTriple("point", Dimension::kLength);
    if (const auto frame = map.Find("frame")) load.frame = ReadWrenchFrame(*frame);
    map.Finish();
    if (id == kNoLoad) entry.Fail("the load id 'none' means that there is no external load", "use another id");
    if (IsNoneInOtherLetters(id)) entry.Fail(kLoadOrNone, kHowNoneIsWritten);
    loads[id] = load;
  }
  return loads;
}

std::map<std::string, MarkerSpec> ReadMarkers(const YamlValue& value) {
  std::map<std::string, MarkerSpec> markers;
  for (const auto& [id, entry] : value.Entries()) {
    YamlMap map(entry);
    MarkerSpec marker;
    marker.point = map.FindTriple("xyz", Dimension::kLength);
    marker.rotvec = map.FindTriple("rotvec", Dimension::kAngle);
    if (const auto on = map.Find("on")) marker.on = MarkerPlace::Named(on->Text());
    if (const auto spring = map.Find("spring")) ReadChoice(*spring, &marker.spring.emplace());
    if (const auto sigma = map.Length("spring_sigma")) {
      CheckIn(allowed::kSigma, *sigma, entry);
      marker.spring_sigma = sigma;
    }
    map.Finish();
    markers[id] = marker;
  }
  return markers;
}

std::map<std::string, StationSpec> ReadStations(const YamlValue& value) {
  std::map<std::string, StationSpec> stations;
  for (const auto& [id, entry] : value.Entries()) {
    YamlMap map(entry);
    StationSpec station;
    station.base_xyz = map.FindTriple("xyz", Dimension::kLength);
    station.base_rotvec = map.FindTriple("rotvec", Dimension::kAngle);
    station.instrument_xyz = map.FindTriple("instrument", Dimension::kLength);
    if (const auto levelled = map.Find("levelled")) station.levelled = levelled->Flag();
    map.Finish();
    stations[id] = station;
  }
  return stations;
}

void ReadTool(const YamlValue& value, Experiment* experiment) {
  YamlMap map(value);
  if (const auto mass = map.Find("mass_kg")) experiment->tool_mass = ReadMass(*mass);
  experiment->tool_com = map.FindTriple("com", Dimension::kLength).value_or(Vector3<double>::Zero());
  map.Finish();
}

void ReadGravity(const YamlValue& value, Experiment* experiment) {
  YamlMap map(value);
  if (const auto direction = map.Find("direction")) {
    const Vector3<double> given = direction->Triple(Unit{"", 1.0, 1.0});
    if (given.norm() < 1e-9) direction->Fail("the direction of gravity has no length");
    experiment->gravity_direction = given.normalized();
  }
  if (const auto frame = map.Find("frame"))
    experiment->gravity_in_base = frame->OneOf({"measurement", "base"}) == "base";
  if (const auto magnitude = map.Find("m_per_s2")) {
    experiment->gravity = magnitude->PositiveNumber();
    CheckIn(allowed::kGravity, experiment->gravity, *magnitude);
  }
  map.Finish();
}

}  // namespace sagitta
