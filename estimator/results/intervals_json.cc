#include "estimator/results/intervals_json.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

double UnitOf(const Estimate& estimate, int coordinate) {
  return TraitsOf(estimate.parameters.coordinates()[coordinate].quantity).si_per_unit;
}

}  // namespace

Json PairOf(const Interval& interval, double unit, bool open_low, bool open_high) {
  Json pair = Json::array({interval.low / unit, interval.high / unit});
  if (open_low) pair[0] = nullptr;
  if (open_high) pair[1] = nullptr;
  return pair;
}

Json IntervalsToJson(const IntervalReport& intervals) {
  Json json = {{"method", WordOf(intervals.method)}, {"level", 0.95}};
  if (intervals.kind) {
    json["kind"] = WordOf(*intervals.kind);
    json["replicates"] = intervals.replicates;
    json["seed"] = intervals.seed;
  }
  if (intervals.clusters > 0) json["clusters"] = intervals.clusters;
  if (intervals.method == CovarianceKind::kBootstrap || intervals.method == CovarianceKind::kProfile)
    json["failed"] = intervals.failed;
  if (!intervals.words.empty()) json["words"] = intervals.words;
  return json;
}

void AddIntervalTo(const ParameterEstimate& row, const Estimate& estimate, Json* json) {
  const double unit = TraitsOf(row.quantity).si_per_unit;
  // No redundancy and no stated noise: nothing says how certain a value is.
  const bool has_sigma = row.free && std::isfinite(row.sigma) && row.sigma > 0.0;
  (*json)["sigma"] = has_sigma ? Json(row.sigma / unit) : Json(nullptr);
  (*json)["ci95"] = has_sigma ? PairOf(row.ci95, unit, row.open_low, row.open_high) : Json(nullptr);
  (*json)["free"] = row.free;
  (*json)["identifiable"] = row.identifiable;
  (*json)["at_bound"] = row.at_bound;
  if (has_sigma) (*json)["interval"] = WordOf(estimate.intervals.method);
  if (has_sigma && std::isfinite(row.dof)) (*json)["dof"] = row.dof;
  if (row.open_low || row.open_high) {
    (*json)["open"] = Json::array();
    if (row.open_low) (*json)["open"].push_back("low");
    if (row.open_high) (*json)["open"].push_back("high");
  }
  if ((has_sigma && row.conditional) || (!row.identifiable && row.unconditional_sigma > 0.0)) {
    (*json)["unconditional"] = {{"sigma", row.unconditional_sigma / unit},
                                {"ci95", PairOf(row.unconditional_ci95, unit)}};
  }
}

Json HeldToJson(const Estimate& estimate) {
  const HeldInfluence& held = estimate.held;
  const auto n = held.coordinates.size();
  Json json = {{"names", Json::array()},       {"sigma", Json::array()},     {"unit", Json::array()},
               {"correlation", Json::array()}, {"estimated", Json::array()}, {"estimated_unit", Json::array()},
               {"slopes", Json::array()}};
  const Eigen::VectorXd sigmas = held.second_moment.diagonal().cwiseSqrt();
  for (size_t h = 0; h < n; ++h) {
    const Coordinate& coordinate = estimate.parameters.coordinates()[held.coordinates[h]];
    json["names"].push_back(coordinate.name);
    json["sigma"].push_back(sigmas[h] / UnitOf(estimate, held.coordinates[h]));
    json["unit"].push_back(TraitsOf(coordinate.quantity).unit);
    Json row = Json::array();
    for (size_t i = 0; i < n; ++i) row.push_back(i == h ? 1.0 : held.second_moment(h, i) / (sigmas[h] * sigmas[i]));
    json["correlation"].push_back(row);
  }
  if (n == 0) return json;
  for (size_t c = 0; c < estimate.estimated.size(); ++c) {
    const double unit = UnitOf(estimate, estimate.estimated[c]);
    const Coordinate& coordinate = estimate.parameters.coordinates()[estimate.estimated[c]];
    json["estimated"].push_back(coordinate.name);
    json["estimated_unit"].push_back(TraitsOf(coordinate.quantity).unit);
    Json row = Json::array();
    for (size_t h = 0; h < n; ++h) row.push_back(held.slopes(c, h) * UnitOf(estimate, held.coordinates[h]) / unit);
    json["slopes"].push_back(row);
  }
  return json;
}

void ReadHeld(const JsonValue& json, ParameterUncertainty* uncertainty) {
  uncertainty->held = json.Get("names").Names();
  const auto n = static_cast<Eigen::Index>(uncertainty->held.size());
  const auto units_of = [](const JsonValue& list, size_t count) {
    Eigen::VectorXd units(count);
    const std::vector<JsonValue> items = list.Items();
    if (items.size() != count) list.Fail("as many as names are expected: " + std::to_string(count));
    for (size_t i = 0; i < count; ++i) {
      units[i] = SiPerUnit(items[i].Text());
      if (units[i] == 0.0) items[i].Fail("this unit is not known");
    }
    return units;
  };
  const Eigen::VectorXd units = units_of(json.Get("unit"), n);
  const std::vector<JsonValue> items = json.Get("sigma").Items();
  if (static_cast<Eigen::Index>(items.size()) != n) json.Get("sigma").Fail("as many as names are expected");
  Eigen::VectorXd sigmas(n);
  for (Eigen::Index h = 0; h < n; ++h) {
    sigmas[h] = items[h].IsNull() ? std::numeric_limits<double>::quiet_NaN() : items[h].NotNegativeNumber() * units[h];
    const std::string& name = uncertainty->held[h];
    if (std::find(uncertainty->estimated.begin(), uncertainty->estimated.end(), name) != uncertainty->estimated.end()) {
      json.Get("names").Fail("'" + name + "' is held and estimated at once");
    }
  }
  uncertainty->second_moment = sigmas.asDiagonal() * json.Get("correlation").Correlation(n, true) * sigmas.asDiagonal();
  uncertainty->slopes.resize(uncertainty->estimated.size(), 0);
  if (n == 0) return;
  if (json.Get("estimated").Names() != uncertainty->estimated) {
    json.Get("estimated").Fail("the names of correlation.names are expected, in their order");
  }
  const auto rows = static_cast<Eigen::Index>(uncertainty->estimated.size());
  const Eigen::VectorXd own_units = units_of(json.Get("estimated_unit"), uncertainty->estimated.size());
  uncertainty->slopes =
      own_units.asDiagonal() * json.Get("slopes").Matrix(rows, n, true) * units.cwiseInverse().asDiagonal();
}

}  // namespace sagitta
