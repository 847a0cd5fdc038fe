#include "estimator/changes/campaigns.h"

#include <algorithm>
#include <cmath>

#include "estimator/report/diagnosis_words.h"
#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "problems/input_error.h"
#include "problems/simulation.h"

namespace sagitta {
namespace {

constexpr int kConfigurations = 36;     // at least; a few times as many points as a robot has parameters
constexpr int kOfAStation = 6;          // at least: twice what its pose needs
constexpr double kProbeForce = 1000.0;  // N, where loads are stated by the rows' wrenches alone
constexpr std::uint64_t kConfigurationSeed = 20260101;  // of the configurations that are compared

template <typename Map>
std::vector<std::string> Shared(const Map& a, const Map& b) {
  std::vector<std::string> names;
  for (const auto& [name, value] : a) {
    if (b.count(name) > 0) names.push_back(name);
  }
  return names;
}

// Markers in the same place under the same name.
std::vector<std::string> SharedMarkers(const KnownRobot& a, const KnownRobot& b) {
  std::vector<std::string> names;
  for (const std::string& name : Shared(a.markers, b.markers)) {
    if (a.markers.at(name).on == b.markers.at(name).on) names.push_back(name);
  }
  return names;
}

bool IsOnFlange(const MarkerSpec& marker) { return marker.on.kind == MarkerPlace::Kind::kFlange; }

// On the flange, under a name that the other does not use.
std::vector<std::string> OwnTools(const KnownRobot& known, const KnownRobot& other) {
  std::vector<std::string> names;
  for (const auto& [name, marker] : known.markers) {
    if (IsOnFlange(marker) && marker.point && other.markers.count(name) == 0) names.push_back(name);
  }
  return names;
}

// base/S2/x becomes base/S1/x.
void Rename(const std::string& from, const std::string& to, std::vector<std::string>* coordinates) {
  for (std::string& name : *coordinates) {
    if (IsWithin(name, from)) name = to + name.substr(from.size());
  }
}

template <typename Map>
void Rename(const std::string& kind, const std::string& from, const std::string& to, Map* places, KnownRobot* known) {
  places->emplace(to, places->at(from));
  places->erase(from);
  for (auto* names : {&known->uncertainty.estimated, &known->uncertainty.held}) {
    Rename(kind + "/" + from, kind + "/" + to, names);
  }
}

// A load whose point is known; empty: none.
std::string LoadOf(const Experiment& loading) {
  for (const auto& [name, spec] : loading.loads) {
    if (spec.point || loading.load_point) return name;
  }
  return loading.load_point ? "probe" : "";
}

using Ranges = std::vector<MeasuredInterval>;

MeasuredInterval Intersection(const MeasuredInterval& a, const MeasuredInterval& b) {
  return {std::max(a.least, b.least), std::min(a.most, b.most)};
}

Ranges ComparedRanges(const KnownRobot& old_estimate, const KnownRobot& new_estimate) {
  Ranges ranges;
  for (const Joint& joint : old_estimate.robot.chain.joints) {
    const double half = joint.type == JointType::kRevolute ? 2.0 * kPi / 3.0 : 0.5;
    ranges.push_back({joint.min.value_or(-half), joint.max.value_or(half)});
  }
  if (!LeastCommonRange(old_estimate, new_estimate).IsLessThanParts()) return ranges;
  for (size_t j = 0; j < ranges.size(); ++j) {
    const MeasuredInterval both = Intersection(old_estimate.measured_joints[j], new_estimate.measured_joints[j]);
    if (both.least < both.most) ranges[j] = both;
  }
  return ranges;
}

Configuration ComparedConfiguration(int index, const Ranges& ranges, NormalNumbers* normal) {
  Configuration configuration{"C" + std::to_string(index), Eigen::VectorXd(static_cast<long>(ranges.size())), false};
  for (size_t j = 0; j < ranges.size(); ++j) {
    configuration.q[static_cast<long>(j)] =
        ranges[j].least + (ranges[j].most - ranges[j].least) * 0.5 * std::erfc(-(*normal)() / std::sqrt(2.0));
  }
  return configuration;
}

// One row per marker.
void AddComparedShot(Shot shot, Measurements* data) {
  for (size_t m = 0; m < data->markers.size(); ++m) {
    Observation observation;
    observation.shot = static_cast<int>(data->shots.size());
    observation.marker = static_cast<int>(m);
    observation.file = 0;
    observation.row = static_cast<int>(data->observations.size());
    data->files[0].rows.push_back({observation.row + 1, {}});
    shot.observations.push_back(observation.row);
    data->observations.push_back(observation);
  }
  data->shots.push_back(shot);
}

constexpr double kBeyondChance = 2.0;  // standard deviations: 1 in 20 of what did not happen

// A drift goes on in every campaign, at a rate of its own; this is of one.
bool IsOfItsCourse(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition& effect = *FindEffect(robot, spec.effect);
  return effect.IsOfAMoment() || (effect.is_learnt && GoesWithTime(robot, spec));
}

// What goes with the time since it was begun and not with the clock's.
bool BeginsAnew(const Robot& robot, const EffectSpec& spec) {
  return FindEffect(robot, spec.effect)->remember != nullptr && GoesWithTime(robot, spec);
}

// s of the campaign's clock: a moment, or where a learnt function has come to its last value.
double TimeOf(const Robot& robot, const EffectSpec& spec) {
  const std::string moment = MomentOf(robot, spec);
  return spec.NumberSetting(moment.empty() ? "to" : moment, 0.0);
}

// s since the campaign's first row; absent: not stated.
std::optional<double> LastTime(const KnownRobot& known) {
  const auto& measured = known.measured_conditions.time;
  const auto& origins = known.loading.origins;
  if (!measured || !origins || !origins->campaign_time) return std::nullopt;
  return std::max(0.0, measured->most - *origins->campaign_time);
}

// Any of its parameters; what was stated and not estimated is certain.
bool IsBeyondChance(const KnownRobot& known, const EffectSpec& spec) {
  const Robot& robot = known.robot;
  const std::vector<EffectParameter> parameters = FindEffect(robot, spec.effect)->parameters(robot, spec);
  const std::vector<std::string>& names = known.uncertainty.estimated;
  for (size_t p = 0; p < std::min(parameters.size(), spec.values.size()); ++p) {
    const auto found = std::find(names.begin(), names.end(), spec.Path() + "/" + parameters[p].name);
    const auto i = static_cast<Eigen::Index>(found - names.begin());
    const double sigma = found == names.end() ? 0.0 : std::sqrt(known.uncertainty.covariance(i, i));
    if (std::abs(spec.values[p]) > kBeyondChance * sigma) return true;
  }
  return false;
}

}  // namespace

void CheckSameRobot(const KnownRobot& old_estimate, const KnownRobot& new_estimate) {
  const auto fail = [&](const std::string& what) {
    throw InputError({new_estimate.file, 0, "robot"}, "not the robot of " + old_estimate.file + ": " + what,
                     "give two estimates of one robot, made from the same robot description");
  };
  const Chain &x = old_estimate.robot.chain, &y = new_estimate.robot.chain;
  if (x.num_joints() != y.num_joints()) {
    fail(std::to_string(y.num_joints()) + " joints against " + std::to_string(x.num_joints()));
  }
  for (int j = 0; j < x.num_joints(); ++j) {
    if (x.joints[j].name != y.joints[j].name || x.joints[j].type != y.joints[j].type) {
      fail("joint " + std::to_string(j + 1) + " is '" + y.joints[j].name + "' against '" + x.joints[j].name + "'");
    }
  }
  if (old_estimate.robot.name != new_estimate.robot.name) {
    fail("'" + new_estimate.robot.name + "' against '" + old_estimate.robot.name + "'");
  }
  // Estimates differ by millimetres; another size of the same build by centimetres.
  constexpr double kOtherBuild = 0.02;
  bool same = x.num_transforms() == y.num_transforms();
  for (int e = 0; same && e < x.num_transforms(); ++e) {
    same = x.transforms[e].motion == y.transforms[e].motion && x.transforms[e].axis == y.transforms[e].axis &&
           x.transforms[e].joint == y.transforms[e].joint && x.transforms[e].sign == y.transforms[e].sign &&
           (x.transforms[e].is_rotation() || std::abs(x.transforms[e].nominal - y.transforms[e].nominal) < kOtherBuild);
  }
  if (!same) fail("the kinematic chains differ");
}

CommonRange LeastCommonRange(const KnownRobot& a, const KnownRobot& b) {
  CommonRange least;
  for (size_t j = 0; j < std::min(a.measured_joints.size(), b.measured_joints.size()); ++j) {
    const MeasuredInterval &x = a.measured_joints[j], &y = b.measured_joints[j], both = Intersection(x, y);
    const double wider = std::max(x.most - x.least, y.most - y.least);
    const double share = wider > 0.0 ? std::max(0.0, both.most - both.least) / wider : 1.0;
    if (share < least.share) least = {share, j};
  }
  return least;
}

CampaignsOwn PairCampaigns(const KnownRobot& old_estimate, KnownRobot* new_estimate) {
  CampaignsOwn own;
  if (Shared(old_estimate.base_in_station, new_estimate->base_in_station).empty()) {
    if (old_estimate.base_in_station.empty() || new_estimate->base_in_station.empty()) {
      throw InputError({new_estimate->file, 0, "stations"}, "no station here or in " + old_estimate.file);
    }
    own.station = true;
    const std::string from = new_estimate->base_in_station.begin()->first;
    Rename("base", from, old_estimate.base_in_station.begin()->first, &new_estimate->base_in_station, new_estimate);
  }
  if (SharedMarkers(old_estimate, *new_estimate).empty()) {
    const std::vector<std::string> old_tools = OwnTools(old_estimate, *new_estimate);
    const std::vector<std::string> new_tools = OwnTools(*new_estimate, old_estimate);
    const size_t pairs = std::min(old_tools.size(), new_tools.size());
    if (pairs == 0) {
      throw InputError({new_estimate->file, 0, "markers"}, "no marker of " + old_estimate.file + " is among them");
    }
    own.markers = true;
    for (size_t i = 0; i < pairs; ++i) {
      Rename("marker", new_tools[i], old_tools[i], &new_estimate->markers, new_estimate);
    }
  }
  return own;
}

Measurements RowsOfBoth(const KnownRobot& old_estimate, const KnownRobot& new_estimate, const CampaignsOwn& own) {
  Measurements data;
  data.stations = Shared(old_estimate.base_in_station, new_estimate.base_in_station);
  for (const std::string& marker : SharedMarkers(old_estimate, new_estimate)) {
    // A marker in the room says nothing of a robot, and of an instrument only where that has a name in both.
    if (own.station && old_estimate.markers.at(marker).on.kind == MarkerPlace::Kind::kWorld) continue;
    data.markers.push_back(marker);
  }
  if (data.markers.empty()) {
    throw InputError({new_estimate.file, 0, "markers"}, "no marker of " + old_estimate.file + " is among them");
  }
  const Experiment& loading = old_estimate.loading;
  const std::string load = LoadOf(loading);
  data.files.push_back({"", "", {}, {}});
  const Chain& chain = old_estimate.robot.chain;
  NormalNumbers normal(kConfigurationSeed);
  const Ranges ranges = ComparedRanges(old_estimate, new_estimate);
  const int configurations = std::max(kConfigurations, kOfAStation * static_cast<int>(data.stations.size()));
  for (int c = 0; c < configurations; ++c) {
    data.configurations.push_back(ComparedConfiguration(c, ranges, &normal));
    for (const bool loaded : {false, true}) {
      if (loaded && load.empty()) continue;
      Shot shot;
      shot.configuration = c;
      shot.station = c % static_cast<int>(data.stations.size());
      if (loaded) {
        shot.load = load;
        const auto spec = loading.loads.find(load);
        if (spec == loading.loads.end() || !spec->second.mass) shot.wrench.force = {0.0, 0.0, -kProbeForce};
      }
      shot.has_time = shot.has_temperature = true;  // when: SetMoment below
      shot.temperature = loading.origins.value_or(ConditionOrigins()).mean_temperature;
      shot.approach.assign(chain.num_joints(), 0);
      AddComparedShot(shot, &data);
    }
  }
  return data;
}

ComparedMoment EndOf(const KnownRobot& known) {
  ComparedMoment end;
  if (const std::optional<double> last = LastTime(known)) {
    end.time = *last;
    for (const auto& [station, first] : known.loading.origins->first_time) {
      end.station_time[station] = std::max(0.0, known.measured_conditions.time->most - first);
    }
    return end;
  }
  for (const EffectSpec& spec : known.robot.effects) {
    if (IsOfItsCourse(known.robot, spec)) end.time = std::max(end.time, TimeOf(known.robot, spec));
  }
  end.time = std::nextafter(end.time, kInfinity);
  return end;
}

std::vector<std::string> StationsBegunAnew(const KnownRobot& a, const KnownRobot& b) {
  std::vector<std::string> stations;
  for (const KnownRobot* known : {&a, &b}) {
    for (const EffectSpec& spec : known->robot.effects) {
      if (BeginsAnew(known->robot, spec)) stations.push_back(spec.target);
    }
  }
  return stations;
}

bool IsOfItsCourse(const KnownRobot& known, const std::string& coordinate) {
  return std::any_of(known.robot.effects.begin(), known.robot.effects.end(), [&](const EffectSpec& spec) {
    return IsParameterOf(spec, coordinate) && IsOfItsCourse(known.robot, spec);
  });
}

std::vector<std::string> HappenedWithin(const KnownRobot& known) {
  const double last = LastTime(known).value_or(kInfinity);
  std::vector<std::string> titles;
  for (const EffectSpec& spec : known.robot.effects) {
    if (!IsOfItsCourse(known.robot, spec) || !IsBeyondChance(known, spec)) continue;
    const bool has_begun = MomentOf(known.robot, spec).empty() || TimeOf(known.robot, spec) < last;
    if (has_begun) titles.push_back(Title(known.robot, spec));
  }
  return titles;
}

void SetMoment(const ComparedMoment& moment, CalibrationProblem* problem) {
  std::vector<ShotInput>& shots = *problem->mutable_shot_inputs();
  for (ShotInput& shot : shots) {
    const auto station = moment.station_time.find(shot.conditions.station);
    shot.conditions.has_time = true;
    shot.conditions.time = moment.time;
    shot.conditions.station_time = station == moment.station_time.end() ? 0.0 : station->second;
  }
  problem->model().Prepare(&shots);
}

std::vector<Vector3<double>> MovedByEvents(const CalibrationProblem& problem) {
  std::vector<Vector3<double>> moved(problem.data().markers.size(), Vector3<double>::Zero());
  if (problem.shot_inputs().empty()) return moved;
  const std::vector<ModelParameter>& parameters = problem.model().parameters();
  for (const MarkerTerm& term : problem.shot_inputs()[0].terms.markers) {
    const ModelParameter& parameter = parameters[static_cast<size_t>(term.parameter)];
    if (parameter.law != ParameterLaw::kEffect) continue;
    const EffectSpec& spec = problem.robot().effects[static_cast<size_t>(parameter.index)];
    if (!IsOfItsCourse(problem.robot(), spec)) continue;
    const int coordinate = problem.parameters.FindCoordinate(parameter.name);
    moved[static_cast<size_t>(term.marker)] += problem.parameters.Value(coordinate) * term.direction;
  }
  return moved;
}

}  // namespace sagitta
