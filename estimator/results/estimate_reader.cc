// The half of estimate_json.h that reads.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "estimator/estimate/agreement_report.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/noise/repeat_spread.h"
#include "estimator/report/inspection_known_words.h"
#include "estimator/results/estimate_json.h"
#include "estimator/results/intervals_json.h"
#include "estimator/results/known_loads.h"
#include "estimator/results/loading_json.h"
#include "estimator/results/measured_conditions.h"
#include "estimator/results/measured_joints.h"
#include "estimator/statistics/distributions.h"
#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/json_reader.h"
#include "problems/io/robot_file.h"
#include "problems/problem_checks.h"
#include "problems/structure_checks.h"

namespace sagitta {

KnownRobot::KnownRobot() = default;
KnownRobot::KnownRobot(const KnownRobot&) = default;
KnownRobot::KnownRobot(KnownRobot&&) noexcept = default;
KnownRobot& KnownRobot::operator=(const KnownRobot&) = default;
KnownRobot& KnownRobot::operator=(KnownRobot&&) noexcept = default;
KnownRobot::~KnownRobot() = default;

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kWritten = "give the estimate.json that 'sagitta calibrate' wrote";

// Checks every shape and number before it is used; `root` outlives it.
class EstimateReader {
 public:
  explicit EstimateReader(const JsonValue& root, const std::string& file) : root_(root) { known_.file = file; }

  KnownRobot Read(const std::vector<const EffectDefinition*>& own_effects) {
    CheckKind();
    known_.robot = ReadRobotText(root_.Get("robot").json().dump(), known_.file, own_effects);
    ReadStations(root_.Get("stations"));
    ReadMarkers(root_.Get("markers"));
    if (const auto joints = root_.Find("measured_joints")) {
      known_.measured_joints = MeasuredJointsFrom(*joints, known_.robot.chain);
    }
    if (const auto conditions = root_.Find("measured_conditions")) {
      known_.measured_conditions = MeasuredConditionsFrom(*conditions);
    }
    if (const auto loading = root_.Find("loading")) ReadLoading(*loading, &known_.loading);
    ReadParameters();
    for (const JsonValue& input : root_.Get("inputs").Items()) {
      known_.input_hashes.push_back(input.Get("sha256").Text());
    }
    if (const auto fit = root_.Find("fit")) {
      if (const auto dof = fit->Find("dof")) known_.dof = dof->NotNegativeNumber();
    }
    ReadCovariance();
    known_.uncertainty.slopes.resize(known_.uncertainty.estimated.size(), 0);
    if (const auto held = root_.Find("held")) ReadHeld(*held, &known_.uncertainty);
    for (const std::string& name : known_.uncertainty.held) CheckIsParameter(name, "held.names");
    if (const auto noise = root_.Find("prediction_noise")) {
      known_.noise = ReadPredictionNoise(*noise, &known_.loading);
      known_.noise.freedom = NoiseFreedom();
    }
    const auto intervals = root_.Find("intervals"), clusters = intervals ? intervals->Find("clusters") : std::nullopt;
    if (clusters) known_.clusters = clusters->NotNegativeNumber();
    return known_;
  }

 private:
  // Where the residuals gave the noise, scaled it or added to it; files of other programs may lack what says so.
  double NoiseFreedom() const {
    const auto sigma = root_.Find("sigma");
    if (!sigma) return 0.0;
    const auto stated = sigma->Find("stated");
    const bool is_stated = !stated || stated->json() == true;
    const bool is_changed = known_.noise.scale != 1.0 || known_.noise.scatter > 0.0;
    return is_changed || !is_stated ? known_.dof : FreedomOfRepeats();
  }

  // Of the squared lengths of points; 0: no repeats say how these scatter.
  double FreedomOfRepeats() const {
    const auto noise = root_.Find("noise"), repeats = noise ? noise->Find("repeats") : std::nullopt;
    if (!repeats) return 0.0;
    const Vector3<double> sigma = repeats->Get("sigma_um").Triple();
    return sigma.minCoeff() > 0.0 ? DofOfSizes(sigma, repeats->Get("dof_per_axis").PositiveNumber()) : 0.0;
  }

  // What it is, and that it is a result and not the record of a failure.
  void CheckKind() const {
    if (!root_.IsMap()) root_.Fail("an estimate is expected", kWritten);
    const auto schema = root_.Find("schema");
    if (!schema || schema->json() != "sagitta/estimate/1") {
      root_.Get("schema").Fail(schema->json().dump().substr(0, 60) + " cannot be read here",
                               "expected: sagitta/estimate/1, as 'sagitta calibrate' writes it");
    }
    if (const auto simulation = root_.Find("simulation")) {
      simulation->Fail("this estimate corrects another simulation's points and predicts none of its own",
                       "give the estimate.json of 'sagitta calibrate', or of 'sagitta diagnose' without "
                       "--simulation=columns");
    }
    const JsonValue status = root_.Get("status");
    const std::string name = status.Text();
    for (const Status usable : {Status::kConverged, Status::kConvergedWithHeldParameters}) {
      if (name == StatusName(usable)) return;
    }
    status.Fail("'" + name + "' is no status of a usable estimate: its values are where a failed solve stopped",
                "calibrate again and mind what it says; " + std::string(kWritten));
  }

  // Thousandths (mm, mrad) to SI.
  static Vector3<double> Thousandths(const JsonValue& map, const std::string& key) {
    return map.Get(key).Triple() / 1e3;
  }

  void ReadStations(const JsonValue& stations) {
    for (const auto& [name, station] : stations.Entries()) {
      Pose<double> pose;
      pose.translation = Thousandths(station, "xyz_mm");
      pose.rotation = RotationFromVector(Thousandths(station, "rotvec_mrad"));
      known_.base_in_station[name] = pose;
      if (station.Find("instrument_mm")) {
        known_.loading.stations[name].instrument_xyz = Thousandths(station, "instrument_mm");
      }
    }
  }

  void ReadMarkers(const JsonValue& markers) {
    for (const auto& [name, marker] : markers.Entries()) {
      MarkerSpec spec;
      spec.point = Thousandths(marker, "xyz_mm");
      if (marker.Find("rotvec_mrad")) spec.rotvec = Thousandths(marker, "rotvec_mrad");
      spec.on = MarkerPlace::Named(marker.Get("on").Text());
      known_.markers[name] = spec;
    }
  }

  void ReadParameters() {
    const JsonValue parameters = root_.Get("parameters");
    for (const JsonValue& row : parameters.Items()) {
      const JsonValue name = row.Get("name");
      const JsonValue unit_name = row.Get("unit");
      const double unit = SiPerUnit(unit_name.Text());
      if (unit == 0.0) unit_name.Fail("this unit is not known");
      const KnownRobot::Parameter parameter{row.Get("value").Number() * unit, row.Get("nominal").Number() * unit};
      if (!known_.parameters.emplace(name.Text(), parameter).second) {
        name.Fail("the parameter '" + name.Text() + "' stands twice");
      }
      const JsonValue sigma = row.Get("sigma");
      deviations_[name.Text()] = sigma.IsNull() ? std::nan("") : sigma.NotNegativeNumber() * unit;
      const auto noise_only = row.Find("sigma_noise_only");
      if (noise_only && !sigma.IsNull()) deviations_[name.Text()] = noise_only->NotNegativeNumber() * unit;
      const auto free = row.Find("free");
      if (free && free->Flag() && !sigma.IsNull()) free_.push_back(name.Text());
    }
    if (known_.parameters.empty()) parameters.Fail("there are no parameters: nothing was estimated", kWritten);
  }

  void CheckIsParameter(const std::string& name, const std::string& key) const {
    if (known_.parameters.count(name) > 0) return;
    throw InputError({known_.file, 0, key}, "'" + name + "' is none of the parameters");
  }

  // As many rows as unknowns, and no noise stated: nothing shows how well anything is known.
  bool HasNoNoise() const {
    const auto sigma = root_.Find("sigma");
    if (!sigma) return false;
    const auto stated = sigma->Find("stated");
    const auto estimated = sigma->Find("estimated_mm");
    if (!stated || stated->Flag() || !estimated) return false;
    return !(estimated->NumberOrNull().value_or(0.0) > 0.0);
  }

  void ReadCovariance() {
    const JsonValue correlation = root_.Get("correlation");
    std::vector<std::string>& names = known_.uncertainty.estimated;
    names = correlation.Get("names").Names();
    const auto n = static_cast<Eigen::Index>(names.size());
    Eigen::VectorXd deviations(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      CheckIsParameter(names[i], "correlation.names");
      deviations[i] = deviations_.at(names[i]);  // NaN: not known
    }
    for (const std::string& name : free_) {
      if (std::find(names.begin(), names.end(), name) != names.end()) continue;
      correlation.Get("names").Fail("the free parameter '" + name + "' is missing");
    }
    const Eigen::MatrixXd noise = correlation.Get("matrix").Correlation(n, false);
    const auto in_units = [&](double least) -> Eigen::MatrixXd {
      return deviations.asDiagonal() * WithModelError(noise, least) * deviations.asDiagonal();
    };
    known_.uncertainty.covariance = in_units(1.0);
    known_.noise_covariance = deviations.asDiagonal() * noise * deviations.asDiagonal();
    known_.halves = HowConfigurationsErr();
    const bool is_wider = known_.halves > 1.0 && std::isfinite(known_.halves);
    known_.campaign_covariance = is_wider ? in_units(known_.halves) : known_.uncertainty.covariance;
    if (!HasNoNoise()) return;
    known_.uncertainty.covariance.setConstant(std::nan(""));
    known_.campaign_covariance.setConstant(std::nan(""));
  }

  // Whole configurations err by more than noise, as where joints scatter: random halves differ by it, or points of one
  // shot err alike. Few configurations do not show it by halves, whose fits follow it; the sandwich does.
  double HowConfigurationsErr() const {
    const auto agreement = root_.Find("agreement");
    if (!agreement || agreement->IsNull()) return 1.0;
    const double chance = 1.0 - agreement->Get("level").PositiveNumber();
    const auto advised = agreement->Find("sandwich_advised"), ratio = agreement->Find("sandwich_over_model");
    bool err = advised && advised->Flag();
    double halves = 1.0;
    for (const JsonValue& kind : agreement->Get("kinds").Items()) {
      if (kind.Get("by").Text() != WordOf(SplitBy::kRandom) || kind.Get("p_value").NotNegativeNumber() >= chance)
        continue;
      err = true;
      halves = std::max(halves, kind.Get("inflation").Number());
    }
    const bool is_by_model = agreement->Get("covariance").Text() == WordOf(CovarianceKind::kModel);
    if (!err || !ratio || ratio->IsNull() || !is_by_model) return halves;
    return std::max(halves, ratio->NotNegativeNumber() * WhatFitsHide());
  }

  // A configuration errs by at most as many numbers as it has joints, r, and as were read there. p parameters follow p
  // of the n r numbers of n configurations; of the rest, and so of the sandwich, the squares are with 95 % no less than
  // the quantile of chi-square:
  //   sqrt(n r / chi^2_0.05(n r - p)); infinite where there is no rest. 1: the file does not state how many there are.
  double WhatFitsHide() const {
    const auto fit = root_.Find("fit");
    const auto observations = fit ? fit->Find("observations") : std::nullopt;
    const auto configurations = fit ? fit->Find("configurations") : std::nullopt;
    if (!observations || !configurations) return 1.0;
    const double all = std::min(3.0 * observations->NotNegativeNumber(),
                                configurations->NotNegativeNumber() * known_.robot.chain.num_joints());
    const double shown = all - static_cast<double>(known_.uncertainty.estimated.size());
    return shown > 0.0 ? std::max(1.0, std::sqrt(all / ChiSquareQuantile(0.05, shown))) : kInfinity;
  }

  static double FactorOf(const JsonValue& json) {
    const double factor = json.PositiveNumber();
    if (factor < 1.0) json.Fail("model error makes nothing more certain: a factor of at least 1 is expected");
    return factor;
  }

  // The covariance of noise alone, in units of its deviations, and model error (between_parts.h): with R = L L' and
  // L^-1 T L'^-1 = U diag(t) U', t as far as it is above 0 and the excess of points that were not fitted:
  //   L U diag(max(excess^2, least^2, 1 + t)) U' L'
  Eigen::MatrixXd WithModelError(const Eigen::MatrixXd& correlation, double least) {
    const auto json = root_.Find("model_error");
    if (!json || correlation.size() == 0) return least * least * correlation;
    known_.model_error = FactorOf(json->Get("factor"));
    if (const auto rest = json->Find("rest_mm")) known_.rest = 1e-3 * rest->NotNegativeNumber();
    const auto excess = json->Find("excess");
    const double square = std::pow(std::max(least, excess ? FactorOf(*excess) : known_.model_error), 2);
    const auto between = json->Find("between_parts");
    if (!between || between->IsNull()) return square * correlation;
    const Eigen::MatrixXd ratios = between->Matrix(correlation.rows(), correlation.cols(), false);
    if ((ratios - ratios.transpose()).cwiseAbs().maxCoeff() > 1e-6 * ratios.cwiseAbs().maxCoeff())
      between->Fail("a symmetric matrix is expected");
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(correlation);
    const Eigen::VectorXd sizes = own.eigenvalues().cwiseMax(1e-12 * own.eigenvalues().maxCoeff()).cwiseSqrt();
    const Eigen::MatrixXd root = own.eigenvectors() * sizes.asDiagonal();
    const Eigen::MatrixXd inverse = sizes.cwiseInverse().asDiagonal() * own.eigenvectors().transpose();
    const Eigen::MatrixXd half = inverse * ratios, whitened = half * inverse.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> beyond(whitened);
    const Eigen::VectorXd sizes_beyond = (1.0 + beyond.eigenvalues().array()).max(square).sqrt();
    Eigen::MatrixXd spread = root * beyond.eigenvectors();
    spread *= sizes_beyond.asDiagonal();
    return spread * spread.transpose();
  }

  const JsonValue& root_;
  KnownRobot known_;
  std::map<std::string, double> deviations_;  // SI, of every parameter
  std::vector<std::string> free_;             // those with a standard deviation
};

template <typename Map>
std::vector<std::string> KeysOf(const Map& map) {
  std::vector<std::string> keys;
  keys.reserve(map.size());
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

void CheckRows(const KnownRobot& known, const Measurements& data) {
  for (const Observation& observation : data.observations) {
    const Shot& shot = data.shots[observation.shot];
    const std::string& station = data.stations[shot.station];
    const std::string& marker = data.markers[observation.marker];
    if (known.base_in_station.count(station) == 0) {
      throw InputError(data.WhereOf(observation, "station"), "no pose of station '" + station + "' in " + known.file,
                       StationIsNew(SpellingHint(station, KeysOf(known.base_in_station))));
    }
    const auto found = known.markers.find(marker);
    if (found == known.markers.end() || !found->second.point) {
      throw InputError(data.WhereOf(observation, "marker"), "no point of marker '" + marker + "' in " + known.file,
                       SpellingHint(marker, KeysOf(known.markers)));
    }
    if (!observation.is_point() && !found->second.rotvec) {
      throw InputError(data.WhereOf(observation, "marker"),
                       "the row is a pose, and no rotation of marker '" + marker + "' is in " + known.file,
                       "leave the columns of the rotation out, or calibrate with poses");
    }
  }
}

}  // namespace

KnownRobot ReadEstimateText(const std::string& text, const std::string& file_in_messages,
                            const std::vector<const EffectDefinition*>& own_effects) {
  const Json json = ParseJson(text, file_in_messages);
  const JsonValue root(json, file_in_messages);
  return EstimateReader(root, file_in_messages).Read(own_effects);
}

KnownRobot ReadEstimateFile(const std::string& path, const std::vector<const EffectDefinition*>& own_effects) {
  return ReadEstimateText(ReadTextFile(path), path, own_effects);
}

ParameterSet NominalParameters(const KnownRobot& known, const CalibrationProblem& problem) {
  ParameterSet parameters = problem.parameters;
  const auto nominal = [&](const std::string& name, double otherwise) {
    const auto found = known.parameters.find(name);
    return found == known.parameters.end() ? otherwise : found->second.nominal;
  };
  for (int i = 0; i < parameters.num_model_parameters(); ++i) {
    const ModelParameter& parameter = problem.model().parameters()[i];
    const auto found = known.parameters.find(parameter.name);
    if (found == known.parameters.end()) continue;
    // The embedded robot carries geometric errors in its nominal values.
    const bool is_error = parameter.law == ParameterLaw::kGeometry;
    parameters.SetModelValue(i, found->second.nominal - (is_error ? found->second.value : 0.0));
  }
  for (int s = 0; s < parameters.num_stations(); ++s) {
    Pose<double> pose = parameters.BaseInStation(s);
    const std::array<std::string, 6> names = BaseNames(problem.data().stations[s]);
    Vector3<double> turn = RotationVector(Eigen::Quaterniond(pose.rotation));
    for (int axis = 0; axis < 3; ++axis) {
      pose.translation[axis] = nominal(names[axis], pose.translation[axis]);
      turn[axis] = nominal(names[3 + axis], turn[axis]);
    }
    pose.rotation = RotationFromVector(turn);
    parameters.SetBaseInStation(s, pose);
  }
  for (int m = 0; m < parameters.num_markers(); ++m) {
    const std::array<std::string, 6> names = MarkerNames(problem.data().markers[m]);
    Vector3<double> point = parameters.MarkerPoint(m);
    for (int axis = 0; axis < 3; ++axis) point[axis] = nominal(names[axis], point[axis]);
    parameters.SetMarkerPoint(m, point);
    if (!parameters.is_oriented(m)) continue;
    Vector3<double> turn = RotationVector(parameters.MarkerRotation(m));
    for (int axis = 0; axis < 3; ++axis) turn[axis] = nominal(names[3 + axis], turn[axis]);
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
    data->AddRotation(i).mutable_rotation()->in_station.setConstant(std::nan(""));
  }
}

CalibrationProblem PredictionProblem(const KnownRobot& known, Measurements data) {
  CheckStructure(known.robot, data);
  CheckRows(known, data);
  CheckLoadsAreKnown(known, data);
  Experiment loading = known.loading;
  loading.file = known.file;
  CalibrationProblem problem =
      MakeKnownProblem(known.robot, std::move(data), std::move(loading), {known.base_in_station, known.markers});
  CheckEffectColumns(problem, "calibrate without the effect");
  std::vector<int> all(problem.data().observations.size());
  std::iota(all.begin(), all.end(), 0);
  const Eigen::Matrix3Xd points = PredictPoints(problem, problem.parameters, all);
  problem.resolved_noise = PredictionRoots(problem, known.noise, points);
  return problem;
}

}  // namespace sagitta
