#include "problems/loads.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <tuple>
#include <utility>

#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/units.h"
#include "problems/problem_checks.h"

namespace sagitta {
namespace {

// Of a weight: gravity differs by 0.5 % from the equator to the poles, and masses are stated to a percent.
constexpr double kSameWeight = 0.02;

[[noreturn]] void FailAt(const Measurements& data, const Shot& shot, const std::string& key, const std::string& what,
                         const std::string& hint) {
  throw InputError(data.WhereOf(shot, key), what, hint);
}

Vector3<double> Gravity(const Experiment& experiment) { return experiment.gravity * experiment.gravity_direction; }

WrenchFrame GravityFrame(const Experiment& experiment) {
  return experiment.gravity_in_base ? WrenchFrame::kBase : WrenchFrame::kMeasurement;
}

AppliedWrench LoadWrench(const Chain& chain, const Measurements& data, const Shot& shot, const Experiment& experiment) {
  const auto found = experiment.loads.find(shot.load);
  const LoadSpec spec = found == experiment.loads.end() ? LoadSpec() : found->second;
  const std::optional<Vector3<double>> point = spec.point ? spec.point : experiment.load_point;
  if (!point) {
    FailAt(data, shot, "load", "load '" + shot.load + "' acts at no stated point",
           "state load_point_mm, loads: {" + shot.load + ": {point_mm: …}}, or --load_point_mm=x,y,z");
  }
  AppliedWrench wrench;
  wrench.frame = chain.FlangeFrame();
  wrench.point = *point;
  wrench.force = shot.wrench.force;
  wrench.moment = shot.wrench.moment;
  wrench.expressed_in = spec.frame;
  if (!shot.wrench.force.isZero() || (!spec.mass && !shot.wrench.IsZero())) return wrench;
  if (!spec.mass) {
    FailAt(data, shot, "load", "load '" + shot.load + "' has no force",
           "add the columns fx_N, fy_N, fz_N, or state loads: {" + shot.load + ": {mass_kg: …}}");
  }
  wrench.force = *spec.mass * Gravity(experiment);
  if (!wrench.moment.isZero() && wrench.expressed_in != GravityFrame(experiment)) {
    FailAt(data, shot, "load",
           "load '" + shot.load + "' has moments in another frame than that of gravity and no force",
           "state its weight in the columns fx_N, fy_N, fz_N too");
  }
  wrench.expressed_in = GravityFrame(experiment);
  return wrench;
}

// The column's own name where a file has none of it.
std::string FirstTorqueColumn(const Chain& chain) {
  return chain.joints.front().type == JointType::kRevolute ? "tau1_Nm" : "tau1_N";
}

ShotConditions ConditionsOf(const Measurements& data, const Shot& shot, const Experiment& experiment,
                            const ConditionOrigins& origins) {
  ShotConditions conditions;
  conditions.q = data.configurations[shot.configuration].q;
  conditions.station = data.stations[shot.station];
  conditions.load = shot.load;
  conditions.has_time = shot.has_time;
  conditions.campaign = shot.campaign;
  if (shot.has_time) {
    conditions.time = shot.time - origins.campaign_time.value_or(shot.time);
    conditions.station_time = shot.time - origins.first_time.at(conditions.station);
  }
  conditions.has_temperature = shot.has_temperature;
  if (shot.has_temperature) conditions.temperature = shot.temperature - origins.mean_temperature;
  conditions.approach = shot.approach;
  conditions.gravity = Gravity(experiment);
  conditions.gravity_frame = GravityFrame(experiment);
  const auto station = experiment.stations.find(conditions.station);
  if (station != experiment.stations.end() && station->second.instrument_xyz) {
    conditions.instrument = *station->second.instrument_xyz;
  }
  return conditions;
}

std::set<int> MarkersOf(const Measurements& data, const Shot& shot) {
  std::set<int> markers;
  for (const int i : shot.observations) markers.insert(data.observations[i].marker);
  return markers;
}

// Of its earliest row; the shot's own time is the mean of its rows.
double FirstTime(const Measurements& data, const Shot& shot) {
  std::optional<double> first;
  for (const int i : shot.observations) {
    const std::optional<double> time = ParseNumber(data.Cell(data.observations[i], "time_s"));
    if (time) first = std::min(first.value_or(*time), *time);
  }
  return first.value_or(shot.time);
}

}  // namespace

ConditionOrigins OriginsOf(const Measurements& data, const Experiment& experiment) {
  ConditionOrigins origins = experiment.origins.value_or(ConditionOrigins());
  std::optional<double> campaign_time;         // of these rows
  std::map<std::string, double> station_time;  // of these rows
  double sum = 0.0;
  int count = 0;
  for (const Shot& shot : data.shots) {
    if (shot.has_time) {
      const double time = FirstTime(data, shot);
      double& earliest = station_time.emplace(data.stations[shot.station], time).first->second;
      earliest = std::min(earliest, time);
      campaign_time = std::min(campaign_time.value_or(time), time);
    }
    if (!shot.has_temperature) continue;
    sum += shot.temperature;
    ++count;
  }
  origins.first_time.insert(station_time.begin(), station_time.end());
  if (!origins.campaign_time) origins.campaign_time = campaign_time;
  if (!experiment.origins && count > 0) origins.mean_temperature = sum / count;
  return origins;
}

void CountFromReference(const Robot& robot, Experiment* experiment) {
  if (!robot.reference_temperature || experiment->origins) return;
  experiment->origins = ConditionOrigins();
  experiment->origins->mean_temperature = *robot.reference_temperature;
}

bool IsLoaded(const Shot& shot) { return shot.load != kNoLoad; }

void CheckLoadStates(Measurements* data) {
  constexpr int kLoaded = 1, kUnloaded = 2;
  int states = 0;                                                    // of all shots
  std::vector<int> states_of_poses(data->configurations.size(), 0);  // where both meet a load can be on some markers
  for (const Shot& shot : data->shots) {
    const int state = IsLoaded(shot) ? kLoaded : kUnloaded;
    states |= state;
    states_of_poses[shot.configuration] |= state;
  }
  std::map<std::tuple<int, std::string, std::string, int>, const Shot*> unloaded;
  for (const Shot& shot : data->shots) {
    if (IsLoaded(shot) || states_of_poses[shot.configuration] != (kLoaded | kUnloaded)) continue;
    unloaded[{shot.configuration, shot.visit, shot.repeat, shot.station}] = &shot;
  }
  std::set<std::pair<int, int>> together;  // markers with a shot in common
  for (const Shot& shot : data->shots) {
    if (unloaded.empty()) break;
    const std::set<int> markers = MarkersOf(*data, shot);
    for (const int a : markers) {
      for (const int b : markers) together.insert({a, b});
    }
  }
  for (const Shot& shot : data->shots) {
    if (!IsLoaded(shot) || unloaded.empty()) continue;
    const auto found = unloaded.find({shot.configuration, shot.visit, shot.repeat, shot.station});
    if (found == unloaded.end()) continue;
    bool overlap = false, elsewhere_together = false;
    for (const int a : MarkersOf(*data, shot)) {
      for (const int b : MarkersOf(*data, *found->second)) {
        overlap |= a == b;
        elsewhere_together |= a != b && together.count({a, b}) > 0;
      }
    }
    if (overlap || !elsewhere_together) continue;
    FailAt(
        *data, shot, "load",
        "load '" + shot.load + "' is on some markers of the shot only: the others of configuration '" +
            data->configurations[shot.configuration].id + "' are unloaded",
        "every marker of a shot bears the same load: give all its rows the same load and wrench, or, where the others "
        "were not seen under this load, another visit");
  }
  if (states == kLoaded) {
    data->warnings.push_back(
        "every row is loaded: without unloaded rows a deflection is distinguished from geometry only by how it varies "
        "with torque; measure some configurations unloaded too");
  }
}

void CheckStatedLoads(const Experiment& experiment, Measurements* data) {
  std::set<std::string> in_rows, unstated, warned;
  for (const Shot& shot : data->shots) {
    if (!IsLoaded(shot)) continue;
    in_rows.insert(shot.load);
    const auto found = experiment.loads.find(shot.load);
    if (found == experiment.loads.end()) unstated.insert(shot.load);
    if (found == experiment.loads.end() || !found->second.mass || shot.wrench.force.isZero()) continue;
    const double weight = *found->second.mass * experiment.gravity;
    const double force = shot.wrench.force.norm();
    if (std::abs(force - weight) <= kSameWeight * weight || !warned.insert(shot.load).second) continue;
    std::ostringstream words;
    words.precision(4);
    words << "load '" << shot.load << "': its wrench columns say " << force << " N, loads: says " << *found->second.mass
          << " kg, which weighs " << weight << " N; the columns count";
    data->warnings.push_back(words.str());
  }
  for (const auto& [name, spec] : experiment.loads) {
    if (in_rows.count(name) > 0) continue;
    const std::string key = "loads." + name;
    const std::vector<std::string> candidates(unstated.begin(), unstated.end());
    if (!NearestName(name, candidates).empty()) {
      throw InputError({experiment.file, LineOf(experiment, key), key}, "no row has this load",
                       SpellingHint(name, candidates));
    }
    data->warnings.push_back("no row has the load '" + name + "' that loads: describes");
  }
}

std::vector<ShotInput> MakeShotInputs(const ForwardModel& model, const Measurements& data,
                                      const Experiment& experiment) {
  const Chain& chain = model.chain();
  const ConditionOrigins origins = OriginsOf(data, experiment);
  std::vector<ShotInput> inputs;
  inputs.reserve(data.shots.size());
  for (const Shot& shot : data.shots) {
    CheckInterruption();
    ShotInput input;
    input.conditions = ConditionsOf(data, shot, experiment, origins);
    if (experiment.torques_measured) {
      if (shot.joint_torques.size() == 0) {
        FailAt(data, shot, FirstTorqueColumn(chain), "torques: measured needs the measured joint torques of every row",
               "add the columns " + FirstTorqueColumn(chain) + " … of all joints, or state torques: model");
      }
      input.conditions.joint_torques = shot.joint_torques;
    }
    if (experiment.tool_mass > 0.0) {
      input.wrenches.push_back({chain.FlangeFrame(), experiment.tool_com, experiment.tool_mass * Gravity(experiment),
                                Vector3<double>::Zero(), GravityFrame(experiment)});
    }
    if (IsLoaded(shot)) {
      input.conditions.load_wrenches = {LoadWrench(chain, data, shot, experiment)};
      input.wrenches.push_back(input.conditions.load_wrenches.front());
    } else if (!shot.wrench.IsZero()) {
      FailAt(data, shot, "load", "the row has a wrench but its load is 'none'",
             "give the load a name in the column load");
    }
    inputs.push_back(std::move(input));
  }
  model.Prepare(&inputs);
  return inputs;
}

}  // namespace sagitta
