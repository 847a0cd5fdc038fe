#include "estimator/results/plan_json.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "estimator/results/json_numbers.h"
#include "estimator/statistics/distributions.h"
#include "problems/io/json_reader.h"
#include "problems/io/text_checks.h"
#include "problems/io/units.h"
#include "problems/loads.h"
#include "problems/significance.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

Json CertificateToJson(const Plan& plan) {
  Json json = {{"words", CertificateInWords(plan)}};
  if (!plan.criterion.HasCertificate()) return json;
  json["cost"] = Finite(plan.cost);
  json["bound"] = Finite(plan.bound);
  json["efficiency"] = Finite(plan.efficiency);
  return json;
}

bool AnyShot(const Measurements& data, bool (*is_so)(const Shot&)) {
  return std::any_of(data.shots.begin(), data.shots.end(), is_so);
}

// Of each shot; those of a configuration that no name distinguishes are numbered.
std::vector<std::string> RepeatsOf(const Measurements& data) {
  std::map<std::tuple<int, int, std::string, std::string, std::string>, int> alike;
  std::vector<std::string> repeats;
  for (const Shot& shot : data.shots) {
    const int number = ++alike[{shot.configuration, shot.station, shot.load, shot.visit, shot.repeat}];
    repeats.push_back(number == 1 ? shot.repeat
                                  : shot.repeat + (shot.repeat.empty() ? "" : "-") + std::to_string(number));
  }
  return repeats;
}

// m: the noise that the former estimate found from its residuals, which have its model error in them; 0: it was stated,
// or measured by repeats.
double NoiseFromResiduals(const JsonValue& estimate) {
  if (const auto sigma = estimate.Find("sigma")) {
    const auto stated = sigma->Find("stated");
    const auto found = sigma->Find("estimated_mm");
    if (stated && !stated->Flag() && found) return found->NumberOrNull().value_or(0.0) / 1e3;
  }
  const auto noise = estimate.Find("noise");
  const auto groups = noise ? noise->Find("groups") : std::nullopt;
  if (!groups) return 0.0;
  double squares = 0.0, rows = 0.0;
  for (const JsonValue& group : groups->Items()) {
    const double of_group = group.Get("rows").PositiveNumber();
    squares += of_group * std::pow(group.Get("sigma_mm").NotNegativeNumber() / 1e3, 2);
    rows += of_group;
  }
  return rows > 0.0 ? std::sqrt(squares / rows) : 0.0;
}

// The joints scatter by what the residuals made of it.
bool FoundRepeatability(const JsonValue& estimate) {
  const auto noise = estimate.Find("noise");
  const auto variance = noise ? noise->Find("variance") : std::nullopt;
  const auto components = variance ? variance->Find("components") : std::nullopt;
  if (!components) return false;
  const std::vector<JsonValue> all = components->Items();
  return std::any_of(all.begin(), all.end(), [](const JsonValue& component) {
    return component.Find("joints") && component.Get("estimated").Flag();
  });
}

FormerMisfit FormerMisfitOf(const JsonValue& estimate) {
  FormerMisfit former;
  former.kind = FormerMisfit::Kind::kNotCompared;
  const auto unseen = estimate.Find("cross_validation");
  const auto rms = unseen ? unseen->Find("rms_mm") : std::nullopt;
  const auto predicted = unseen ? unseen->Find("predicted_rms_mm") : std::nullopt;
  former.rms = rms ? rms->NumberOrNull().value_or(0.0) / 1e3 : 0.0;
  former.predicted = predicted ? predicted->NumberOrNull().value_or(0.0) / 1e3 : 0.0;
  if (!(former.rms > 0.0 && former.predicted > 0.0)) return former;
  if (FoundRepeatability(estimate)) {
    former.kind = FormerMisfit::Kind::kInRepeatability;
    return former;
  }
  former.kind = FormerMisfit::Kind::kMeasured;
  const auto p_of_unseen = unseen->Find("prediction_p_value");
  if (p_of_unseen) former.p_value = p_of_unseen->NumberOrNull();
  const auto fit = estimate.Find("fit");
  const auto dof = fit ? fit->Find("dof") : std::nullopt;
  former.dof = dof ? dof->NumberOrNull().value_or(0.0) : 0.0;
  former.found_noise = NoiseFromResiduals(estimate);
  const auto sigma = estimate.Find("sigma");
  if (!sigma || former.found_noise > 0.0) return former;
  // Where the residuals are beyond the stated noise, predictions are scaled to them, or hold what they scatter in
  // addition (sandwich, bootstrap: not said to be scaled). Either way the model error is in what is predicted, and that
  // there is one the residuals' own test says.
  const double times = sigma->Get("a_posteriori").PositiveNumber();
  const auto p_value = sigma->Find("p_value");
  const std::optional<double> p = p_value ? p_value->NumberOrNull() : std::nullopt;
  const bool is_scaled = sigma->Get("scaled").Flag();
  if (is_scaled || (times > 1.0 && p.value_or(1.0) < kDefaultSignificance)) {
    former.predicted /= times;
    former.p_value = p.value_or(0.0);  // scaled: refuted
  }
  return former;
}

}  // namespace

void ReadModelError(const std::string& estimate_json, const std::string& file_in_messages, PlanRequest* request) {
  const Json json = ParseJson(estimate_json, file_in_messages);
  const JsonValue estimate(json, file_in_messages);
  request->model_error = std::max(1.0, estimate.Get("model_error").Get("factor").PositiveNumber());
  request->former = FormerMisfitOf(estimate);
}

double HalfWidth95(const Plan& plan, const PlannedParameter& parameter) {
  return NormalQuantile(kUpperOf95) * plan.model_error * parameter.sigma;
}

Json PlanToJson(const Plan& plan) {
  Json json = {{"schema", "sagitta/plan/1"},
               {"criterion", {{"name", WordOf(plan.criterion.kind)}, {"words", InWords(plan.criterion.kind)}}},
               {"poses", plan.rows.configurations.size()},
               {"measured", plan.measured},
               {"candidates", plan.candidates},
               {"found_given_measured", plan.found_given_measured},
               {"infeasible", plan.infeasible},
               {"infeasible_because", plan.infeasible_because},
               {"checked", plan.checked},
               {"not_checked", plan.not_checked},
               {"test_points", plan.tests},
               {"certificate", CertificateToJson(plan)},
               {"predicted",
                {{"position_rms_mm", Millimetres(plan.position_rms)},
                 {"position_max_mm", Millimetres(plan.position_max)},
                 {"rms_mm", Millimetres(plan.position_rms / std::sqrt(3.0))},
                 {"model_error", plan.model_error},
                 {"position_rms_with_model_error_mm", Millimetres(plan.rms_with_model_error)}}}};
  if (plan.field_amplitude > 0.0) {
    json["predicted"]["model_field"] = {{"rms_mm", Millimetres(plan.field)}, {"urad", 1e6 * plan.field_amplitude}};
  }
  if (plan.criterion.kind == CriterionKind::kDiscriminate) {
    json["separation"] = {{"log_likelihood", 0.5 * plan.apart},
                          {"mutual_information_nat", plan.information},
                          {"decides", plan.decides},
                          {"words", SeparationInWords()}};
  } else {
    for (int i = 0; i < 5; ++i) json["observability"]["O" + std::to_string(i + 1)] = Finite(plan.indices[i]);
  }
  json["parameters"] = Json::array();
  for (const PlannedParameter& parameter : plan.parameters) {
    const QuantityTraits& traits = TraitsOf(parameter.quantity);
    json["parameters"].push_back({{"name", parameter.name},
                                  {"sigma", parameter.sigma / traits.si_per_unit},
                                  {"ci95_half_width", HalfWidth95(plan, parameter) / traits.si_per_unit},
                                  {"unit", traits.unit},
                                  {"identifiable", parameter.identifiable}});
  }
  json["accuracy_over_poses"] = Json::array();
  for (const PosesAndAccuracy& point : plan.curve) {
    json["accuracy_over_poses"].push_back(
        {{"poses", point.poses}, {"position_rms_mm", Millimetres(point.position_rms)}});
  }
  json["knee"] = plan.knee > 0 ? Json(plan.knee) : Json(nullptr);
  json["order"] = {{"words", plan.order}};
  if (plan.travel > 0.0) json["order"]["travel_share"] = plan.travel / std::max(plan.travel_as_found, 1e-300);
  json["words"] = plan.words;
  return json;
}

std::string PlanColumns(const Chain& chain) {
  std::string columns = "config,marker,station";
  for (int j = 0; j < chain.num_joints(); ++j) {
    columns += ",q" + std::to_string(j + 1) + (chain.joints[j].type == JointType::kRevolute ? "_deg" : "_mm");
  }
  return columns;
}

std::string PlanToCsv(const Chain& chain, const Plan& plan) {
  const Measurements& data = plan.rows;
  const bool has_load = AnyShot(data, IsLoaded);
  const bool has_wrench = AnyShot(data, [](const Shot& shot) { return !shot.wrench.IsZero(); });
  const bool has_sigma = std::any_of(data.observations.begin(), data.observations.end(),
                                     [](const Observation& row) { return row.sigma.maxCoeff() > 0.0; });
  const auto turned = [&data](const Observation& row) -> Vector3<double> {
    if (row.partner < 0) return Vector3<double>::Zero();
    return data.observations[row.partner].rotation().sigma;
  };
  const bool has_rotation_sigma =
      std::any_of(data.observations.begin(), data.observations.end(),
                  [&](const Observation& row) { return row.is_point() && !turned(row).isZero(0.0); });
  const bool has_approach = AnyShot(data, [](const Shot& shot) { return !shot.approach.empty(); });
  const bool has_visit = AnyShot(data, [](const Shot& shot) { return !shot.visit.empty(); });
  const std::vector<std::string> repeats = RepeatsOf(data);
  const bool has_repeat =
      std::any_of(repeats.begin(), repeats.end(), [](const std::string& name) { return !name.empty(); });
  std::string csv = PlanColumns(chain);
  if (has_visit) csv += ",visit";
  if (has_repeat) csv += ",repeat";
  for (int j = 0; j < chain.num_joints() && has_approach; ++j) csv += ",approach" + std::to_string(j + 1);
  if (has_load) csv += ",load";
  if (has_wrench) csv += ",fx_N,fy_N,fz_N,mx_Nm,my_Nm,mz_Nm";
  if (has_sigma) csv += ",sigma_x_mm,sigma_y_mm,sigma_z_mm";
  if (has_rotation_sigma) csv += ",sigma_rx_urad,sigma_ry_urad,sigma_rz_urad";
  if (plan.goes_with_time) csv += ",time_s";
  if (plan.goes_with_temperature) csv += ",temperature_degC";
  csv += "\n";
  const auto add = [&csv](double value) { csv += "," + FormatNumber(value); };
  for (const Observation& row : data.observations) {
    if (!row.is_point()) continue;
    const Shot& shot = data.shots[row.shot];
    const Configuration& configuration = data.configurations[shot.configuration];
    csv += CsvCell(configuration.id) + "," + CsvCell(data.markers[row.marker]) + "," +
           CsvCell(data.stations[shot.station]);
    for (int j = 0; j < chain.num_joints(); ++j) {
      add(ToUnit(configuration.q[j], UnitNamed(chain.joints[j].type == JointType::kRevolute ? "deg" : "mm")));
    }
    if (has_visit) csv += "," + CsvCell(shot.visit);
    if (has_repeat) csv += "," + CsvCell(repeats[row.shot]);
    for (int j = 0; j < chain.num_joints() && has_approach; ++j) {
      const bool is_stated = !shot.approach.empty() && shot.approach[j] != kApproachNotStated;
      csv += "," + (is_stated ? std::to_string(shot.approach[j]) : std::string());
    }
    if (has_load) csv += "," + CsvCell(shot.load);
    for (int i = 0; i < 3 && has_wrench; ++i) add(shot.wrench.force[i]);
    for (int i = 0; i < 3 && has_wrench; ++i) add(shot.wrench.moment[i]);
    const auto add_stated = [&](const Vector3<double>& sigma, const char* unit) {  // empty: none is stated
      for (int i = 0; i < 3; ++i) sigma.isZero(0.0) ? void(csv += ",") : add(ToUnit(sigma[i], UnitNamed(unit)));
    };
    if (has_sigma) add_stated(row.sigma, "mm");
    if (has_rotation_sigma) add_stated(turned(row), "urad");
    if (plan.goes_with_time) shot.has_time ? add(shot.time) : void(csv += ",");
    if (plan.goes_with_temperature) shot.has_temperature ? add(shot.temperature) : void(csv += ",");
    csv += "\n";
  }
  return csv;
}

}  // namespace sagitta
