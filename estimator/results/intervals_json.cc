#include "estimator/results/intervals_json.h"

#include <cmath>
#include <limits>

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

Json PairOf(const Interval& interval, double unit, bool open_low = false, bool open_high = false) {
  Json pair = Json::array({interval.low / unit, interval.high / unit});
  if (open_low) pair[0] = nullptr;
  if (open_high) pair[1] = nullptr;
  return pair;
}

double UnitOf(const Estimate& estimate, int coordinate) {
  return TraitsOf(estimate.parameters.coordinates()[coordinate].quantity).si_per_unit;
}

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();  // null in the file

Eigen::MatrixXd Matrix(const Json& rows, size_t columns) {
  Eigen::MatrixXd matrix(rows.size(), columns);
  for (size_t r = 0; r < rows.size(); ++r) {
    for (size_t c = 0; c < columns; ++c)
      matrix(r, c) = rows.at(r).at(c).is_null() ? kNotKnown : rows[r][c].get<double>();
  }
  return matrix;
}

}  // namespace

Json IntervalsToJson(const IntervalReport& intervals) {
  Json json = {{"method", intervals.method}, {"level", 0.95}};
  if (!intervals.kind.empty()) {
    json["kind"] = intervals.kind;
    json["replicates"] = intervals.replicates;
    json["seed"] = intervals.seed;
  }
  if (intervals.clusters > 0) json["clusters"] = intervals.clusters;
  if (intervals.method == "bootstrap" || intervals.method == "profile") json["failed"] = intervals.failed;
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
  if (has_sigma) (*json)["interval"] = estimate.intervals.method;
  if (has_sigma && std::isfinite(row.dof)) (*json)["dof"] = row.dof;
  if (row.open_low || row.open_high) {
    (*json)["open"] = Json::array();
    if (row.open_low) (*json)["open"].push_back("low");
    if (row.open_high) (*json)["open"].push_back("high");
  }
  if ((has_sigma && row.tied) || (!row.identifiable && row.unconditional_sigma > 0.0)) {
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

void ReadHeld(const Json& json, ParameterUncertainty* uncertainty) {
  std::vector<double> units;
  Eigen::VectorXd sigmas(json.at("names").size());
  for (size_t h = 0; h < json.at("names").size(); ++h) {
    uncertainty->held.push_back(json.at("names").at(h).get<std::string>());
    units.push_back(SiPerUnit(json.at("unit").at(h).get<std::string>()));
    const Json& sigma = json.at("sigma").at(h);
    sigmas[h] = sigma.is_null() ? kNotKnown : sigma.get<double>() * units.back();
  }
  const size_t n = units.size();
  uncertainty->second_moment = sigmas.asDiagonal() * Matrix(json.at("correlation"), n) * sigmas.asDiagonal();
  uncertainty->slopes = n > 0 ? Matrix(json.at("slopes"), n) : Eigen::MatrixXd(uncertainty->estimated.size(), 0);
  for (size_t h = 0; h < n; ++h) uncertainty->slopes.col(h) /= units[h];
  for (int c = 0; n > 0 && c < uncertainty->slopes.rows(); ++c) {
    uncertainty->slopes.row(c) *= SiPerUnit(json.at("estimated_unit").at(c).get<std::string>());
  }
}

}  // namespace sagitta
