// The half of estimate_json.h that reads.
#include <cmath>
#include <numeric>

#include "estimator/least_squares/linearization.h"
#include "estimator/results/estimate_json.h"
#include "estimator/results/intervals_json.h"
#include "estimator/results/loading_json.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/robot_file.h"
#include "problems/loads.h"
#include "problems/problem_checks.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

class EstimateReader {
 public:
  // `path`: what messages call it.
  EstimateReader(const std::string& path, const std::string& text) : path_(path), text_(text) {}

  KnownRobot Read() {
    const Json json = Parse();
    known_.file = path_;
    known_.robot = ReadRobotText(Get(json, "robot").dump(), path_);
    ReadStations(Get(json, "stations"));
    ReadMarkers(Get(json, "markers"));
    if (json.contains("loading")) ReadLoading(json.at("loading"), &known_.loading);
    ReadParameters(json);
    for (const Json& input : Get(json, "inputs")) known_.input_hashes.push_back(Get(input, "sha256"));
    ReadCovariance(json);
    if (HasNoNoise(json)) known_.uncertainty.covariance.setConstant(std::nan(""));
    known_.uncertainty.slopes.resize(known_.uncertainty.estimated.size(), 0);
    if (json.contains("held")) ReadHeld(json.at("held"), &known_.uncertainty);
    if (json.contains("prediction_noise")) {
      known_.noise = ReadPredictionNoise(json.at("prediction_noise"), &known_.loading);
    }
    if (json.contains("agreement") && json.at("agreement").is_object()) {
      known_.model_error = Number(Get(json.at("agreement"), "inflation"), "agreement.inflation");
    }
    return known_;
  }

 private:
  [[noreturn]] void Fail(const std::string& key, const std::string& what, const std::string& hint = "") const {
    throw InputError({path_, 0, key}, what, hint);
  }

  Json Parse() const {
    Json json = Json::parse(text_, nullptr, false);
    if (json.is_discarded() || !json.is_object()) {
      Fail("", "this is not JSON, an estimate is expected", "give the estimate.json that 'sagitta calibrate' wrote");
    }
    const Json schema = json.value("schema", Json());
    if (schema != "sagitta/estimate/1") {
      Fail("schema", schema.is_null() ? "this key is missing: not an estimate" : schema.dump() + " cannot be read here",
           "expected: sagitta/estimate/1, as 'sagitta calibrate' writes it");
    }
    if (json.contains("simulation")) {
      Fail("simulation", "this estimate corrects another simulation's points and predicts none of its own",
           "give the estimate.json of 'sagitta calibrate', or of 'sagitta diagnose' without --simulation=columns");
    }
    return json;
  }

  const Json& Get(const Json& map, const std::string& key) const {
    if (!map.is_object() || !map.contains(key)) Fail(key, "this key is missing");
    return map.at(key);
  }

  double Number(const Json& json, const std::string& key) const {
    if (!json.is_number() || !std::isfinite(json.get<double>())) Fail(key, "a finite number is expected");
    return json.get<double>();
  }

  // Thousandths (mm, mrad) to SI.
  Vector3<double> Triple(const Json& map, const std::string& key) const {
    const Json& list = Get(map, key);
    if (!list.is_array() || list.size() != 3) Fail(key, "three numbers are expected");
    Vector3<double> triple;
    for (int i = 0; i < 3; ++i) triple[i] = Number(list[i], key) / 1e3;
    return triple;
  }

  void ReadStations(const Json& stations) {
    for (const auto& [name, station] : stations.items()) {
      Pose<double> pose;
      pose.translation = Triple(station, "xyz_mm");
      pose.rotation = RotationFromVector(Triple(station, "rotvec_mrad"));
      known_.base_in_station[name] = pose;
      if (station.contains("instrument_mm")) {
        known_.loading.stations[name].instrument_xyz = Triple(station, "instrument_mm");
      }
    }
  }

  void ReadMarkers(const Json& markers) {
    for (const auto& [name, marker] : markers.items()) {
      const Json& on = Get(marker, "on");
      if (!on.is_string()) Fail("markers." + name + ".on", "a text is expected");
      MarkerSpec spec;
      spec.point = Triple(marker, "xyz_mm");
      if (marker.contains("rotvec_mrad")) spec.rotvec = Triple(marker, "rotvec_mrad");
      spec.on = on.get<std::string>();
      known_.markers[name] = spec;
    }
  }

  std::map<std::string, double> Deviations(const Json& json) const {
    std::map<std::string, double> deviations;  // SI
    for (const Json& row : Get(json, "parameters")) {
      const Json& sigma = Get(row, "sigma");
      if (sigma.is_null()) continue;
      deviations[Get(row, "name").get<std::string>()] =
          Number(sigma, "parameters.sigma") * KnownUnit(Get(row, "unit").get<std::string>());
    }
    return deviations;
  }

  void ReadParameters(const Json& json) {
    for (const Json& row : Get(json, "parameters")) {
      const double unit = KnownUnit(Get(row, "unit").get<std::string>());
      known_.parameters[Get(row, "name").get<std::string>()] = {
          Number(Get(row, "value"), "parameters.value") * unit,
          Number(Get(row, "nominal"), "parameters.nominal") * unit};
    }
  }

  // As many rows as unknowns, and no noise stated: nothing tells how well anything is known.
  static bool HasNoNoise(const Json& json) {
    const Json sigma = json.value("sigma", Json::object());
    if (sigma.value("stated", true) || !sigma.contains("estimated_mm")) return false;
    const Json& estimated = sigma.at("estimated_mm");
    return !estimated.is_number() || !(estimated.get<double>() > 0.0);
  }

  double KnownUnit(const std::string& unit) const {
    const double si = SiPerUnit(unit);
    if (si == 0.0) Fail("parameters.unit", "unit '" + unit + "' is not known");
    return si;
  }

  void ReadCovariance(const Json& json) {
    const std::map<std::string, double> deviations = Deviations(json);
    const Json& correlation = Get(json, "correlation");
    const Json& matrix = Get(correlation, "matrix");
    for (const Json& name : Get(correlation, "names")) known_.uncertainty.estimated.push_back(name.get<std::string>());
    const size_t n = known_.uncertainty.estimated.size();
    if (matrix.size() != n) Fail("correlation.matrix", "as many rows as names are expected");
    known_.uncertainty.covariance.resize(n, n);
    const auto deviation = [&](size_t i) {
      const auto found = deviations.find(known_.uncertainty.estimated[i]);
      return found == deviations.end() ? 0.0 : found->second;
    };
    for (size_t r = 0; r < n; ++r) {
      if (matrix[r].size() != n) Fail("correlation.matrix", "a square matrix is expected");
      for (size_t c = 0; c < n; ++c) {
        known_.uncertainty.covariance(r, c) = Number(matrix[r][c], "correlation.matrix") * deviation(r) * deviation(c);
      }
    }
  }

  std::string path_;
  const std::string& text_;
  KnownRobot known_;
};

template <typename Map>
std::vector<std::string> KeysOf(const Map& map) {
  std::vector<std::string> keys;
  keys.reserve(map.size());
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

InputError::Where WhereOf(const Measurements& data, const Observation& observation, const std::string& key) {
  const MeasurementFile& file = data.files[observation.file];
  return {file.path, file.rows[observation.row].line, key};
}

void CheckRows(const KnownRobot& known, const Measurements& data) {
  for (const Observation& observation : data.observations) {
    const Shot& shot = data.shots[observation.shot];
    const std::string& station = data.stations[shot.station];
    const std::string& marker = data.markers[observation.marker];
    if (known.base_in_station.count(station) == 0) {
      throw InputError(WhereOf(data, observation, "station"), "no pose of station '" + station + "' in " + known.file,
                       SpellingHint(station, KeysOf(known.base_in_station)));
    }
    if (known.markers.count(marker) == 0) {
      throw InputError(WhereOf(data, observation, "marker"), "no point of marker '" + marker + "' in " + known.file,
                       SpellingHint(marker, KeysOf(known.markers)));
    }
    if (!observation.is_point() && !known.markers.at(marker).rotvec) {
      throw InputError(WhereOf(data, observation, "marker"),
                       "the row is a pose, and no rotation of marker '" + marker + "' is in " + known.file,
                       "leave the columns of the rotation out, or calibrate with poses");
    }
  }
}

int FrameOf(const Chain& chain, const std::string& file, const std::string& marker, const std::string& on) {
  if (on == "flange") return chain.FlangeFrame();
  if (on == "base") return chain.BaseFrame();
  if (on == "world") return chain.WorldFrame();
  const int joint = chain.FindJoint(on);
  if (joint < 0) throw InputError({file, 0, "markers." + marker + ".on"}, "'" + on + "' is no place on this robot");
  return chain.FrameAfterJoint(joint);
}

}  // namespace

KnownRobot ReadEstimateText(const std::string& text, const std::string& file_in_messages) {
  try {
    return EstimateReader(file_in_messages, text).Read();
  } catch (const nlohmann::json::exception& error) {
    throw InputError({file_in_messages, 0, ""}, std::string("this estimate cannot be read: ") + error.what());
  }
}

KnownRobot ReadEstimateFile(const std::string& path) { return ReadEstimateText(ReadTextFile(path), path); }

std::string ModelErrorInWords(const KnownRobot& known) {
  if (!(known.model_error > 1.0)) return "";
  return "Parts of the calibration data contradict each other (agreement in " + known.file +
         "): what the model lacks is in no standard deviation; away from the configurations that were calibrated take "
         "those of the parameters times " +
         Significant(known.model_error, 2) + ".";
}

ParameterSet NominalParameters(const KnownRobot& known, const CalibrationProblem& problem) {
  ParameterSet parameters = problem.parameters;
  const auto nominal = [&](const std::string& name, double otherwise) {
    const auto found = known.parameters.find(name);
    return found == known.parameters.end() ? otherwise : found->second.nominal;
  };
  for (int i = 0; i < parameters.num_model_parameters(); ++i) {
    const ModelParameter& parameter = problem.model.parameters()[i];
    const auto found = known.parameters.find(parameter.name);
    if (found == known.parameters.end()) continue;
    // The embedded robot carries geometric errors in its nominal values.
    const bool is_error = parameter.law == ParameterLaw::kGeometry;
    parameters.SetModelValue(i, found->second.nominal - (is_error ? found->second.value : 0.0));
  }
  for (int s = 0; s < parameters.num_stations(); ++s) {
    Pose<double> pose = parameters.BaseInStation(s);
    const std::string base = "base/" + problem.data.stations[s] + "/";
    Vector3<double> turn = RotationVector(Eigen::Quaterniond(pose.rotation));
    for (int axis = 0; axis < 3; ++axis) {
      const std::string letter(1, "xyz"[axis]);
      pose.translation[axis] = nominal(base + letter, pose.translation[axis]);
      turn[axis] = nominal(base + "r" + letter, turn[axis]);
    }
    pose.rotation = RotationFromVector(turn);
    parameters.SetBaseInStation(s, pose);
  }
  for (int m = 0; m < parameters.num_markers(); ++m) {
    Vector3<double> point = parameters.MarkerPoint(m);
    for (int axis = 0; axis < 3; ++axis)
      point[axis] = nominal("marker/" + problem.data.markers[m] + "/" + "xyz"[axis], point[axis]);
    parameters.SetMarkerPoint(m, point);
    if (!parameters.is_oriented(m)) continue;
    Vector3<double> turn = RotationVector(parameters.MarkerRotation(m));
    for (int axis = 0; axis < 3; ++axis)
      turn[axis] = nominal("marker/" + problem.data.markers[m] + "/r" + "xyz"[axis], turn[axis]);
    parameters.SetMarkerRotation(m, RotationFromVector(turn));
  }
  return parameters;
}

void AddKnownRotations(const KnownRobot& known, Measurements* data) {
  const int rows = static_cast<int>(data->observations.size());
  for (int i = 0; i < rows; ++i) {
    const Observation& observation = data->observations[i];
    const auto marker = known.markers.find(data->markers[observation.marker]);
    const bool is_known = marker != known.markers.end() && marker->second.rotvec;
    if (!is_known || !observation.is_point() || observation.partner >= 0) continue;
    data->AddRotation(i).rotation_in_station.setConstant(std::nan(""));
  }
}

CalibrationProblem PredictionProblem(const KnownRobot& known, Measurements data) {
  CheckRows(known, data);
  CalibrationProblem problem(known.robot, std::move(data), known.loading);
  for (size_t s = 0; s < problem.data.stations.size(); ++s) {
    problem.parameters.SetBaseInStation(s, known.base_in_station.at(problem.data.stations[s]));
  }
  for (size_t m = 0; m < problem.data.markers.size(); ++m) {
    const std::string& name = problem.data.markers[m];
    const MarkerSpec& spec = known.markers.at(name);
    problem.parameters.SetMarkerPoint(m, *spec.point);
    if (spec.rotvec) problem.parameters.SetMarkerRotation(m, RotationFromVector(*spec.rotvec));
    problem.marker_frames.push_back(FrameOf(problem.robot.chain, known.file, name, spec.on));
  }
  problem.shot_inputs = MakeShotInputs(problem.model, problem.data, problem.experiment);
  CheckEffectColumns(problem);
  problem.latent = MakeLatentModel(problem.robot.chain, problem.data, problem.experiment);
  std::vector<int> all(problem.data.observations.size());
  std::iota(all.begin(), all.end(), 0);
  const Eigen::Matrix3Xd points = PredictPoints(problem, problem.parameters, all);
  problem.resolved_noise = PredictionRoots(problem, known.noise, points);
  return problem;
}

}  // namespace sagitta
