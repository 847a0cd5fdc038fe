#include "problems/calibration_problem.h"

#include <algorithm>
#include <set>

#include "models/default_free_set.h"
#include "models/effects/catalogue.h"
#include "problems/input_error.h"
#include "problems/loads.h"
#include "problems/split.h"

namespace sagitta {
namespace {

[[noreturn]] void Fail(const CalibrationProblem& problem, const std::string& key, const std::string& what,
                       const std::string& hint = "") {
  throw InputError({problem.experiment.file, 0, key}, what, hint);
}

// What FORMATS allows and this version cannot honour yet is refused, not ignored.
void RefuseUnsupported(const CalibrationProblem& problem) {
  const Experiment& experiment = problem.experiment;
  if (experiment.repeatability.estimate) {
    Fail(problem, "repeatability_urad", "estimating the repeatability is not supported yet", "state a value");
  }
  if (experiment.loss != "none") Fail(problem, "loss", "robust losses are not supported yet", "use none");
  if (experiment.weights == "eq14") Fail(problem, "weights", "eq14 is not supported yet", "use sigma or equal");
  if (experiment.covariance != "model") Fail(problem, "covariance", "only model is supported yet", "use model");
  using From = NoiseSpec::From;
  if (experiment.noise.from == From::kRepeats || experiment.noise.from == From::kResiduals ||
      experiment.noise.from == From::kInstrument || experiment.noise.from == From::kVarianceComponents) {
    Fail(problem, "noise", "this noise model is not supported yet", "use sigma_mm or {from: rows}");
  }
}

std::vector<int> ResolveMarkerFrames(const CalibrationProblem& problem) {
  const Chain& chain = problem.robot.chain;
  std::vector<std::string> places = {"flange", "base", "world"};
  for (const Joint& joint : chain.joints) places.push_back(joint.name);
  std::vector<int> frames;
  for (const std::string& name : problem.data.markers) {
    const auto spec = problem.experiment.markers.find(name);
    const std::string on = spec == problem.experiment.markers.end() ? "flange" : spec->second.on;
    const int joint = chain.FindJoint(on);
    if (on == "flange") {
      frames.push_back(chain.FlangeFrame());
    } else if (on == "base" || on == "world") {
      frames.push_back(on == "base" ? chain.BaseFrame() : chain.WorldFrame());
    } else if (joint >= 0) {
      frames.push_back(chain.FrameAfterJoint(joint));
    } else {
      Fail(problem, "markers." + name + ".on", "'" + on + "' is no place on this robot", SpellingHint(on, places));
    }
  }
  return frames;
}

void CheckNames(const CalibrationProblem& problem) {
  for (const auto& [name, spec] : problem.experiment.markers) {
    const auto& known = problem.data.markers;
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      Fail(problem, "markers." + name, "no row measures this marker", SpellingHint(name, known));
    }
  }
  for (const auto& [name, spec] : problem.experiment.stations) {
    const auto& known = problem.data.stations;
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      Fail(problem, "stations." + name, "no row is measured from this station", SpellingHint(name, known));
    }
  }
}

void SetStartValues(CalibrationProblem* problem) {
  const Experiment& experiment = problem->experiment;
  for (size_t s = 0; s < problem->data.stations.size(); ++s) {
    const auto spec = experiment.stations.find(problem->data.stations[s]);
    const bool given = spec != experiment.stations.end() && (spec->second.base_xyz || spec->second.base_rotvec);
    if (!given && !experiment.estimate.base) {
      Fail(*problem, "estimate.base", "the base is held but station '" + problem->data.stations[s] + "' has no pose",
           "state stations: {" + problem->data.stations[s] + ": {xyz_mm: …, rotvec_mrad: …}}");
    }
    if (!given) continue;
    Pose<double> pose;
    pose.translation = spec->second.base_xyz.value_or(Vector3<double>::Zero());
    pose.rotation = RotationFromVector(spec->second.base_rotvec.value_or(Vector3<double>::Zero()));
    problem->parameters.SetBaseInStation(s, pose);
  }
  for (size_t m = 0; m < problem->data.markers.size(); ++m) {
    const auto spec = experiment.markers.find(problem->data.markers[m]);
    const bool given = spec != experiment.markers.end() && spec->second.point;
    if (!given && !experiment.estimate.markers) {
      Fail(*problem, "estimate.markers",
           "the markers are held but marker '" + problem->data.markers[m] + "' has no point",
           "state markers: {" + problem->data.markers[m] + ": {xyz_mm: …}}");
    }
    if (given) problem->parameters.SetMarkerPoint(m, *spec->second.point);
  }
}

// Which of `all` a selection names; `what` for messages.
std::vector<std::string> SelectFrom(const std::vector<std::string>& all, const Selection& selection,
                                    const std::string& key, const std::string& what, const std::string& file) {
  if (selection.kind == Selection::Kind::kAll) return all;
  if (selection.kind != Selection::Kind::kList) return {};
  for (const std::string& name : selection.names) {
    if (std::find(all.begin(), all.end(), name) != all.end()) continue;
    throw InputError({file, 0, key}, "the robot has no " + what + " '" + name + "'", SpellingHint(name, all));
  }
  return selection.names;
}

std::vector<std::string> FreeErrors(CalibrationProblem* problem) {
  const Selection& selection = problem->experiment.estimate.geometry;
  if (selection.kind != Selection::Kind::kDefault) {
    std::vector<std::string> all;
    for (const ElementaryTransform& transform : problem->robot.chain.transforms) {
      if (!transform.error.empty()) all.push_back(transform.error);
    }
    return SelectFrom(all, selection, "estimate.geometry", "geometric error", problem->experiment.file);
  }
  const EstimateSpec& estimate = problem->experiment.estimate;
  FreeSet set = DefaultFreeSet(problem->robot.chain, {estimate.base, estimate.markers});
  problem->redundant_errors = set.redundant;
  return set.free;
}

bool AnyLoaded(const Measurements& data) { return std::any_of(data.shots.begin(), data.shots.end(), IsLoaded); }

// Joints whose compliance is asked for; by default all of them where rows are
// loaded (what a load does not excite is held later, with words).
std::vector<std::string> CompliantJoints(const Robot& robot, const Measurements& data, const Experiment& experiment) {
  std::vector<std::string> all;
  for (const Joint& joint : robot.chain.joints) all.push_back(joint.name);
  const Selection& selection = experiment.estimate.compliance;
  if (selection.kind == Selection::Kind::kDefault) return AnyLoaded(data) ? all : std::vector<std::string>();
  const std::vector<std::string> named = SelectFrom(all, selection, "estimate.compliance", "joint", experiment.file);
  if (!named.empty() && !AnyLoaded(data) && experiment.tool_mass == 0.0) {
    throw InputError({experiment.file, 0, "estimate.compliance"}, "compliances are asked for but no row is loaded",
                     "measure loaded shots (column load), or leave the key out");
  }
  return named;
}

std::vector<std::string> FreeSpring(const CalibrationProblem& problem) {
  const Selection& selection = problem.experiment.estimate.gravity_compensator;
  if (selection.kind == Selection::Kind::kDefault || selection.kind == Selection::Kind::kNone) return {};
  if (!problem.robot.gravity_compensator) {
    Fail(problem, "estimate.gravity_compensator", "the robot has no gravity_compensator",
         "describe it in the robot file: joint, L_mm, a_x_mm, a_y_mm, s0_mm, Kc_N_per_mm");
  }
  return SelectFrom({"L", "a_x", "a_y", "s0", "Kc"}, selection, "estimate.gravity_compensator", "compensator parameter",
                    problem.experiment.file);
}

// Joints that are to be estimated start rigid where the file states nothing.
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
  const EstimateSpec& estimate = problem->experiment.estimate;
  const std::vector<std::string> errors = FreeErrors(problem);
  const std::vector<std::string> compliant = CompliantJoints(problem->robot, problem->data, problem->experiment);
  const std::vector<std::string> spring = FreeSpring(*problem);
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    Coordinate& coordinate = parameters.coordinate(i);
    const std::string family = coordinate.name.substr(0, coordinate.name.find('/'));
    if (family == "base") coordinate.free = estimate.base;
    if (family == "marker") coordinate.free = estimate.markers;
    const std::string name = coordinate.name.substr(family.size() + 1);
    const auto is_in = [&](const std::vector<std::string>& names, const std::string& wanted) {
      return std::find(names.begin(), names.end(), wanted) != names.end();
    };
    if (family == "geometry") coordinate.free = is_in(errors, name);
    if (family == "compliance") coordinate.free = is_in(compliant, name.substr(0, name.find('@')));
    if (family == "compensator") coordinate.free = is_in(spring, name);
    if (family == "effect") coordinate.free = estimate.effects.kind != Selection::Kind::kNone;
  }
  const auto apply = [&](const std::vector<std::string>& names, const char* key, bool free) {
    std::vector<std::string> known;
    for (const Coordinate& coordinate : parameters.coordinates()) known.push_back(coordinate.name);
    for (const std::string& name : names) {
      const std::vector<int> matches = parameters.Match(name);
      if (matches.empty()) Fail(*problem, key, "there is no parameter '" + name + "'", SpellingHint(name, known));
      for (const int i : matches) parameters.coordinate(i).free = free;
    }
  };
  apply(estimate.free, "--free", true);
  apply(estimate.fixed, "--fixed", false);
}

// Targets that only the data know.
void CheckEffects(const CalibrationProblem& problem) {
  std::set<std::string> loads;
  for (const Shot& shot : problem.data.shots) loads.insert(shot.load);
  for (const EffectSpec& spec : problem.robot.effects) {
    std::vector<std::string> known;
    switch (FindEffect(spec.effect)->target) {
      case EffectTarget::kStation:
        known = problem.data.stations;
        break;
      case EffectTarget::kMarker:
        known = problem.data.markers;
        break;
      case EffectTarget::kLoad:
        known.assign(loads.begin(), loads.end());
        break;
      default:
        continue;
    }
    if (std::find(known.begin(), known.end(), spec.target) != known.end()) continue;
    throw InputError({problem.experiment.robot_file, 0, "effects"},
                     "effect " + spec.effect + ": the data have no '" + spec.target + "'",
                     SpellingHint(spec.target, known));
  }
}

// Columns that an effect of the robot needs.
void CheckEffectColumns(const CalibrationProblem& problem) {
  for (const EffectSpec& spec : problem.robot.effects) {
    for (size_t s = 0; s < problem.shot_inputs.size(); ++s) {
      const EffectContext context{&problem.robot, &spec, &problem.shot_inputs[s].conditions, &problem.data.markers, 0};
      const std::string column = FindEffect(spec.effect)->missing(context);
      if (column.empty()) continue;
      const Observation& first = problem.data.observations[problem.data.shots[s].observations.front()];
      const MeasurementFile& file = problem.data.files[first.file];
      throw InputError({file.path, file.rows[first.row].line, column}, "effect " + spec.Path() + " needs this column",
                       "add it, or take the effect out of the robot file");
    }
  }
}

void SetPriors(CalibrationProblem* problem) {
  std::vector<std::string> known;
  for (const Coordinate& coordinate : problem->parameters.coordinates()) known.push_back(coordinate.name);
  for (const auto& [name, prior] : problem->experiment.priors) {
    const std::string key = "priors." + name;
    const int i = problem->parameters.FindCoordinate(name);
    if (i < 0) Fail(*problem, key, "there is no parameter '" + name + "'", SpellingHint(name, known));
    if (!problem->sigma_is_stated()) {
      Fail(*problem, key, "a prior weighs against the noise, and no noise is stated", "state noise: {sigma_mm: …}");
    }
    Coordinate& coordinate = problem->parameters.coordinate(i);
    if (coordinate.quantity == Quantity::kRotationVector) {
      Fail(*problem, key, "a prior on one axis of a rotation is not supported",
           "hold the station's pose instead (--fixed)");
    }
    coordinate.prior_value = prior.value * TraitsOf(coordinate.quantity).si_per_unit;
    coordinate.prior_sigma = prior.sigma * TraitsOf(coordinate.quantity).si_per_unit;
  }
}

// A spring can neither have no length nor be pressed through zero.
void CheckCompensator(const CalibrationProblem& problem) {
  if (!problem.robot.gravity_compensator) return;
  const GravityCompensator& c = *problem.robot.gravity_compensator;
  const CompensatorParameters<double> parameters{c.L, c.a_x, c.a_y, c.s0, c.Kc};
  if (c.L <= 0.0 || c.s0 <= 0.0 || c.Kc < 0.0) {
    throw InputError({problem.experiment.robot_file, 0, "gravity_compensator"},
                     "L and s0 must be positive and Kc not negative", "state lengths in mm, stiffness in N/mm");
  }
  for (const Configuration& configuration : problem.data.configurations) {
    if (CompensatorSpringLength(parameters, configuration.q[c.joint]) > 1e-3 * c.s0) continue;
    throw InputError({problem.experiment.robot_file, 0, "gravity_compensator"},
                     "the spring would have no length at configuration '" + configuration.id + "'",
                     "check L, a_x and a_y: the lever end would lie on the anchor");
  }
}

void CheckSigmas(const CalibrationProblem& problem) {
  if (!problem.sigma_is_stated()) {
    if (problem.latent.empty()) return;
    Fail(problem, "repeatability_urad", "the repeatability is stated but the instrument's noise is not",
         "state noise: {sigma_mm: …}, sigma columns, or --sigma_mm");
  }
  for (const Observation& observation : problem.data.observations) {
    if (problem.StatedSigma(observation).minCoeff() > 0.0) continue;
    const MeasurementFile& file = problem.data.files[observation.file];
    throw InputError({file.path, file.rows[observation.row].line, "sigma_x_mm"},
                     "other rows state standard deviations, this one has none",
                     "add the columns, state noise: {sigma_mm: …}, or give --sigma_mm");
  }
}

// What no estimate can come from.
void CheckEnoughData(const CalibrationProblem& problem) {
  std::set<int> configurations;
  std::vector<bool> station_seen(problem.data.stations.size()), marker_seen(problem.data.markers.size());
  const std::vector<int> observations = problem.CalibrationObservations();
  for (const int i : observations) {
    const Observation& observation = problem.data.observations[i];
    const Shot& shot = problem.data.shots[observation.shot];
    configurations.insert(shot.configuration);
    station_seen[shot.station] = true;
    marker_seen[observation.marker] = true;
  }
  const std::string file = problem.data.files.empty() ? "" : problem.data.files[0].path;
  for (size_t s = 0; s < station_seen.size(); ++s) {
    if (station_seen[s]) continue;
    throw InputError({file, 0, "station"}, "station '" + problem.data.stations[s] + "' has validation rows only",
                     "its base pose cannot be estimated; move some of its configurations to calibration");
  }
  for (size_t m = 0; m < marker_seen.size(); ++m) {
    if (marker_seen[m]) continue;
    throw InputError({file, 0, "marker"}, "marker '" + problem.data.markers[m] + "' has validation rows only",
                     "its point cannot be estimated; move some of its configurations to calibration");
  }
  const int unknowns = problem.parameters.EstimatedCoordinates().size();
  if (unknowns == 0) throw InputError({file, 0, ""}, "nothing is free: there is nothing to estimate");
  if (configurations.size() < 2) {
    throw InputError({file, 0, "config"}, "one configuration cannot tell the robot from the base",
                     "measure at least two, better thirty, different configurations");
  }
  const int equations = 3 * observations.size();
  if (equations < unknowns) {
    throw InputError(
        {file, 0, ""},
        "fewer equations (" + std::to_string(equations) + ") than unknowns (" + std::to_string(unknowns) + ")",
        "measure more configurations or free less (estimate.geometry, --fixed)");
  }
}

}  // namespace

CalibrationProblem::CalibrationProblem(Robot robot_in, Measurements data_in, Experiment experiment_in)
    : robot(std::move(robot_in)),
      data(std::move(data_in)),
      experiment(std::move(experiment_in)),
      model(robot, data.markers),
      parameters(data.stations, data.markers, model.parameters()) {
  robot = model.robot();  // with the tilt slots that effects need
}

Vector3<double> CalibrationProblem::StatedSigma(const Observation& observation) const {
  const Vector3<double> fallback = Vector3<double>::Constant(experiment.noise.sigma.value_or(0.0));
  if (experiment.weights == "equal" || experiment.noise.replaces_rows) return fallback;
  return observation.sigma.minCoeff() > 0.0 ? observation.sigma : fallback;
}

bool CalibrationProblem::sigma_is_stated() const {
  for (const Observation& observation : data.observations) {
    if (StatedSigma(observation).minCoeff() > 0.0) return true;
  }
  return false;
}

std::vector<int> CalibrationProblem::CalibrationObservations() const {
  std::vector<int> indices;
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& observation = data.observations[i];
    if (!observation.excluded && !data.IsValidation(observation)) indices.push_back(i);
  }
  return indices;
}

std::vector<int> CalibrationProblem::ValidationObservations() const {
  std::vector<int> indices;
  for (size_t i = 0; i < data.observations.size(); ++i) {
    if (data.IsValidation(data.observations[i])) indices.push_back(i);
  }
  return indices;
}

CalibrationProblem CalibrationProblem::WithEffect(const EffectSpec& spec) const {
  Robot extended = robot;
  extended.effects.push_back(spec);
  CalibrationProblem problem(std::move(extended), data, experiment);
  problem.parameters.CopyByName(parameters);
  problem.marker_frames = ResolveMarkerFrames(problem);
  problem.shot_inputs = MakeShotInputs(problem.model, problem.data, problem.experiment);
  problem.latent = latent;
  problem.redundant_errors = redundant_errors;
  return problem;
}

CalibrationProblem MakeCalibrationProblem(Robot robot, Measurements data, Experiment experiment) {
  SplitConfigurations(experiment.validation, &data);
  CheckLoadStates(&data);
  const std::vector<std::string> compliant = CompliantJoints(robot, data, experiment);
  Robot elastic = WithCompliances(std::move(robot), compliant);
  CalibrationProblem problem(std::move(elastic), std::move(data), std::move(experiment));
  RefuseUnsupported(problem);
  CheckNames(problem);
  CheckCompensator(problem);
  CheckEffects(problem);
  problem.marker_frames = ResolveMarkerFrames(problem);
  problem.shot_inputs = MakeShotInputs(problem.model, problem.data, problem.experiment);
  CheckEffectColumns(problem);
  problem.latent = MakeLatentModel(problem.robot.chain, problem.data, problem.experiment);
  SetStartValues(&problem);
  SetFree(&problem);
  CheckSigmas(problem);
  SetPriors(&problem);
  CheckEnoughData(problem);
  return problem;
}

}  // namespace sagitta
