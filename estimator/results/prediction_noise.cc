#include "estimator/results/prediction_noise.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/noise/robot_scatter.h"
#include "estimator/noise/rotation_noise.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;
using From = NoiseSpec::From;

const VarianceComponent* InstrumentComponent(const Estimate& estimate) {
  const std::vector<VarianceComponent>& components = estimate.noise_report.components;
  return components.empty() ? nullptr : &components[0];
}

// One sigma for all coordinates, m; 0: there is none.
double SigmaOfAllCoordinates(const CalibrationProblem& problem, const Estimate& estimate) {
  const VarianceComponent* instrument = InstrumentComponent(estimate);
  if (instrument != nullptr && !estimate.noise_report.instrument_is_factor) return instrument->value;
  return estimate.sigma.stated ? problem.experiment().noise.sigma.value_or(0.0) : estimate.sigma.estimated;
}

// Spread of the residuals, pooled over the groups of each axis.
std::optional<Vector3<double>> SpreadPerAxis(const NoiseReport& report) {
  Vector3<double> squares = Vector3<double>::Zero(), rows = Vector3<double>::Zero();
  for (const NoiseGroup& group : report.groups) {
    if (group.axis < 0) return std::nullopt;
    squares[group.axis] += group.rows * group.sigma * group.sigma;
    rows[group.axis] += group.rows;
  }
  if (!(rows.minCoeff() > 0.0)) return std::nullopt;
  return squares.cwiseQuotient(rows).cwiseSqrt();
}

Json SpreadToJson(const NoiseSpec& spec, const NoiseReport& report) {
  std::map<std::string, Vector3<double>> spread;
  for (const NoiseGroup& group : report.groups) {
    spread.try_emplace(group.of, Vector3<double>::Zero()).first->second[group.axis] = group.sigma;
  }
  Json json = {{"by", WordOf(spec.group)}, {"sigma_axis_mm", Json::object()}};
  for (const auto& [name, sigma] : spread) {
    json["sigma_axis_mm"][name] = {1e3 * sigma.x(), 1e3 * sigma.y(), 1e3 * sigma.z()};
  }
  return json;
}

// Readings to come are of the same stations and markers, and at other configurations.
bool GroupsComeAgain(const NoiseSpec& spec) {
  return spec.from == From::kResiduals &&
         (spec.group == ResidualGroup::kStationAxis || spec.group == ResidualGroup::kMarkerAxis);
}

void ReadSpread(const JsonValue& json, PredictionNoise* noise) {
  const JsonValue by = json.Get("by");
  for (const ResidualGroup group : {ResidualGroup::kStationAxis, ResidualGroup::kMarkerAxis}) {
    if (by.Text() == WordOf(group)) noise->spread_by = group;
  }
  if (!noise->spread_by) by.Fail("station-axis or marker-axis is expected");
  for (const auto& [name, sigma] : json.Get("sigma_axis_mm").Entries()) {
    noise->spread[name] = sigma.Triple() / 1e3;
    if (noise->spread[name].minCoeff() < 0.0) sigma.Fail("a standard deviation is not below 0");
  }
}

// Of a point that states none; nothing: it is not known so.
std::optional<Vector3<double>> SpreadOf(const PredictionNoise& noise, const Measurements& data,
                                        const Observation& row) {
  if (!noise.spread_by) return noise.sigma_axis;
  const bool by_station = *noise.spread_by == ResidualGroup::kStationAxis;
  const auto found =
      noise.spread.find(by_station ? data.stations[data.shots[row.shot].station] : data.markers[row.marker]);
  return found == noise.spread.end() ? noise.sigma_axis : found->second;
}

std::optional<Vector3<double>> SigmaPerAxis(const CalibrationProblem& problem, const Estimate& estimate) {
  if (problem.repeat_scatter) return problem.repeat_scatter->sigma;
  return SpreadPerAxis(estimate.noise_report);
}

Json InstrumentToJson(const NoiseSpec& noise) {
  return {{"range_um", 1e6 * noise.range},
          {"range_um_per_m", 1e6 * noise.range_per_m},
          {"angle_um", 1e6 * noise.angle},
          {"angle_um_per_m", 1e6 * noise.angle_per_m}};
}

void ReadInstrument(const JsonValue& json, NoiseSpec* noise) {
  const auto micrometres = [&json](const char* key) { return json.Get(key).NotNegativeNumber() / 1e6; };
  noise->from = From::kInstrument;
  noise->range = micrometres("range_um");
  noise->range_per_m = micrometres("range_um_per_m");
  noise->angle = micrometres("angle_um");
  noise->angle_per_m = micrometres("angle_um_per_m");
}

// stated: by row, instrument or one sigma of points, or zero. Where repeats give the noise of points, they go before
// what rows state.
Matrix3<double> RotationRoot(const PredictionNoise& noise, const Observation& row, const Matrix3<double>& stated) {
  const bool is_known = noise.sigma_rotation.minCoeff() > 0.0, states = row.rotation().sigma.minCoeff() > 0.0;
  if (is_known && !(states && IsStated(stated))) return noise.sigma_rotation.asDiagonal();
  if (IsStated(stated) || !noise.sigma_axis) return stated;
  if (states) return row.rotation().sigma.asDiagonal();
  return kUnstatedRotationSigma * Matrix3<double>::Identity();
}

// rad, of every axis of rotations; 0: rows state it, or it is assumed.
double SigmaOfRotations(const CalibrationProblem& problem, const Estimate& estimate, double of_points) {
  if (const VarianceComponent* rotation = RotationComponent(estimate.noise_report)) return rotation->value;
  if (problem.rotation_noise > 0.0) return problem.rotation_noise / problem.stated_noise_factor;
  const VarianceComponent* instrument = InstrumentComponent(estimate);
  const bool is_estimated =
      instrument != nullptr ? !estimate.noise_report.instrument_is_factor : !estimate.sigma.stated;
  // One estimated sigma of points goes for rotations over 1 m (problems/noise_model.h).
  return is_estimated && estimate.fit.rotations > 0 && std::isfinite(of_points) ? of_points : 0.0;
}

}  // namespace

Json PredictionNoiseToJson(const CalibrationProblem& problem, const Estimate& estimate) {
  const SigmaReport& sigma = estimate.sigma;
  const bool by_instrument = problem.experiment().noise.from == From::kInstrument;
  Json json = Json::object();
  const double common = SigmaOfAllCoordinates(problem, estimate) / problem.stated_noise_factor;
  json["sigma_mm"] = !by_instrument && common > 0.0 && std::isfinite(common) ? Json(1e3 * common) : Json(nullptr);
  if (by_instrument) json["instrument"] = InstrumentToJson(problem.experiment().noise);
  if (const auto axes = SigmaPerAxis(problem, estimate)) {
    json["sigma_axis_mm"] = {1e3 * axes->x(), 1e3 * axes->y(), 1e3 * axes->z()};
  }
  if (GroupsComeAgain(problem.experiment().noise) && !estimate.noise_report.groups.empty()) {
    json["spread"] = SpreadToJson(problem.experiment().noise, estimate.noise_report);
  }
  if (const double rotation = SigmaOfRotations(problem, estimate, common); rotation > 0.0) {
    json["sigma_rot_urad"] = 1e6 * rotation;
  } else if (problem.repeat_scatter && problem.repeat_scatter->rotation_sigma.minCoeff() > 0.0) {
    const Vector3<double> urad = 1e6 * problem.repeat_scatter->rotation_sigma;
    json["sigma_rot_axis_urad"] = {urad.x(), urad.y(), urad.z()};
  }
  const VarianceComponent* instrument = InstrumentComponent(estimate);
  const bool is_factor = instrument != nullptr && estimate.noise_report.instrument_is_factor;
  json["instrument_factor"] = is_factor ? instrument->value : problem.stated_noise_factor;
  for (const ScaledGroup& scaled : problem.scaled_groups) {
    const std::string name = NameOf(scaled.group, problem.data());
    json["groups"].push_back({{"of", WordOf(scaled.group.kind)}, {"name", name}, {"factor", scaled.factor}});
  }
  const double scatter = ScatterBeyondStated(problem, estimate);
  json["scale"] = sigma.stated && sigma.scaled && scatter == 0.0 ? sigma.a_posteriori : 1.0;
  if (scatter > 0.0) json["scatter_mm"] = 1e3 * scatter;
  json["repeatability_urad"] = Json::object();
  json["repeatability_um"] = Json::object();
  for (int i = 0; i < problem.latent.size(); ++i) {
    const Joint& joint = problem.robot().chain.joints[problem.latent.joints[i]];
    const char* key = joint.type == JointType::kRevolute ? "repeatability_urad" : "repeatability_um";
    json[key][joint.name] = 1e6 * problem.latent.sigmas[i];
  }
  return json;
}

PredictionNoise ReadPredictionNoise(const JsonValue& json, Experiment* experiment) {
  PredictionNoise noise;
  const JsonValue sigma = json.Get("sigma_mm");
  if (!sigma.IsNull()) experiment->noise.sigma = sigma.NotNegativeNumber() / 1e3;
  if (const auto instrument = json.Find("instrument")) ReadInstrument(*instrument, &experiment->noise);
  if (const auto axes = json.Find("sigma_axis_mm")) {
    noise.sigma_axis = axes->Triple() / 1e3;
    if (noise.sigma_axis->minCoeff() < 0.0) axes->Fail("a standard deviation is not below 0");
  }
  if (const auto spread = json.Find("spread")) ReadSpread(*spread, &noise);
  if (const auto rotation = json.Find("sigma_rot_urad")) {
    noise.sigma_rotation.setConstant(rotation->PositiveNumber() / 1e6);
  }
  if (const auto axes = json.Find("sigma_rot_axis_urad")) {
    noise.sigma_rotation = axes->Triple() / 1e6;
    if (!(noise.sigma_rotation.minCoeff() > 0.0)) axes->Fail("a standard deviation is above 0");
  }
  if (const auto factor = json.Find("instrument_factor")) noise.instrument_factor = factor->NotNegativeNumber();
  if (const auto groups = json.Find("groups")) {
    for (const JsonValue& group : groups->Items()) {
      noise.groups.push_back({group.Get("of").Text(), group.Get("name").Text(), group.Get("factor").PositiveNumber()});
    }
  }
  if (const auto scatter = json.Find("scatter_mm")) noise.scatter = scatter->NotNegativeNumber() / 1e3;
  const auto read = [&json](const char* key, RepeatabilitySpec::OfKind* kind) {
    const auto joints = json.Find(key);
    if (!joints) return;
    for (const auto& [joint, value] : joints->Entries()) kind->per_joint[joint] = value.NotNegativeNumber() / 1e6;
  };
  read("repeatability_urad", &experiment->repeatability.angle);
  read("repeatability_um", &experiment->repeatability.length);
  noise.scale = json.Get("scale").PositiveNumber();
  return noise;
}

NoiseRoots PredictionRoots(const CalibrationProblem& problem, const PredictionNoise& noise,
                           const Eigen::Matrix3Xd& points) {
  NoiseRoots roots;
  const Measurements& data = problem.data();
  std::vector<ScaledGroup> scaled;  // of them, what these rows have
  for (const PredictionNoise::Group& group : noise.groups) {
    if (const auto found = FindGroup(group.kind, group.name, data)) scaled.push_back({*found, group.factor});
  }
  for (size_t i = 0; i < data.observations.size(); ++i) {
    Matrix3<double> root = StatedRoot(problem.experiment(), data, data.observations[i], points.col(i));
    const Observation& observation = data.observations[i];
    if (observation.is_point()) {
      const std::optional<Vector3<double>> spread = SpreadOf(noise, data, observation);
      if (!IsStated(root) && spread) root = spread->asDiagonal();
    } else {
      root = RotationRoot(noise, observation, root);
    }
    root = noise.instrument_factor * ScaledRoot({problem.experiment(), data, observation, points.col(i), root}, scaled);
    if (noise.scatter > 0.0 && observation.is_point() && IsStated(root)) {
      root = LowerRoot(root * root.transpose() + noise.scatter * noise.scatter * Matrix3<double>::Identity());
    }
    roots.push_back(root);
  }
  return roots;
}

}  // namespace sagitta
