#include "problems/calibration_problem.h"

#include <algorithm>

#include "models/effects/catalogue.h"
#include "problems/experiment_checks.h"
#include "problems/free_selection.h"
#include "problems/input_error.h"
#include "problems/loads.h"
#include "problems/noise_checks.h"
#include "problems/problem_checks.h"
#include "problems/robot_structure.h"
#include "problems/split.h"
#include "problems/spring_tie.h"
#include "problems/structure_checks.h"
#include "problems/structure_failure.h"

namespace sagitta {
namespace {

// A place and a joint of one name. The flange is where a marker is that states nothing: that word is never the joint.
void CheckOneMeaning(const Chain& chain, const Experiment& experiment, const std::string& marker,
                     const MarkerPlace& on) {
  if (on.kind != MarkerPlace::Kind::kBase && on.kind != MarkerPlace::Kind::kWorld) return;
  if (chain.FindJoint(on.Word()) < 0) return;
  FailProblem(experiment, "markers." + marker + ".on", "'" + on.Word() + "' is a joint of this robot too",
              "give the joint another name in the robot file");
}

int FrameOf(const Chain& chain, const Experiment& experiment, const std::string& marker, const MarkerPlace& on) {
  CheckOneMeaning(chain, experiment, marker, on);
  switch (on.kind) {
    case MarkerPlace::Kind::kFlange:
      return chain.FlangeFrame();
    case MarkerPlace::Kind::kBase:
      return chain.BaseFrame();
    case MarkerPlace::Kind::kWorld:
      return chain.WorldFrame();
    case MarkerPlace::Kind::kJoint:
      break;
  }
  const int joint = chain.FindJoint(on.joint);
  if (joint >= 0) return chain.FrameAfterJoint(joint);
  std::vector<std::string> places = MarkerPlace::Words();
  for (const Joint& other : chain.joints) places.push_back(other.name);
  FailProblem(experiment, "markers." + marker + ".on", "'" + on.joint + "' is no place on this robot",
              SpellingHint(on.joint, places));
}

std::vector<int> ResolveMarkerFrames(const Chain& chain, const Measurements& data, const Experiment& experiment) {
  std::vector<int> frames;
  for (const std::string& name : data.markers) {
    const auto spec = experiment.markers.find(name);
    frames.push_back(
        FrameOf(chain, experiment, name, spec == experiment.markers.end() ? MarkerPlace() : spec->second.on));
  }
  return frames;
}

[[noreturn]] void FailNoPose(const CalibrationProblem& problem, const std::string& key, const std::string& station) {
  FailProblem(problem, key, "the base is held but station '" + station + "' has no pose",
              "state stations: {" + station + ": {xyz_mm: …, rotvec_mrad: …}}");
}

[[noreturn]] void FailNoPoint(const CalibrationProblem& problem, const std::string& key, const std::string& marker) {
  FailProblem(problem, key, "the markers are held but marker '" + marker + "' has no point",
              "state markers: {" + marker + ": {xyz_mm: …}}");
}

[[noreturn]] void FailNoRotation(const CalibrationProblem& problem, const std::string& key, const std::string& marker) {
  FailProblem(problem, key, "the markers are held but marker '" + marker + "', read as a pose, has no rotation",
              "state markers: {" + marker + ": {xyz_mm: …, rotvec_mrad: …}}");
}

// What --fixed holds needs a value to be held at: bases and markers have no nominal one.
void CheckHeldIsStated(const CalibrationProblem& problem) {
  const Experiment& experiment = problem.experiment();
  if (experiment.estimate.fixed.empty()) return;
  for (const Coordinate& coordinate : problem.parameters.coordinates()) {
    const ParameterBlock& block = problem.parameters.blocks()[coordinate.block];
    if (coordinate.free || block.kind == BlockKind::kModelParameter) continue;
    if (block.kind == BlockKind::kStationTranslation || block.kind == BlockKind::kStationRotation) {
      const std::string& station = problem.data().stations[block.owner];
      const auto spec = experiment.stations.find(station);
      const bool given = spec != experiment.stations.end() && (spec->second.base_xyz || spec->second.base_rotvec);
      if (!given) FailNoPose(problem, "--fixed", station);
      continue;
    }
    const std::string& marker = problem.data().markers[block.owner];
    const auto spec = experiment.markers.find(marker);
    const bool is_known = spec != experiment.markers.end();
    if (block.kind == BlockKind::kMarker && !(is_known && spec->second.point)) FailNoPoint(problem, "--fixed", marker);
    if (block.kind == BlockKind::kMarkerRotation && !(is_known && spec->second.rotvec)) {
      FailNoRotation(problem, "--fixed", marker);
    }
  }
}

void SetStartValues(CalibrationProblem* problem) {
  const Experiment& experiment = problem->experiment();
  for (size_t s = 0; s < problem->data().stations.size(); ++s) {
    const auto spec = experiment.stations.find(problem->data().stations[s]);
    const bool given = spec != experiment.stations.end() && (spec->second.base_xyz || spec->second.base_rotvec);
    if (!given && !experiment.estimate.base) {
      FailNoPose(*problem, "estimate.base", problem->data().stations[s]);
    }
    if (!given) continue;
    Pose<double> pose;
    pose.translation = spec->second.base_xyz.value_or(Vector3<double>::Zero());
    pose.rotation = RotationFromVector(spec->second.base_rotvec.value_or(Vector3<double>::Zero()));
    problem->parameters.SetBaseInStation(s, pose);
  }
  for (size_t m = 0; m < problem->data().markers.size(); ++m) {
    const auto spec = experiment.markers.find(problem->data().markers[m]);
    const bool given = spec != experiment.markers.end() && spec->second.point;
    if (!given && !experiment.estimate.markers) {
      FailNoPoint(*problem, "estimate.markers", problem->data().markers[m]);
    }
    if (given) problem->parameters.SetMarkerPoint(m, *spec->second.point);
    if (!problem->parameters.is_oriented(static_cast<int>(m))) continue;
    const bool is_turned = spec != experiment.markers.end() && spec->second.rotvec;
    if (!is_turned && !experiment.estimate.markers) {
      FailNoRotation(*problem, "estimate.markers", problem->data().markers[m]);
    }
    if (is_turned) problem->parameters.SetMarkerRotation(static_cast<int>(m), RotationFromVector(*spec->second.rotvec));
  }
}

void SetPriors(CalibrationProblem* problem) {
  std::vector<std::string> known;
  for (const Coordinate& coordinate : problem->parameters.coordinates()) known.push_back(coordinate.name);
  for (const auto& [name, prior] : problem->experiment().priors) {
    const std::string key = "priors." + name;
    const int i = problem->parameters.FindCoordinate(name);
    if (i < 0) FailProblem(*problem, key, "there is no parameter '" + name + "'", SpellingHint(name, known));
    if (!problem->sigma_is_stated()) {
      FailProblem(*problem, key, "a prior weighs against the noise, and no noise is stated",
                  "state noise: {sigma_mm: …}");
    }
    Coordinate& coordinate = problem->parameters.coordinate(i);
    if (coordinate.quantity == Quantity::kRotationVector) {
      FailProblem(*problem, key, "a prior on one axis of a rotation is not supported",
                  "hold the station's pose instead (--fixed)");
    }
    if (prior.value * TraitsOf(coordinate.quantity).si_per_unit < coordinate.lower) {
      FailProblem(*problem, key, "the prior expects a value that '" + name + "' cannot have: it is not negative",
                  "state a value of 0 or above");
    }
    coordinate.prior_value = prior.value * TraitsOf(coordinate.quantity).si_per_unit;
    coordinate.prior_sigma = prior.sigma * TraitsOf(coordinate.quantity).si_per_unit;
    coordinate.effect_prior = 0.0;  // the experiment's is asked for
    if (coordinate.free) continue;
    problem->mutable_data()->warnings.push_back(
        key + ": '" + name + "' is held, so that its prior counts for nothing; " + "--free=" + name + " estimates it");
  }
}

}  // namespace

template Measurements* SharedValue<Measurements>::Own();
template Experiment* SharedValue<Experiment>::Own();
template std::vector<ShotInput>* SharedValue<std::vector<ShotInput>>::Own();

CalibrationProblem::CalibrationProblem(const CalibrationProblem&) = default;
CalibrationProblem::CalibrationProblem(CalibrationProblem&&) noexcept = default;
CalibrationProblem& CalibrationProblem::operator=(const CalibrationProblem&) = default;
CalibrationProblem& CalibrationProblem::operator=(CalibrationProblem&&) noexcept = default;
CalibrationProblem::~CalibrationProblem() = default;

bool IsGravityCompensator(const EffectSpec& spec) { return spec.effect == kGravityCompensator; }

bool IsWeight(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition* effect = FindEffect(robot, spec.effect);
  return effect != nullptr && effect->is_weight;
}

bool IsParameterOf(const EffectSpec& spec, const std::string& name) {
  const std::string family = IsGravityCompensator(spec) ? WordOf(CoordinateKind::kCompensator) : spec.Path();
  return name != family && IsWithin(name, family);
}

CalibrationProblem::CalibrationProblem(ForwardModel model, SharedValue<Measurements> data,
                                       SharedValue<Experiment> experiment)
    : parameters(data->stations, data->markers, model.parameters(), data->OrientedMarkers()),
      model_(std::move(model)),
      data_(std::move(data)),
      experiment_(std::move(experiment)),
      marker_frames_(ResolveMarkerFrames(model_->robot().chain, *data_, *experiment_)) {
  shot_inputs_ = MakeShotInputs(*model_, *data_, *experiment_);
  latent = MakeLatentModel(robot().chain, *data_, *experiment_);
}

void CalibrationProblem::set_data(Measurements data) {
  fitted_.reset();
  data_ = std::move(data);
  ForgetRows();
  RenewVisits(*data_, &latent);
}

void CalibrationProblem::ForgetRows() {
  resolved_noise.clear();
  weight_roots.clear();
}

void CalibrationProblem::set_shot_inputs(std::vector<ShotInput> inputs) { shot_inputs_ = std::move(inputs); }
std::vector<int> CalibrationProblem::MarkersOnFlange() const {
  std::vector<int> markers;
  for (size_t m = 0; m < marker_frames().size(); ++m) {
    if (marker_frames()[m] == robot().chain.FlangeFrame()) markers.push_back(static_cast<int>(m));
  }
  return markers;
}

void CalibrationProblem::set_marker_frame(int marker, int frame) { (*marker_frames_.Own())[marker] = frame; }

void CalibrationProblem::RenewJoints() {
  std::vector<ShotInput>& inputs = *mutable_shot_inputs();
  for (size_t s = 0; s < inputs.size(); ++s) {
    inputs[s].conditions.q = data_->configurations[data_->shots[s].configuration].q;
  }
  model_->Prepare(&inputs);
}

void CalibrationProblem::RenewShots() {
  shot_inputs_ = MakeShotInputs(*model_, *data_, *experiment_);
  RenewVisits(*data_, &latent);
  const size_t rows = data_->observations.size();
  const auto is_of_others = [rows](const NoiseRoots& roots) { return !roots.empty() && roots.size() != rows; };
  if (is_of_others(resolved_noise) || is_of_others(weight_roots)) ForgetRows();
}

Matrix3<double> CalibrationProblem::SqrtCovariance(int observation) const {
  if (!resolved_noise.empty()) return resolved_noise[observation];
  const Observation& row = data_->observations[observation];
  return StatedRoot(*experiment_, *data_, row, row.point_in_station);
}

bool CalibrationProblem::sigma_is_stated() const {
  for (size_t i = 0; i < data_->observations.size(); ++i) {
    if (IsStated(SqrtCovariance(static_cast<int>(i)))) return true;
  }
  return false;
}

namespace {

// Of configurations that are set aside, or of the others; none that is excluded.
std::vector<int> ObservationsOf(const Measurements& data, bool validation) {
  std::vector<int> indices;
  if (!validation) indices.reserve(data.observations.size());
  int latest = -1;  // shot: rows of one follow each other
  bool own = false;
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& observation = data.observations[i];
    if (observation.shot != latest) own = data.IsValidation(observation) == validation;
    latest = observation.shot;
    if (own && !observation.excluded) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

// What a robot file states of these coordinates, where it states any.
std::vector<double> PriorsOf(const ParameterSet& own, const std::vector<std::string>& names) {
  std::vector<double> priors;
  for (const std::string& name : names) {
    const int i = own.FindCoordinate(name);
    priors.push_back(i < 0 ? 0.0 : own.coordinates()[i].effect_prior);
  }
  const bool any = std::any_of(priors.begin(), priors.end(), [](double sigma) { return sigma > 0.0; });
  return any ? priors : std::vector<double>();
}

template <typename Spec>
void KeepNamed(const std::vector<std::string>& names, std::map<std::string, Spec>* specs) {
  for (auto spec = specs->begin(); spec != specs->end();) {
    const bool is_named = std::find(names.begin(), names.end(), spec->first) != names.end();
    spec = is_named ? std::next(spec) : specs->erase(spec);
  }
}

}  // namespace

std::vector<int> CalibrationProblem::CalibrationObservations() const {
  return fitted_ != nullptr ? *fitted_ : ObservationsOf(*data_, false);
}

std::vector<std::string> CalibrationProblem::InputPaths() const {
  std::vector<std::string> paths = {experiment_->file, experiment_->robot_file};
  for (const MeasurementFile& file : data_->files) paths.push_back(file.path);
  paths.erase(std::remove(paths.begin(), paths.end(), ""), paths.end());
  return paths;
}

std::vector<int> CalibrationProblem::ValidationObservations() const { return ObservationsOf(*data_, true); }

namespace {

bool MovesGeometry(const ForwardModel& model, const std::vector<double>& theta) {
  for (int i = 0; i < model.num_parameters(); ++i) {
    if (model.parameters()[i].law == ParameterLaw::kGeometry && theta[i] != 0.0) return true;
  }
  return false;
}

}  // namespace

// What the robot's temperature counts from where an effect goes with it.
std::optional<double> CalibrationProblem::ReferenceTemperature() const {
  const std::vector<EffectSpec>& effects = robot().effects;
  const auto is_warm = [this](const EffectSpec& spec) {
    return FindEffect(robot(), spec.effect)->DrivenBy(spec) == EffectDriver::kTemperature;
  };
  const bool is_measured =
      std::any_of(data_->shots.begin(), data_->shots.end(), [](const Shot& shot) { return shot.has_temperature; });
  if (!is_measured || std::none_of(effects.begin(), effects.end(), is_warm)) return std::nullopt;
  return OriginsOf(*data_, *experiment_).mean_temperature;
}

Robot CalibrationProblem::RobotWith(const ParameterSet& own) const {
  const std::vector<double> theta = own.ModelValues();
  Robot robot = model_->WithValues(theta);
  if (!robot.controller && MovesGeometry(*model_, theta))
    robot.controller = Kinematics{model_->robot().chain, model_->robot().dh};
  robot.reference_temperature = ReferenceTemperature();
  for (EffectSpec& spec : robot.effects) {
    std::vector<std::string> names;
    for (const EffectParameter& part : FindEffect(robot, spec.effect)->parameters(robot, spec)) {
      names.push_back(spec.Path() + "/" + part.name);
    }
    spec.prior_sigmas = PriorsOf(own, names);
  }
  if (robot.gravity_compensator) {
    std::vector<std::string> names;
    for (const CompensatorPart part : kCompensatorParts) names.push_back(NameOf(part));
    robot.gravity_compensator->prior_sigmas = PriorsOf(own, names);
  }
  return robot;
}

CalibrationProblem CalibrationProblem::WithEffects(const std::vector<EffectSpec>& specs) const {
  Robot extended = robot();
  bool adds_compensator = false;
  for (const EffectSpec& spec : specs) {
    if (!IsGravityCompensator(spec)) {
      extended.effects.push_back(spec);
      continue;
    }
    const std::vector<double>& p = spec.values;
    if (p.empty()) continue;  // the robot's own
    extended.gravity_compensator =
        GravityCompensator{robot().chain.FindJoint(spec.target), p[0], p[1], p[2], p[3], p[4], true};
    adds_compensator = true;
  }
  CheckEffectsAreThere(extended);
  CalibrationProblem problem(ForwardModel(extended, data_->markers), data_, experiment_);
  problem.parameters.CopyByName(parameters);
  if (adds_compensator)
    problem.parameters.coordinate(problem.parameters.FindCoordinate(CompensatorPart::kL)).free = false;
  problem.latent = latent;  // found, not as stated
  problem.found_noise = found_noise;
  problem.resolved_noise = resolved_noise;
  problem.stated_noise_factor = stated_noise_factor;
  problem.noise_origin = noise_origin;
  problem.rotation_noise = rotation_noise;
  problem.scaled_groups = scaled_groups;
  problem.weight_roots = weight_roots;
  problem.repeat_scatter = repeat_scatter;
  problem.redundant_errors = redundant_errors;
  TieSpringMarkers(&problem);
  return problem;
}

CalibrationProblem MakeCalibrationProblem(Robot robot, Measurements data, Experiment experiment) {
  CheckStructure(robot, data);
  CountFromReference(robot, &experiment);
  CheckExperiment(experiment);
  SplitConfigurations(experiment.validation, &data);
  CheckLoadStates(&data);
  CheckStatedLoads(experiment, &data);
  const std::vector<std::string> compliant = CompliantJoints(robot, data, experiment);
  const Robot elastic = WithCompliances(std::move(robot), compliant);
  CheckJointsOfEffects(elastic, experiment);
  ForwardModel model(elastic, data.markers);
  CalibrationProblem problem(std::move(model), std::move(data), std::move(experiment));
  CheckNames(problem);
  CheckCompensator(problem);
  CheckEffects(problem);
  CheckEffectColumns(problem, "remove the effect from the robot file");
  CheckLevelled(problem);
  SetStartValues(&problem);
  SetFree(&problem);
  CheckHeldIsStated(problem);
  CheckNoise(&problem);
  ResolveRepeats(&problem);
  CheckSigmas(problem);
  SayRotationSigmas(&problem);
  SayRounding(&problem);
  SayReplacedSigmas(&problem);
  SetPriors(&problem);
  TieSpringMarkers(&problem);
  problem.fitted_ = std::make_shared<const std::vector<int>>(problem.CalibrationObservations());
  CheckEnoughData(problem);
  return problem;
}

namespace {

// A place that is none would be predicted from without a word.
void CheckPlaces(const Measurements& data, const KnownPlaces& places) {
  for (const std::string& name : data.stations) {
    const auto found = places.base_in_station.find(name);
    if (found == places.base_in_station.end()) continue;
    const std::string item = "station " + name;
    CheckAreNumbers(found->second.translation, item, "a coordinate of its base");
    CheckIsRotation(found->second.rotation, item, "the rotation of its base");
  }
  for (const std::string& name : data.markers) {
    const auto found = places.markers.find(name);
    if (found == places.markers.end()) continue;
    const std::string item = "marker " + name;
    if (found->second.point) CheckAreNumbers(*found->second.point, item, "a coordinate of its point");
    if (found->second.rotvec) CheckAreNumbers(*found->second.rotvec, item, "a coordinate of its rotation vector");
  }
}

}  // namespace

CalibrationProblem MakeKnownProblem(const Robot& robot, Measurements data, Experiment experiment,
                                    const KnownPlaces& places) {
  CheckStructure(robot, data, MarkerlessRows::kAllowed);
  CheckPlaces(data, places);
  CountFromReference(robot, &experiment);
  for (const auto& [name, marker] : places.markers) experiment.markers[name] = marker;
  // Rows need not have every station and marker of the calibration.
  KeepNamed(data.stations, &experiment.stations);
  KeepNamed(data.markers, &experiment.markers);
  CheckJointsOfEffects(robot, experiment);
  ForwardModel model(robot, data.markers);
  CalibrationProblem problem(std::move(model), std::move(data), std::move(experiment));
  const Measurements& rows = problem.data();
  for (size_t s = 0; s < rows.stations.size(); ++s) {
    const auto found = places.base_in_station.find(rows.stations[s]);
    if (found != places.base_in_station.end()) problem.parameters.SetBaseInStation(static_cast<int>(s), found->second);
  }
  for (size_t m = 0; m < rows.markers.size(); ++m) {
    const auto found = places.markers.find(rows.markers[m]);
    if (found == places.markers.end()) continue;
    const MarkerSpec& marker = found->second;
    if (marker.point) problem.parameters.SetMarkerPoint(static_cast<int>(m), *marker.point);
    if (marker.rotvec) problem.parameters.SetMarkerRotation(static_cast<int>(m), RotationFromVector(*marker.rotvec));
  }
  return problem;
}

}  // namespace sagitta
