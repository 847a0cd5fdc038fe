#include "problems/free_selection.h"

#include <algorithm>
#include <functional>

#include "models/default_free_set.h"
#include "models/effects/catalogue.h"
#include "problems/input_error.h"
#include "problems/loads.h"
#include "problems/problem_checks.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Which of `all` a selection names; `what` for messages. hint_of: what a name that is none is to be.
std::vector<std::string> SelectFrom(const std::vector<std::string>& all, const Selection& selection,
                                    const std::string& key, const std::string& what, const Experiment& experiment,
                                    const std::function<std::string(const std::string&)>& hint_of = nullptr) {
  if (selection.kind == Selection::Kind::kAll) return all;
  if (selection.kind != Selection::Kind::kList) return {};
  for (const std::string& name : selection.names) {
    if (std::find(all.begin(), all.end(), name) != all.end()) continue;
    const std::string without_kind = NameWithinKind(name);
    std::string hint = hint_of ? hint_of(name) : "";
    if (std::count(all.begin(), all.end(), without_kind) > 0) hint = "names have no kind here: '" + without_kind + "'";
    throw InputError({experiment.file, LineOf(experiment, key), key}, "the robot has no " + what + " '" + name + "'",
                     hint.empty() ? SpellingHint(name, all) : hint);
  }
  return selection.names;
}

// The errors that are offsets of joints: those of their own motions. j1.theta of a DH table is joint_a1.yaw of a URDF
// whose axis is z. "": the name is no joint's.
std::string OffsetsInstead(const Chain& chain, const std::string& name) {
  if (chain.FindJoint(name.substr(0, name.rfind('.'))) < 0) return "";
  std::vector<std::string> offsets;
  for (int j = 0; j < chain.num_joints(); ++j) {
    const std::string& error = chain.transforms[chain.JointTransform(j)].error;
    if (!error.empty()) offsets.push_back(error);
  }
  return offsets.empty() ? "" : "the joints' own offsets are [" + Joined(offsets) + "]";
}

std::vector<std::string> FreeErrors(CalibrationProblem* problem) {
  const Selection& selection = problem->experiment().estimate.geometry;
  if (selection.kind != Selection::Kind::kDefault) {
    std::vector<std::string> all;
    for (const ElementaryTransform& transform : problem->robot().chain.transforms) {
      if (!transform.error.empty()) all.push_back(transform.error);
    }
    return SelectFrom(all, selection, "estimate.geometry", "geometric error", problem->experiment(),
                      [problem](const std::string& name) { return OffsetsInstead(problem->robot().chain, name); });
  }
  const EstimateSpec& estimate = problem->experiment().estimate;
  FreeSet set = DefaultFreeSet(problem->robot().chain, {estimate.base, estimate.markers});
  // A prior is one more reading of its parameter, of which nothing is redundant.
  const auto states_prior = [problem](const std::string& error) {
    return problem->experiment().priors.count(GeometryName(error)) > 0;
  };
  const auto stated = std::stable_partition(set.redundant.begin(), set.redundant.end(), std::not_fn(states_prior));
  set.free.insert(set.free.end(), stated, set.redundant.end());
  set.redundant.erase(stated, set.redundant.end());
  problem->redundant_errors = set.redundant;
  return set.free;
}

// What compliances answer to: loads, or measured torques.
bool AnyLoaded(const Measurements& data, const Experiment& experiment) {
  return experiment.torques_measured || std::any_of(data.shots.begin(), data.shots.end(), IsLoaded);
}

// Effects that pull at the arm whatever hangs on it: the weight of its links, a hose. Compliances answer to them too.
bool PullsByItself(const Robot& robot) {
  return std::any_of(robot.effects.begin(), robot.effects.end(), [&](const EffectSpec& use) {
    const EffectDefinition* definition = FindEffect(robot, use.effect);
    return definition != nullptr && definition->needs == EffectNeeds::kCompliances;
  });
}

std::vector<std::string> FreeSpring(const CalibrationProblem& problem) {
  const Selection& selection = problem.experiment().estimate.gravity_compensator;
  const bool lists_none = selection.kind == Selection::Kind::kList && selection.names.empty();
  if (selection.kind == Selection::Kind::kDefault || selection.kind == Selection::Kind::kNone || lists_none) return {};
  if (!problem.robot().gravity_compensator) {
    FailProblem(problem, "estimate.gravity_compensator", "the robot has no gravity_compensator",
                "describe it in the robot file: joint, L_mm, a_x_mm, a_y_mm, s0_mm, Kc_N_per_mm");
  }
  std::vector<std::string> parts;
  for (const CompensatorPart part : kCompensatorParts) parts.emplace_back(WordOf(part));
  return SelectFrom(parts, selection, "estimate.gravity_compensator", "compensator parameter", problem.experiment());
}

// The parameters of the name's family (geometry/...), or all where it has none.
std::vector<std::string> KnownNextTo(const std::string& name, const ParameterSet& parameters) {
  const std::optional<CoordinateKind> kind =
      name.find('/') == std::string::npos ? std::nullopt : CoordinateKindOf(name);
  std::vector<std::string> known, related;
  for (const Coordinate& coordinate : parameters.coordinates()) {
    known.push_back(coordinate.name);
    if (coordinate.kind == kind) related.push_back(coordinate.name);
  }
  return related.empty() ? known : related;
}

// name: of an effect's parameter, "effect/learnt_deviation[by=q,...]/j1/w1".
bool IsLearnt(const std::string& name) {
  const EffectDefinition* definition = EffectOfName(name);
  return definition != nullptr && definition->is_learnt;
}

// A joint that the robot has, under a selection that leaves it out.
void RefuseUnlistedCompliance(const CalibrationProblem& problem, const std::string& name, const char* key) {
  if (CoordinateKindOf(name) != CoordinateKind::kCompliance) return;
  const std::string joint = NameWithinKind(name);
  if (problem.robot().chain.FindJoint(joint) < 0) return;
  FailProblem(problem, key, "joint '" + joint + "' has no compliance in this estimate",
              "add " + joint + " to estimate.compliance, or to compliance: of the robot file");
}

// Which of the model's parameters the experiment asks for.
class ModelSelection {
 public:
  explicit ModelSelection(CalibrationProblem* problem)
      : effects_(problem->experiment().estimate.effects.kind),
        errors_(FreeErrors(problem)),
        compliant_(CompliantJoints(problem->robot(), problem->data(), problem->experiment())),
        spring_(FreeSpring(*problem)) {}

  // name: of the coordinate, family/rest.
  bool Holds(ParameterLaw law, const std::string& name) const {
    const std::string own = NameWithinKind(name);
    switch (law) {
      case ParameterLaw::kGeometry:
        return IsIn(errors_, own);
      case ParameterLaw::kCompliance:
        return IsIn(compliant_, own.substr(0, own.find('@')));
      case ParameterLaw::kCompensator:
        return IsIn(spring_, own);
      case ParameterLaw::kEffect:
        break;
    }
    // Learnt weights are as an earlier diagnosis found them, about what is left of its model: where they are not asked
    // for they are kept.
    const bool is_kept = effects_ == Selection::Kind::kDefault && IsLearnt(name);
    return effects_ != Selection::Kind::kNone && !is_kept;
  }

 private:
  static bool IsIn(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  }

  Selection::Kind effects_;
  std::vector<std::string> errors_, compliant_, spring_;
};

// A name stands for all that begin with it and a slash; nothing is written as a pattern.
std::string HintFor(const std::string& name, const ParameterSet& parameters) {
  const bool is_pattern = name.size() > 2 && name.back() == '*';
  const std::string group = is_pattern ? name.substr(0, name.size() - 2) : "";
  if (is_pattern && !parameters.Match(group).empty()) return "'" + group + "' stands for all whose names begin so";
  std::vector<std::string> families;
  for (const Coordinate& coordinate : parameters.coordinates())
    families.push_back(coordinate.name.substr(0, coordinate.name.find('/')));
  const std::string family = NearestName(name, families);
  return family.empty() ? SpellingHint(name, KnownNextTo(name, parameters)) : "did you mean '" + family + "'?";
}

void SetByName(const std::string& name, const char* key, bool free, CalibrationProblem* problem) {
  ParameterSet& parameters = problem->parameters;
  const std::vector<int> matches = parameters.Match(name);
  if (matches.empty()) {
    RefuseUnlistedCompliance(*problem, name, key);
    FailProblem(*problem, key, "there is no parameter '" + name + "'", HintFor(name, parameters));
  }
  for (const int i : matches) parameters.coordinate(i).free = free;
}

// A part of what is asked for may be fixed, or of what is fixed be asked for, not the same: names stand for all that
// begin with them, so the shorter of two goes first.
void SetByNames(const EstimateSpec& estimate, CalibrationProblem* problem) {
  std::vector<std::pair<std::string, bool>> names;  // free?
  for (const std::string& name : estimate.free) names.emplace_back(name, true);
  for (const std::string& name : estimate.fixed) {
    if (std::count(estimate.free.begin(), estimate.free.end(), name) > 0)
      FailProblem(*problem, "--fixed", "'" + name + "' is asked to be free and fixed", "drop it from one of the two");
    names.emplace_back(name, false);
  }
  std::stable_sort(names.begin(), names.end(),
                   [](const auto& a, const auto& b) { return a.first.size() < b.first.size(); });
  for (const auto& [name, free] : names) SetByName(name, free ? "--free" : "--fixed", free, problem);
}

}  // namespace

std::vector<std::string> CompliantJoints(const Robot& robot, const Measurements& data, const Experiment& experiment) {
  const std::vector<std::string> all = JointNames(robot.chain.joints);
  const Selection& selection = experiment.estimate.compliance;
  if (selection.kind == Selection::Kind::kDefault)
    return AnyLoaded(data, experiment) ? all : std::vector<std::string>();
  const std::vector<std::string> named = SelectFrom(all, selection, "estimate.compliance", "joint", experiment);
  const bool is_pulled = AnyLoaded(data, experiment) || experiment.tool_mass != 0.0 || PullsByItself(robot);
  if (!named.empty() && !is_pulled) {
    throw InputError({experiment.file, LineOf(experiment, "estimate.compliance"), "estimate.compliance"},
                     "compliances are asked for but no row is loaded",
                     "measure loaded shots (column load), or leave the key out");
  }
  return named;
}

Robot WithCompliances(Robot robot, const std::vector<std::string>& joints) {
  const auto add = [&robot](int joint) {
    for (const JointCompliance& compliance : robot.compliances) {
      if (compliance.joint == joint) return;
    }
    robot.compliances.push_back({joint, {{0.0, 0.0}}, false});
  };
  for (const std::string& name : joints) add(robot.chain.FindJoint(name));
  if (robot.gravity_compensator) add(robot.gravity_compensator->joint);
  std::stable_sort(robot.compliances.begin(), robot.compliances.end(),
                   [](const auto& a, const auto& b) { return a.joint < b.joint; });
  return robot;
}

void SetFree(CalibrationProblem* problem) {
  ParameterSet& parameters = problem->parameters;
  const EstimateSpec& estimate = problem->experiment().estimate;
  const ModelSelection selected(problem);
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    Coordinate& coordinate = parameters.coordinate(i);
    const ParameterBlock& block = parameters.blocks()[coordinate.block];
    switch (block.kind) {
      case BlockKind::kStationTranslation:
      case BlockKind::kStationRotation:
        coordinate.free = estimate.base;
        break;
      case BlockKind::kMarker:
      case BlockKind::kMarkerRotation:
        coordinate.free = estimate.markers;
        break;
      case BlockKind::kModelParameter:
        coordinate.free = selected.Holds(problem->model().parameters()[block.owner].law, coordinate.name);
        break;
    }
  }
  SetByNames(estimate, problem);
}

}  // namespace sagitta
