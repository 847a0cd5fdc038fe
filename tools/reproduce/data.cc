#include "tools/reproduce/data.h"

#include <map>

#include "models/random_bits.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/json_reader.h"
#include "problems/io/measurement_file.h"
#include "problems/io/robot_file.h"

namespace sagitta {
namespace {

nlohmann::json ReadJson(const std::string& path) { return ParseJson(ReadTextFile(path), path); }

}  // namespace

Eigen::Matrix3Xd AsPoints(const Eigen::VectorXd& rows) {
  return Eigen::Map<const Eigen::Matrix3Xd>(rows.data(), 3, rows.size() / 3);
}

PublishedData ReadPublishedData(const std::string& folder) {
  PublishedData data;
  data.tables = ReadJson(folder + "/kr270/published.json");
  if (data.tables.value("schema", "") != "sagitta/published_tables/1") {
    throw InputError({folder + "/kr270/published.json", 0, "schema"}, "not the published tables of this version");
  }
  data.kr270_truth = ReadJson(folder + "/kr270/truth.json");
  data.three_link_truth = ReadJson(folder + "/three_link/truth.json");
  data.kr270 = ReadRobotFile(folder + "/kr270/robot.yaml");
  data.three_link = ReadRobotFile(folder + "/three_link/robot.yaml");
  MeasurementReadOptions commanded;
  commanded.points_required = false;
  data.geometric_rows = ReadMeasurementsFor(data.kr270, {folder + "/kr270/configurations.csv"}, commanded);
  data.elastic_rows = ReadMeasurementsFor(data.kr270, {folder + "/kr270/elastostatic_configurations.csv"}, commanded);
  return data;
}

Vector3<double> VectorFrom(const nlohmann::json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

std::map<std::string, double> PublishedErrors(const nlohmann::json& truth) {
  std::map<std::string, double> errors;
  for (const auto& [name, entry] : truth.at("geometry").items()) {
    errors[name] = entry.contains("value_mm") ? kMillimetre * entry["value_mm"].get<double>()
                                              : kDegree * entry.at("value_deg").get<double>();
  }
  return errors;
}

std::vector<Eigen::VectorXd> DrawConfigurations(const Chain& chain, int count, std::mt19937_64* random) {
  std::vector<Eigen::VectorXd> configurations(count, Eigen::VectorXd(chain.num_joints()));
  for (Eigen::VectorXd& q : configurations) {
    for (int j = 0; j < q.size(); ++j) {
      const double uniform = UnitNumber((*random)());
      const double low = chain.joints[j].min.value_or(-kPi), high = chain.joints[j].max.value_or(kPi);
      q[j] = low + (high - low) * uniform;
    }
  }
  return configurations;
}

std::vector<Eigen::VectorXd> DrawConfigurations(const Chain& chain, int count, unsigned long long seed) {
  std::mt19937_64 random(seed);
  return DrawConfigurations(chain, count, &random);
}

void CheckOptions(const ReproduceOptions& options) {
  CheckIn(kReproducedTrials, options.trials, "ReproduceOptions.trials");
}

const GeometricRun& Reproduction::geometric() {
  if (!geometric_) geometric_ = std::make_unique<GeometricRun>(RunGeometric(published_, options_));
  return *geometric_;
}

const ElasticRun& Reproduction::elastic() {
  if (!elastic_) elastic_ = std::make_unique<ElasticRun>(RunElastic(published_, options_));
  return *elastic_;
}

const std::vector<MethodStudy>& Reproduction::weights(bool with_joint1) {
  std::vector<MethodStudy>& studies = weights_[with_joint1 ? 1 : 0];
  if (!studies.empty()) return studies;
  const ElasticRun& run = elastic();
  WeightStudyOptions study;
  study.trials = options_.trials;
  study.seed = options_.seed;
  study.progress = options_.progress;
  if (with_joint1) study.bias = run.joint1_deflection;
  studies = StudyWeights(run.off_axis, run.truth, KnownWeightMethods(), study);
  return studies;
}

}  // namespace sagitta
