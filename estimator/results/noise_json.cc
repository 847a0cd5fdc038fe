#include "estimator/results/noise_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/noise/rotation_noise.h"
#include "estimator/results/json_numbers.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

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
               {"distance_mm", 1e3 * outlier.size},
               {"whitened", outlier.whitened}};
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
    json["components"].push_back(ComponentToJson(component, component.joints.empty() && report.instrument_is_factor));
    if (&component == RotationComponent(report)) json["components"].back()["unit"] = "urad";
    if (component.joints.size() < 2) continue;
    Json joints = Json::array();
    for (const int j : component.joints) joints.push_back(problem.robot().chain.joints[j].name);
    json["components"].back()["joints"] = joints;
  }
  return json;
}

}  // namespace

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
    const Vector3<double> um = 1e6 * problem.repeat_scatter->sigma;
    json["repeats"] = {{"sigma_um", Json::array({um.x(), um.y(), um.z()})},
                       {"dof_per_axis", problem.repeat_scatter->dof}};
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

}  // namespace sagitta
