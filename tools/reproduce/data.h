// The published tables as shipped, and the simulations that several of them share.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "models/constants.h"
#include "problems/calibration_problem.h"
#include "problems/range.h"
#include "tools/reproduce/table.h"
#include "tools/reproduce/weight_study.h"

namespace sagitta {

// Files below the data folder (problems/published); SI where they are no JSON.
struct PublishedData {
  nlohmann::json tables;       // kr270/published.json
  nlohmann::json kr270_truth;  // kr270/truth.json
  nlohmann::json three_link_truth;
  Robot kr270;  // nominal
  Robot three_link;
  Measurements geometric_rows;  // 18 configurations, no points
  Measurements elastic_rows;    // the 15 published ones
};
// Throws InputError.
PublishedData ReadPublishedData(const std::string& folder);

Vector3<double> VectorFrom(const nlohmann::json& json);
Eigen::Matrix3Xd AsPoints(const Eigen::VectorXd& rows);                      // three rows to a point
std::map<std::string, double> PublishedErrors(const nlohmann::json& truth);  // SI, by error name

// Papers 002, tables I to IV, X and XI: 18 calibration configurations, one joint
// estimate, 5 validation configurations of 3 markers and 4 repeats (60 per axis).
struct GeometricRun {
  std::unique_ptr<CalibrationProblem> problem;
  Estimate estimate;
  std::vector<int> calibration, validation;      // observations
  std::map<std::string, double> random_sigma;    // SI, geometric mean over random sets of 18 configurations
  Eigen::Matrix3Xd residuals, residuals_before;  // m, of all observations, in row order
};

// The loaded KR 270 of papers 000, 002 and 003.
struct ElasticRun {
  std::unique_ptr<ForwardModel> model;  // geometry as published, k1, k2(q2), k3 ... k6
  ElasticScene scene;                   // the 15 configurations, 250 kg at the centroid of the markers
  ElasticScene validation;              // 5 configurations
  std::vector<int> columns;             // k21 ... k25, k3 ... k6
  int joint1 = 0;                       // k1, which the papers' model of this stage lacks
  std::vector<Vector3<double>> sigma;   // of deflections, m, Table 1 of paper 003
  Eigen::VectorXd truth;                // published WLS values, rad/(N m)
  WeightDesign design;
  WeightDesign off_axis;              // load 100 mm below the centroid: k6 is seen
  Eigen::VectorXd joint1_deflection;  // m, per row of the design
  Eigen::VectorXd measured;           // simulated to equilibrium, with noise and joint 1
  Eigen::VectorXd validation_measured;
};

struct ReproduceOptions {
  int trials = 300;
  unsigned long long seed = 1;
  std::function<void(const std::string&)> progress = {};  // within a table
};
// A spread needs two.
inline constexpr Range kReproducedTrials{"a number of trials", 2, limits::kTrials};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const ReproduceOptions& options);

// Owns what tables ask for; each simulation runs once, when first asked.
class Reproduction {
 public:
  Reproduction(PublishedData published, const ReproduceOptions& options)
      : published_(std::move(published)), options_(options) {
    CheckOptions(options_);
  }

  const PublishedData& published() const { return published_; }
  const nlohmann::json& table(const std::string& id) const { return published_.tables.at(id); }
  const ReproduceOptions& options() const { return options_; }
  // Hears how far long work within a table is.
  void Listen(std::function<void(const std::string&)> progress) { options_.progress = std::move(progress); }

  const GeometricRun& geometric();
  const ElasticRun& elastic();
  // KnownWeightMethods on the off-axis design; with joint 1 as what the model lacks, or without.
  const std::vector<MethodStudy>& weights(bool with_joint1);

 private:
  PublishedData published_;
  ReproduceOptions options_;
  std::unique_ptr<GeometricRun> geometric_;
  std::unique_ptr<ElasticRun> elastic_;
  std::vector<MethodStudy> weights_[2];
};

GeometricRun RunGeometric(const PublishedData& published, const ReproduceOptions& options);
ElasticRun RunElastic(const PublishedData& published, const ReproduceOptions& options);

// `count` random joint configurations inside the limits of the robot.
std::vector<Eigen::VectorXd> DrawConfigurations(const Chain& chain, int count, std::mt19937_64* random);
std::vector<Eigen::VectorXd> DrawConfigurations(const Chain& chain, int count, unsigned long long seed);
// Deflections of the markers (loaded - unloaded) at equilibrium, m, 3 rows per shot and marker.
Eigen::VectorXd TrueDeflections(const ForwardModel& model, const ElasticScene& scene);

// Tables IV, VIII and XI of paper 002: before, after, factor.
void AddResiduals(const nlohmann::json& published, const ResidualSize& before, const ResidualSize& after,
                  const std::string& why, ReproducedTable* table);

// The 15 configurations that 000, Table II and 003, Table 2 print alike.
void AddConfigurations(Reproduction* reproduction, ReproducedTable* table);
// Published WLS intervals against eq. (13), which is the Cramer-Rao bound: below it by
// more than 10 % no unbiased estimator comes, whatever the ratio.
void CompareWithBound(const std::string& name, double published_interval, double bound, ReproducedTable* table);

struct ReproducibleTable {
  std::string id;
  ReproducedTable (*make)(Reproduction* reproduction);
};
std::vector<ReproducibleTable> PoseTables();          // 000 I, II, III, IV
std::vector<ReproducibleTable> GeometryTables();      // 002 I-IV, fig 4
std::vector<ReproducibleTable> CompensatorTables();   // 002 V, VII
std::vector<ReproducibleTable> ElastostaticTables();  // 002 VI, VIII, IX, fig 5
std::vector<ReproducibleTable> ValidationTables();    // 002 X-XIII, figs 8-10
std::vector<ReproducibleTable> WeightTables();        // 003 1-4, fig 3

}  // namespace sagitta
