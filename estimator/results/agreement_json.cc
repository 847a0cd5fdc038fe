#include "estimator/results/agreement_json.h"

#include <nlohmann/json.hpp>

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

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

}  // namespace

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

}  // namespace sagitta
