#include "estimator/results/estimate_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/noise/rotation_noise.h"
#include "estimator/results/intervals_json.h"
#include "estimator/results/json_numbers.h"
#include "estimator/results/loading_json.h"
#include "estimator/results/measured_conditions.h"
#include "estimator/results/measured_joints.h"
#include "estimator/results/prediction_noise.h"
#include "estimator/results/torques_json.h"
#include "problems/io/robot_file.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

Json SizeToJson(const ResidualSize& size) {
  Json json;
  json["rms_mm"] = Millimetres(size.rms);
  json["max_mm"] = Millimetres(size.max);
  json["rms_axis_mm"] = size.observations > 0 ? Millimetres(size.rms_axis) : Json::array();
  json["distance_rms_mm"] = Millimetres(size.distance_rms);
  json["distance_max_mm"] = Millimetres(size.distance_max);
  if (size.rotations > 0) {
    json["rotation_rms_mrad"] = 1e3 * size.rotation_rms;
    json["rotation_max_mrad"] = 1e3 * size.rotation_max;
  }
  return json;
}

namespace {

Json ComponentToJson(const VarianceComponent& component, bool is_factor) {
  const double unit = is_factor ? 1.0 : 1e6;
  Json json = {{"name", component.name},
               {"unit", is_factor                                            ? "factor"
                        : component.joints.empty() || component.is_prismatic ? "um"
                                                                             : "urad"},
               {"value", unit * component.value},
               {"estimated", component.estimated}};
  json["sigma"] = component.estimated ? Finite(unit * component.sigma) : Json(nullptr);
  json["ci95"] =
      component.estimated ? Json::array({Finite(unit * component.low), Finite(unit * component.high)}) : Json(nullptr);
  return json;
}

Json OutlierToJson(const Measurements& data, const Outlier& outlier) {
  const Observation& row = data.observations[outlier.observation];
  Json json = {{"row", data.SourceOf(row)},
               {"config", data.ConfigurationOf(row).id},
               {"marker", data.markers[row.marker]},
               {"distance_mm", outlier.size > 0.0 ? Json(1e3 * outlier.size) : Json(nullptr)},
               {"whitened", outlier.whitened}};
  if (row.partner >= 0) json["angle_mrad"] = outlier.angle > 0.0 ? Json(1e3 * outlier.angle) : Json(nullptr);
  json["exchanged_with"] =
      outlier.swapped_with < 0 ? Json(nullptr) : Json(data.SourceOf(data.observations[outlier.swapped_with]));
  return json;
}

Json ComponentsToJson(const CalibrationProblem& problem, const NoiseReport& report) {
  Json json = {{"one_per_joint", report.per_joint},
               {"gain_of_one_per_joint", report.gain_per_joint},
               {"has_to_gain", report.penalty},
               {"instrument_rms_mm", 1e3 * report.instrument_rms},
               {"robot_rms_mm", 1e3 * report.robot_rms}};
  json["components"] = Json::array();
  for (const VarianceComponent& component : report.components) {
    json["components"].push_back(
        ComponentToJson(component, component.joints.empty() && !component.of_rotations && report.instrument_is_factor));
    if (component.of_rotations) json["components"].back()["unit"] = "urad";
    if (component.joints.size() < 2) continue;
    Json joints = Json::array();
    for (const int j : component.joints) joints.push_back(problem.robot().chain.joints[j].name);
    json["components"].back()["joints"] = joints;
  }
  return json;
}

// Rotations that were left open have what their residuals scatter by.
Json RepeatsToJson(const RepeatScatter& repeats, const SigmaReport& sigma) {
  const double times = repeats.rotation_is_estimated && sigma.scaled ? sigma.a_posteriori : 1.0;
  const Vector3<double> um = 1e6 * repeats.sigma, urad = 1e6 * times * repeats.rotation_sigma;
  Json json = {{"sigma_um", Json::array({um.x(), um.y(), um.z()})}, {"dof_per_axis", repeats.dof}};
  if (!(urad.minCoeff() > 0.0)) return json;
  json["rotation_sigma_urad"] = Json::array({urad.x(), urad.y(), urad.z()});
  json["rotation_dof"] = repeats.rotation_dof;
  json["rotation_from"] = repeats.rotation_is_estimated ? "residuals" : "repeats";
  return json;
}

// The key `noise`: variance components, spreads, outliers.
Json NoiseToJson(const CalibrationProblem& problem, const Estimate& estimate) {
  const NoiseReport& report = estimate.noise_report;
  Json json = {{"source", report.source},
               {"weights", problem.weight_roots.empty()                             ? "sigma"
                           : problem.experiment().method.weights == Weights::kEqual ? "equal"
                                                                                    : "eq14"},
               {"rounds", report.rounds},
               {"converged", report.converged}};
  if (!report.components.empty()) json["variance"] = ComponentsToJson(problem, report);
  if (problem.repeat_scatter) {
    json["repeats"] = RepeatsToJson(*problem.repeat_scatter, estimate.sigma);
  }
  if (!report.groups.empty()) {
    json["groups"] = Json::array();
    for (const NoiseGroup& group : report.groups) {
      json["groups"].push_back({{"name", group.name}, {"sigma_mm", 1e3 * group.sigma}, {"rows", group.rows}});
    }
  }
  json["loss"] = WordOf(report.loss);
  json["outliers"] = Json::array();
  if (report.loss != LossKind::kNone) {
    json["loss_turns_at"] = report.loss_tuning;
    json["robust_scale"] = report.robust_scale;
    json["variance_inflation"] = report.loss_inflation;
    for (const Outlier& outlier : report.outliers) json["outliers"].push_back(OutlierToJson(problem.data(), outlier));
    json["systematic"] = report.systematic;
    json["shared"] = report.shared;
  }
  json["words"] = report.words;
  return json;
}

Json ComparisonToJson(const PartComparison& comparison) {
  Json json = {{"by", WordOf(comparison.by)}};
  if (!comparison.key.empty()) json["key"] = comparison.key;
  json["differences"] = comparison.compared;
  json["within"] = comparison.inside;
  json["share"] = comparison.share();
  json["inflation"] = comparison.inflation;
  json["p_value"] = comparison.p_value;
  return json;
}

// null where nothing was compared.
Json AgreementToJson(const AgreementReport& report) {
  if (report.words.empty()) return nullptr;
  Json json = {{"covariance", WordOf(report.covariance)}, {"seed", report.seed}, {"level", 0.95}};
  json["inflation"] = report.inflation;
  json["disagrees"] = report.disagrees;
  json["kinds"] = Json::array();
  for (const PartComparison& kind : report.kinds) json["kinds"].push_back(ComparisonToJson(kind));
  json["splits"] = Json::array();
  for (const PartComparison& split : report.splits) json["splits"].push_back(ComparisonToJson(split));
  json["random_halves"] = {{"share_model", report.random_share_model},
                           {"share_sandwich", report.random_share_sandwich}};
  json["sandwich_over_model"] = report.sandwich_ratio;
  json["sandwich_advised"] = report.sandwich_advised;
  json["repeats"] = nullptr;
  if (report.repeats.known) {
    json["repeats"] = {{"f", report.repeats.ratio},
                       {"p_value", report.repeats.p_value},
                       {"dof", {report.repeats.between_dof, report.repeats.within_dof}}};
  }
  json["words"] = report.words;
  return json;
}

Json FitToJson(const Estimate& estimate) {
  Json json = {{"observations", estimate.fit.observations},
               {"configurations", estimate.calibration_configurations},
               {"free_parameters", estimate.estimated.size()}};
  json.update(SizeToJson(estimate.fit));
  json["before"] = SizeToJson(estimate.fit_before);
  json["chi2"] = estimate.chi2;
  json["dof"] = estimate.dof;
  json["reduced_chi2"] = estimate.dof > 0 ? Json(estimate.chi2 / estimate.dof) : Json(nullptr);
  return json;
}

Json ValidationToJson(const Estimate& estimate) {
  Json json = {{"observations", estimate.validation.observations}};
  json.update(SizeToJson(estimate.validation));
  json["before"] = estimate.validation.observations > 0 ? SizeToJson(estimate.validation_before) : Json::object();
  json["predicted_rms_mm"] = Millimetres(estimate.validation_predicted_rms);
  return json;
}

Json DeflectionToJson(const Estimate& estimate) {
  Json json = {{"pairs", estimate.deflection_before.observations}};
  json["before"] = SizeToJson(estimate.deflection_before);
  json["after"] = SizeToJson(estimate.deflection_after);
  return json;
}

Json ParameterToJson(const ParameterEstimate& row, const Estimate& estimate) {
  const QuantityTraits& traits = TraitsOf(row.quantity);
  const auto in_unit = [&](double si) { return si / traits.si_per_unit; };
  Json json = {
      {"name", row.name}, {"value", in_unit(row.value)}, {"unit", traits.unit}, {"nominal", in_unit(row.nominal)}};
  AddIntervalTo(row, estimate, &json);
  for (const int i : row.conditional_on) json["conditional_on"].push_back(estimate.parameters.coordinates()[i].name);
  return json;
}

Json CorrelationToJson(const Estimate& estimate) {
  const Eigen::VectorXd deviations = estimate.covariance.diagonal().cwiseSqrt();
  Json names = Json::array(), matrix = Json::array();
  for (const int i : estimate.estimated) names.push_back(estimate.parameters.coordinates()[i].name);
  for (int r = 0; r < deviations.size(); ++r) {
    Json row = Json::array();
    for (int c = 0; c < deviations.size(); ++c) {
      const double correlation = estimate.covariance(r, c) / (deviations[r] * deviations[c]);
      row.push_back(r == c ? 1.0 : std::isfinite(correlation) ? correlation : 0.0);
    }
    matrix.push_back(row);
  }
  return {{"names", names}, {"matrix", matrix}};
}

Json DirectionsToJson(const std::vector<Direction>& directions) {
  Json json = Json::array();
  for (const Direction& direction : directions) {
    Json components = Json::object();
    for (const auto& [name, value] : direction.components) components[name] = value;
    json.push_back({{"direction", components},
                    {"sigma_over_limit", direction.sigma},
                    {"words", direction.words},
                    {"remedy", direction.remedy}});
  }
  return json;
}

// Where nothing states any noise, points and rotations have one sigma each, estimated: weighed by these as if stated;
// so are all where a diagnosis found it.
Json SigmaToJson(const Estimate& estimate) {
  const SigmaReport& sigma = estimate.sigma;
  const VarianceComponent* rotation =
      HasTwoNoises(estimate.noise_report) ? RotationComponent(estimate.noise_report) : nullptr;
  const bool scaled = sigma.scaled && !estimate.intervals.is_empirical();
  const bool stated = sigma.stated && rotation == nullptr && sigma.origin != NoiseOrigin::kFound;
  Json json = {{"a_posteriori", sigma.a_posteriori}, {"scaled", scaled}, {"stated", stated}};
  const double estimated = rotation == nullptr ? sigma.estimated : estimate.noise_report.components[0].value;
  json["estimated_mm"] = stated ? Json(nullptr) : Json(Millimetres(estimated));
  const double of_rotations = rotation != nullptr ? rotation->value : sigma.rotation;
  if (of_rotations > 0.0) json["estimated_rotation_mrad"] = 1e3 * of_rotations;
  json["p_value"] = sigma.p_value;
  if (sigma.pull.priors > 0) {
    json["priors"] = {{"chi2", stated ? Json(sigma.pull.squares) : Json(nullptr)},
                      {"number", sigma.pull.priors},
                      {"set_aside", sigma.pull.is_set_aside}};
  }
  return json;
}

Json StationsToJson(const CalibrationProblem& problem, const ParameterSet& parameters) {
  Json json = Json::object();
  for (size_t s = 0; s < problem.data().stations.size(); ++s) {
    const Vector3<double> rotation =
        RotationVector(Eigen::Map<const Eigen::Quaterniond>(parameters.station_rotation(s).values.data()));
    Json station = {{"xyz_mm", Millimetres(parameters.BaseInStation(s).translation)},
                    {"rotvec_mrad", Millimetres(rotation)}};  // mrad of rad, as mm of m
    const auto spec = problem.experiment().stations.find(problem.data().stations[s]);
    if (spec != problem.experiment().stations.end()) {
      if (spec->second.instrument_xyz) station["instrument_mm"] = Millimetres(*spec->second.instrument_xyz);
      if (spec->second.levelled) station["levelled"] = *spec->second.levelled;
    }
    json[problem.data().stations[s]] = station;
  }
  return json;
}

Json MarkersToJson(const CalibrationProblem& problem, const ParameterSet& parameters) {
  Json json = Json::object();
  for (size_t m = 0; m < problem.data().markers.size(); ++m) {
    const auto spec = problem.experiment().markers.find(problem.data().markers[m]);
    const MarkerPlace on = spec == problem.experiment().markers.end() ? MarkerPlace() : spec->second.on;
    Json& marker = json[problem.data().markers[m]];
    marker["xyz_mm"] = Millimetres(parameters.MarkerPoint(m));
    if (parameters.is_oriented(static_cast<int>(m))) {  // mrad of rad, as mm of m
      marker["rotvec_mrad"] = Millimetres(RotationVector(parameters.MarkerRotation(static_cast<int>(m))));
    }
    marker["on"] = on.Word();
  }
  return json;
}

Json WarningsOf(const CalibrationProblem& problem, const Estimate& estimate) {
  Json json = problem.data().warnings;
  for (const std::string& warning : estimate.warnings) json.push_back(warning);
  return json;
}

// Names come from files, which may hold bytes that are no UTF-8.
std::string OnOneLine(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

bool IsShort(const Json& json) {
  for (const Json& item : json) {
    if (item.is_object() || (item.is_array() && json.is_array())) return false;
  }
  return OnOneLine(json).size() < 400;
}

void Dump(const Json& json, const std::string& indent, std::string* text) {
  if (!json.is_structured() || json.empty() || IsShort(json) || (json.is_array() && json.front().is_number())) {
    *text += OnOneLine(json);
    return;
  }
  const std::string deeper = indent + " ";
  const bool is_object = json.is_object();
  *text += is_object ? "{" : "[";
  bool first = true;
  for (const auto& [key, value] : json.items()) {
    *text += (first ? "\n" : ",\n") + deeper + (is_object ? OnOneLine(key) + ": " : "");
    Dump(value, deeper, text);
    first = false;
  }
  *text += "\n" + indent + (is_object ? "}" : "]");
}

}  // namespace

Json IdentifiabilityToJson(const CalibrationProblem& problem, const Identifiability& identifiability) {
  Json json = {{"rank", identifiability.rank}, {"condition", identifiability.condition}};
  json["unidentifiable"] = DirectionsToJson(identifiability.unidentifiable);
  json["weak"] = DirectionsToJson(identifiability.weak);
  json["redundant"] = Json::array();
  for (const std::string& error : problem.redundant_errors) json["redundant"].push_back(GeometryName(error));
  return json;
}

Json EstimateToJson(const CalibrationProblem& problem, const Estimate& estimate, const Provenance& provenance) {
  Json json;
  json["schema"] = "sagitta/estimate/1";
  json["version"] = SAGITTA_VERSION;
  json["command"] = provenance.command;
  json["run"] = RunId(provenance);
  json["method"] = provenance.method;
  if (!provenance.simulation.empty()) json["simulation"] = provenance.simulation;
  json["inputs"] = Json::array();
  for (const InputFile& input : provenance.inputs) {
    json["inputs"].push_back({{"file", input.path}, {"sha256", input.sha256}});
  }
  json["status"] = StatusName(estimate.status);
  json["message"] = estimate.message;
  json["iterations"] = estimate.iterations;
  json["seconds"] = estimate.seconds;
  json["cost"] = estimate.cost;
  json["fit"] = FitToJson(estimate);
  json["validation"] = ValidationToJson(estimate);
  json["deflection"] = DeflectionToJson(estimate);
  json["parameters"] = Json::array();
  for (const ParameterEstimate& row : estimate.table) json["parameters"].push_back(ParameterToJson(row, estimate));
  json["correlation"] = CorrelationToJson(estimate);
  json["intervals"] = IntervalsToJson(estimate.intervals);
  json["agreement"] = AgreementToJson(estimate.agreement);
  json["held"] = HeldToJson(estimate);
  json["identifiability"] = IdentifiabilityToJson(problem, estimate.identifiability);
  json["sigma"] = SigmaToJson(estimate);
  json["noise"] = NoiseToJson(problem, estimate);
  json["prediction_noise"] = PredictionNoiseToJson(problem, estimate);
  const Json torques = TorquesToJson(problem, CompareTorques(problem, estimate.parameters));
  if (!torques.empty()) json["torques"] = torques;
  json["warnings"] = WarningsOf(problem, estimate);
  json["robot"] = RobotToJson(problem.RobotWith(estimate.parameters));
  json["stations"] = StationsToJson(problem, estimate.parameters);
  json["markers"] = MarkersToJson(problem, estimate.parameters);
  json["measured_joints"] = MeasuredJointsToJson(problem);
  json["measured_conditions"] = MeasuredConditionsToJson(problem);
  json["loading"] = LoadingToJson(problem.experiment(), problem.data());
  return json;
}

std::string DumpJson(const Json& json) {
  std::string text;
  Dump(json, "", &text);
  return text + "\n";
}

}  // namespace sagitta
