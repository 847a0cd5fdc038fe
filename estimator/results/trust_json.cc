#include "estimator/results/trust_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/report/validation_words.h"
#include "estimator/results/intervals_json.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

Json WorstToJson(const UnseenPoints& unseen) {
  Json worst = Json::array();
  for (const FarPose& pose : unseen.worst)
    worst.push_back({{"config", pose.configuration}, {"distance_mm", 1e3 * pose.distance}});
  return worst;
}

void AddUnseen(const UnseenPoints& unseen, Json* json) {
  (*json)["distance_p50_mm"] = 1e3 * unseen.distance_p50;
  (*json)["distance_p95_mm"] = 1e3 * unseen.distance_p95;
  (*json)["worst"] = WorstToJson(unseen);
  (*json)["prediction_p_value"] = unseen.p_value;
}

Json CrossValidationToJson(const CrossValidation& cross_validation) {
  const UnseenPoints& unseen = cross_validation.unseen;
  Json json = {{"folds", cross_validation.folds},
               {"not_run", cross_validation.not_run ? NothingChecksTheMethod() : ""},
               {"rms_mm", 1e3 * unseen.rms},
               {"distance_rms_mm", 1e3 * unseen.distance_rms},
               {"distance_max_mm", 1e3 * unseen.distance_max},
               {"predicted_rms_mm", 1e3 * unseen.predicted_rms}};
  AddUnseen(unseen, &json);
  if (unseen.points == 0) {  // there are no figures: 0 mm would be a good one
    for (const char* figure : {"rms_mm", "distance_rms_mm", "distance_max_mm", "predicted_rms_mm", "distance_p50_mm",
                               "distance_p95_mm", "prediction_p_value"}) {
      json[figure] = nullptr;
    }
  }
  const UnseenPoints& before = cross_validation.nominal;
  json["before"] = Json::object();
  if (before.points > 0) {
    json["before"] = {{"rms_mm", 1e3 * before.rms},
                      {"distance_rms_mm", 1e3 * before.distance_rms},
                      {"distance_p50_mm", 1e3 * before.distance_p50},
                      {"distance_p95_mm", 1e3 * before.distance_p95},
                      {"distance_max_mm", 1e3 * before.distance_max}};
  }
  const Unpredictable& left_out = cross_validation.unpredictable;
  json["left_out"] = {{"points", left_out.points},
                      {"stations", left_out.stations},
                      {"markers", left_out.markers},
                      {"words", LeftOutInWords(left_out)}};
  return json;
}

// ISO 9283:1998, 7.2.1 and 7.2.2.
Json Iso9283ToJson(const Trust& trust) {
  const PoseAccuracy& accuracy = trust.Quoted().pose_accuracy;
  const PoseRepeatability& repeatability = trust.repeatability;
  Json json = {{"ap_mm", nullptr}, {"rp_mm", nullptr}, {"rp_words", RepeatabilityIsLimited(repeatability)}};
  if (accuracy.poses > 0) {
    json["ap_mm"] = {{"poses", accuracy.poses},
                     {"positions", accuracy.positions},
                     {"mean", 1e3 * accuracy.mean},
                     {"max", 1e3 * accuracy.largest},
                     {"readings_scatter", 1e3 * accuracy.scatter}};
  }
  if (repeatability.poses > 0) {
    json["rp_mm"] = {{"poses", repeatability.poses},
                     {"positions", repeatability.positions},
                     {"mean", 1e3 * repeatability.mean},
                     {"max", 1e3 * repeatability.largest},
                     {"arrivals", Json::array({repeatability.fewest, repeatability.most})}};
  }
  return json;
}

// between_parts: T of each two coordinates over their standard deviations of noise alone, as in `correlation`.
Json ModelErrorToJson(const Estimate& estimate, const Trust& trust) {
  Json json = {{"factor", trust.model_error}, {"words", trust.model_error_words}, {"excess", trust.excess}};
  json["rest_mm"] = 1e3 * trust.noise.beyond_noise;
  const Eigen::MatrixXd& covariance = trust.between.covariance;
  json["between_parts"] = covariance.size() > 0 ? Json::array() : Json(nullptr);
  const Eigen::VectorXd deviations = estimate.covariance.diagonal().cwiseSqrt();
  for (Eigen::Index r = 0; r < covariance.rows(); ++r) {
    Json row = Json::array();
    for (Eigen::Index c = 0; c < covariance.cols(); ++c) {
      const double ratio = covariance(r, c) / (deviations[r] * deviations[c]);
      row.push_back(std::isfinite(ratio) ? ratio : 0.0);
    }
    json["between_parts"].push_back(row);
  }
  return json;
}

}  // namespace

void AddTrustTo(const Estimate& estimate, const Trust& trust, Json* json) {
  (*json)["verdict"] = {
      {"words", trust.verdict.words}, {"trusted", trust.verdict.trusted}, {"reasons", trust.verdict.reasons}};
  (*json)["cross_validation"] = CrossValidationToJson(trust.cross_validation);
  if (trust.holdout.points > 0) AddUnseen(trust.holdout, &(*json)["validation"]);
  if (trust.noise.noise > 0.0) {
    (*json)["verdict"]["noise_share"] = {{"noise_mm", 1e3 * trust.noise.noise},
                                         {"of_residuals", trust.noise.of_residuals},
                                         {"rest_mm", 1e3 * trust.noise.rest},
                                         {"rest_is_bound", trust.noise.rest_is_bound},
                                         {"rms_known_to_percent", 100.0 * trust.noise.rms_known_to}};
  }
  (*json)["iso9283"] = Iso9283ToJson(trust);
  (*json)["suspects"] = Json::array();
  for (const Suspect& suspect : trust.suspects)
    (*json)["suspects"].push_back({{"row", suspect.row}, {"words", suspect.words}});
  AddModelErrorTo(estimate, trust, json);
}

void AddModelErrorTo(const Estimate& estimate, const Trust& trust, Json* json) {
  (*json)["model_error"] = ModelErrorToJson(estimate, trust);
  for (size_t i = 0; i < estimate.table.size() && i < trust.ci95_noise_only.size(); ++i) {
    Json& row = (*json)["parameters"][i];
    const double unit = TraitsOf(estimate.table[i].quantity).si_per_unit;
    const bool known = !row.at("ci95").is_null();
    row["ci95_noise_only"] = known ? PairOf(trust.ci95_noise_only[i], unit) : Json(nullptr);
    if (!known) continue;
    row["sigma_noise_only"] = row.at("sigma");
    row["sigma"] = trust.sigma[i] / unit;
    // Ends that a profile likelihood did not find stay open.
    for (int end = 0; end < 2; ++end) {
      if (row.at("ci95")[end].is_null()) row["ci95_noise_only"][end] = nullptr;
    }
  }
}

}  // namespace sagitta
