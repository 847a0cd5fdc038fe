#include "problems/problem_checks.h"

#include <algorithm>
#include <map>
#include <set>

#include "models/effects/catalogue.h"
#include "problems/input_error.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Whether two of these configurations differ in a joint value.
bool AnyDiffer(const Measurements& data, const std::set<int>& configurations) {
  const auto differs = [&](int c) {
    return data.configurations[c].q != data.configurations[*configurations.begin()].q;
  };
  return std::any_of(configurations.begin(), configurations.end(), differs);
}

// How many unknowns there are of each kind, and which of the geometry may be held: errors near the flange have the
// shortest levers, so that what they are assumed to be matters least.
std::string HowToFreeLess(const ParameterSet& parameters, int too_many) {
  std::map<std::string, int> count;
  std::vector<std::string> geometry;
  for (const int i : parameters.EstimatedCoordinates()) {
    const std::string& name = parameters.coordinates()[i].name;
    ++count[name.substr(0, name.find('/'))];
    if (CoordinateKindOf(name) == CoordinateKind::kGeometry) geometry.push_back(name);
  }
  std::vector<std::string> kinds;
  for (const auto& [kind, number] : count) kinds.push_back(kind + " " + std::to_string(number));
  std::string hint = "measure more configurations or free less (unknowns: " + Enumerate(kinds) + ")";
  const int free = static_cast<int>(geometry.size());
  if (free <= too_many) return hint;
  geometry.erase(geometry.begin(), geometry.end() - too_many);
  return hint + ": at least " + std::to_string(too_many) + " have to be held, and what is next to the flange matters " +
         "least, --fixed=" + Joined(geometry, ",");
}

}  // namespace

int LineOf(const Experiment& experiment, std::string key) {
  while (!key.empty()) {
    const auto found = experiment.lines.find(key);
    if (found != experiment.lines.end()) return found->second;
    const size_t dot = key.rfind('.');
    key.resize(dot == std::string::npos ? 0 : dot);
  }
  return 0;
}

void FailProblem(const CalibrationProblem& problem, const std::string& key, const std::string& what,
                 const std::string& hint) {
  FailProblem(problem.experiment(), key, what, hint);
}

void FailProblem(const Experiment& experiment, const std::string& key, const std::string& what,
                 const std::string& hint) {
  throw InputError({experiment.file, LineOf(experiment, key), key}, what, hint);
}

void CheckNames(const CalibrationProblem& problem) {
  for (const auto& [name, spec] : problem.experiment().markers) {
    const auto& known = problem.data().markers;
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      FailProblem(problem, "markers." + name, "no row measures this marker", SpellingHint(name, known));
    }
  }
  for (const auto& [name, spec] : problem.experiment().stations) {
    const auto& known = problem.data().stations;
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      FailProblem(problem, "stations." + name, "no row is measured from this station", SpellingHint(name, known));
    }
  }
}

void CheckJointsOfEffects(const Robot& robot, const Experiment& experiment) {
  const std::vector<std::string> known = JointNames(robot.chain.joints);
  const auto check = [&](const EffectSpec& spec, const std::string& name) {
    if (robot.chain.FindJoint(name) >= 0) return;
    throw InputError({experiment.robot_file, 0, "effects"},
                     "effect " + spec.effect + ": the robot has no joint '" + name + "'", SpellingHint(name, known));
  };
  for (const EffectSpec& spec : robot.effects) {
    const EffectDefinition& definition = *FindEffect(robot, spec.effect);
    if (definition.target == EffectTarget::kJoint) check(spec, spec.target);
    for (const SettingDefinition& setting : definition.settings) {
      const auto stated = spec.settings.find(setting.name);
      if (setting.kind == SettingDefinition::Kind::kJoint && stated != spec.settings.end()) check(spec, stated->second);
    }
  }
}

void CheckEffects(const CalibrationProblem& problem) {
  std::set<std::string> loads;
  for (const Shot& shot : problem.data().shots) loads.insert(shot.load);
  for (const EffectSpec& spec : problem.robot().effects) {
    std::vector<std::string> known;
    switch (FindEffect(problem.robot(), spec.effect)->target) {
      case EffectTarget::kStation:
        known = problem.data().stations;
        break;
      case EffectTarget::kMarker:
        known = problem.data().markers;
        break;
      case EffectTarget::kLoad:
        known.assign(loads.begin(), loads.end());
        break;
      case EffectTarget::kJoint:
      case EffectTarget::kError:
      case EffectTarget::kBase:
      case EffectTarget::kRobot:
        continue;
    }
    if (std::find(known.begin(), known.end(), spec.target) != known.end()) continue;
    throw InputError({problem.experiment().robot_file, 0, "effects"},
                     "effect " + spec.effect + ": the data have no '" + spec.target + "'",
                     SpellingHint(spec.target, known));
  }
}

std::optional<NeededColumn> ColumnOfAnEffect(const CalibrationProblem& problem) {
  for (const EffectSpec& spec : problem.robot().effects) {
    for (size_t s = 0; s < problem.shot_inputs().size(); ++s) {
      const EffectContext context{&problem.robot(), &spec, &problem.shot_inputs()[s].conditions,
                                  &problem.data().markers, 0};
      const std::string column = MissingColumn(*FindEffect(problem.robot(), spec.effect), context);
      if (!column.empty()) return NeededColumn{spec.Path(), column, static_cast<int>(s)};
    }
  }
  return std::nullopt;
}

void CheckEffectColumns(const CalibrationProblem& problem, const std::string& what_else) {
  const std::optional<NeededColumn> needed = ColumnOfAnEffect(problem);
  if (!needed) return;
  throw InputError(problem.data().WhereOf(problem.data().shots[static_cast<size_t>(needed->shot)], needed->column),
                   needed->effect + " needs this column", "add it, or " + what_else);
}

std::string UnlevelledStationWithWeights(const CalibrationProblem& problem) {
  const Experiment& experiment = problem.experiment();
  if (experiment.gravity_in_base) return "";
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    const Shot& shot = problem.data().shots[s];
    const std::string& name = problem.data().stations[shot.station];
    const auto station = experiment.stations.find(name);
    if (station == experiment.stations.end() || station->second.levelled.value_or(true)) continue;
    const auto load = experiment.loads.find(shot.load);
    const bool hangs = shot.wrench.force.isZero() && load != experiment.loads.end() && load->second.mass;
    const ShotTerms& terms = problem.shot_inputs()[s].terms;
    if (terms.elastic.empty() && terms.sags.empty()) continue;  // nothing gives way
    if (hangs || experiment.tool_mass > 0.0 || !terms.sags.empty() || !terms.wrenches.empty()) return name;
  }
  return "";
}

void CheckLevelled(const CalibrationProblem& problem) {
  const std::string station = UnlevelledStationWithWeights(problem);
  if (station.empty()) return;
  FailProblem(problem, "stations." + station + ".levelled",
              "weights act along the gravity direction, and that of a station that is not levelled is not known",
              "state it in the base frame: gravity: {direction: [x, y, z], frame: base}");
}

void CheckCompensator(const CalibrationProblem& problem) {
  if (!problem.robot().gravity_compensator) return;
  const GravityCompensator& c = *problem.robot().gravity_compensator;
  const CompensatorParameters<double> parameters{c.L, c.a_x, c.a_y, c.s0, c.Kc};
  const Chain& chain = problem.robot().chain;
  const ElementaryTransform& turn = chain.transforms[chain.JointTransform(c.joint)];
  const double zero = turn.sign * (turn.nominal - c.zero.value_or(turn.nominal));  // the spring's angle at q = 0
  if (c.L <= 0.0 || c.s0 <= 0.0 || c.Kc < 0.0) {
    throw InputError({problem.experiment().robot_file, 0, "gravity_compensator"},
                     "L and s0 must be positive and Kc not negative", "state lengths in mm, stiffness in N/mm");
  }
  for (const Configuration& configuration : problem.data().configurations) {
    const double angle = zero + chain.CoupledJointValues(configuration.q)[c.joint];
    // Below a thousandth of its rest length the torque's s0 / s leaves no digit that means a spring.
    if (CompensatorSpringLength(parameters, angle) > 1e-3 * c.s0) continue;
    throw InputError({problem.experiment().robot_file, 0, "gravity_compensator"},
                     "the spring would have no length at configuration '" + configuration.id + "'",
                     "check L, a_x and a_y: the lever end would lie on the anchor");
  }
}

void CheckRowsAreRead(const CalibrationProblem& problem) {
  for (const Observation& row : problem.data().observations) {
    if (row.excluded || row.IsRead()) continue;
    throw InputError(problem.data().WhereOf(row, row.is_point() ? "x_mm" : "rx_mrad"),
                     "the reading of a row is no number",
                     "leave the row out, or exclude it (Measurements::ExcludeRow)");
  }
}

namespace {

// Of a marker or station that no fitted row has: why. is_listed_only: no other row has it either.
[[noreturn]] void FailUnfitted(const std::string& file, const std::string& kind, const std::string& name,
                               const std::string& unknown, bool is_listed_only) {
  if (is_listed_only) {
    throw InputError({file, 0, kind}, kind + " '" + name + "' is listed, and no row has it", "remove it from the list");
  }
  throw InputError({file, 0, kind}, kind + " '" + name + "' has validation rows only",
                   unknown + " cannot be estimated; move some of its configurations to calibration");
}

bool AnyRowOfStation(const Measurements& data, int station) {
  return std::any_of(data.observations.begin(), data.observations.end(),
                     [&](const Observation& row) { return data.shots[row.shot].station == station; });
}

bool AnyRowOfMarker(const Measurements& data, int marker) {
  return std::any_of(data.observations.begin(), data.observations.end(),
                     [&](const Observation& row) { return row.marker == marker; });
}

}  // namespace

void CheckEnoughData(const CalibrationProblem& problem) {
  std::set<int> configurations;
  int latest = -1;
  std::vector<bool> station_seen(problem.data().stations.size()), marker_seen(problem.data().markers.size());
  const std::vector<int> observations = problem.CalibrationObservations();
  for (const int i : observations) {
    const Observation& observation = problem.data().observations[i];
    const Shot& shot = problem.data().shots[observation.shot];
    if (shot.configuration != latest) configurations.insert(configurations.end(), shot.configuration);
    latest = shot.configuration;
    station_seen[shot.station] = true;
    marker_seen[observation.marker] = true;
  }
  const std::string file = problem.data().files.empty() ? "" : problem.data().files[0].path;
  for (size_t s = 0; s < station_seen.size(); ++s) {
    if (station_seen[s]) continue;
    FailUnfitted(file, "station", problem.data().stations[s], "its base pose",
                 !AnyRowOfStation(problem.data(), static_cast<int>(s)));
  }
  for (size_t m = 0; m < marker_seen.size(); ++m) {
    if (marker_seen[m]) continue;
    FailUnfitted(file, "marker", problem.data().markers[m], "its point",
                 !AnyRowOfMarker(problem.data(), static_cast<int>(m)));
  }
  const int unknowns = problem.parameters.EstimatedCoordinates().size();
  if (unknowns == 0) throw InputError({file, 0, ""}, "nothing is free: there is nothing to estimate");
  const bool is_one = configurations.size() < 2;
  const bool asks_for_both = problem.experiment().estimate.base && problem.experiment().estimate.markers;
  if (is_one || (asks_for_both && !AnyDiffer(problem.data(), configurations))) {
    const std::string alike =
        "all " + std::to_string(configurations.size()) +
        " configurations are alike (equal joint values), and one pose cannot distinguish the robot "
        "from the base";
    throw InputError({file, 0, "config"},
                     is_one ? "one configuration cannot distinguish the robot from the base" : alike,
                     "measure at least two, better thirty, different configurations");
  }
  const int equations = 3 * observations.size();
  const int held_out = 3 * static_cast<int>(problem.ValidationObservations().size());
  if (equations < unknowns && equations + held_out >= unknowns) {
    throw InputError({file, 0, "validation"},
                     "fewer equations (" + std::to_string(equations) + ") than unknowns (" + std::to_string(unknowns) +
                         "): " + std::to_string(held_out) + " more are of configurations that are held out",
                     "validation: none in the experiment file holds none out (of so few rows nothing can be spared); "
                     "better, measure more configurations");
  }
  if (equations < unknowns) {
    throw InputError(
        {file, 0, ""},
        "fewer equations (" + std::to_string(equations) + ") than unknowns (" + std::to_string(unknowns) + ")",
        HowToFreeLess(problem.parameters, unknowns - equations));
  }
}

}  // namespace sagitta
