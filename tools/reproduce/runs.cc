// The simulations behind papers 002 and 003.
#include <glog/logging.h>

#include <cmath>
#include <map>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/linearization.h"
#include "problems/failure.h"
#include "problems/simulation.h"
#include "tools/reproduce/data.h"

namespace sagitta {
namespace {

constexpr int kValidationConfigurations = 5;  // 002, section V
constexpr int kRandomSets = 20;
constexpr int kValidationRepeats = 4;  // 60 coordinates per axis, Fig. 9
constexpr double kOffAxis = -0.1;      // m, along z of the flange

// Random configurations behind the published ones, marked as validation.
void AddValidation(const Chain& chain, unsigned long long seed, Measurements* rows, ValidationSpec* split) {
  MeasurementFile& file = rows->files[0];
  split->kind = ValidationSpec::Kind::kColumn;
  split->column = "config";
  int number = 0;
  for (const Eigen::VectorXd& q : DrawConfigurations(chain, kValidationConfigurations, seed)) {
    Configuration configuration{"V" + std::to_string(++number), q, true};
    rows->configurations.push_back(configuration);
    split->values.push_back(configuration.id);
    MeasurementRows::NewRow row{0, std::vector<std::string>(file.header.size())};
    row.cells[file.FindColumn(split->column)] = configuration.id;
    for (int repeat = 0; repeat < kValidationRepeats; ++repeat) {
      Shot shot;
      shot.configuration = static_cast<int>(rows->configurations.size()) - 1;
      shot.station = 0;
      shot.repeat = std::to_string(repeat + 1);
      for (size_t marker = 0; marker < rows->markers.size(); ++marker) {
        Observation observation;
        observation.shot = static_cast<int>(rows->shots.size());
        observation.marker = static_cast<int>(marker);
        observation.file = 0;
        observation.row = static_cast<int>(file.rows.size());
        file.rows.push_back(row);
        shot.observations.push_back(static_cast<int>(rows->observations.size()));
        rows->observations.push_back(observation);
      }
      rows->shots.push_back(shot);
    }
  }
}

SimulationTruth TruthOf(const PublishedData& published, const Measurements& rows) {
  SimulationTruth truth;
  truth.robot = WithGeometricErrors(published.kr270, PublishedErrors(published.kr270_truth));
  for (const std::string& station : rows.stations) {
    const nlohmann::json& pose = published.kr270_truth.at("stations").at(station);
    Pose<double> base_in_station;
    base_in_station.translation = kMillimetre * VectorFrom(pose["xyz_mm"]);
    base_in_station.rotation = RotationFromVector<double>(kDegree * VectorFrom(pose["rotvec_deg"]));
    truth.base_in_station.push_back(base_in_station);
  }
  for (const std::string& marker : rows.markers) {
    const nlohmann::json& point = published.kr270_truth.at("markers").at(marker).at("xyz_mm");
    truth.markers.push_back({truth.robot.chain.FlangeFrame(), kMillimetre * VectorFrom(point)});
  }
  return truth;
}

Eigen::Matrix3Xd ResidualsAt(const CalibrationProblem& problem, const ParameterSet& parameters) {
  std::vector<int> all(problem.data().observations.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  Eigen::Matrix3Xd residuals = -PredictPoints(problem, parameters, all);
  for (size_t i = 0; i < all.size(); ++i) residuals.col(i) += problem.data().observations[i].point_in_station;
  return residuals;
}

// k1, the table k21 ... k25 of joint 2 over q2, k3 ... k6.
void AddCompliances(const nlohmann::json& compliance, Robot* robot) {
  robot->compliances.push_back({0, {{0.0, kMicro * compliance.at("k1").get<double>()}}, false});
  JointCompliance second{1, {}, true};
  for (int i = 4; i >= 0; --i) {  // ascending in q2
    second.nodes.push_back(
        {kDegree * compliance.at("q2_deg").at(i).get<double>(), kMicro * compliance.at("wls").at(i).get<double>()});
  }
  robot->compliances.push_back(second);
  for (int joint = 2; joint < 6; ++joint) {
    robot->compliances.push_back({joint, {{0.0, kMicro * compliance.at("wls").at(joint + 3).get<double>()}}, false});
  }
}

// The load of `mass` at a point of the flange, along -z of the measurement frame.
ElasticScene LoadedScene(const ElasticScene& frame, const std::vector<Eigen::VectorXd>& configurations,
                         const Vector3<double>& point, double weight) {
  ElasticScene scene = frame;
  scene.shots.clear();
  for (const Eigen::VectorXd& q : configurations) {
    ShotInput shot(q);
    AppliedWrench load;
    load.frame = frame.markers.front().frame;
    load.point = point;
    load.force = {0.0, 0.0, -weight};
    shot.wrenches = {load};
    scene.shots.push_back(shot);
  }
  return scene;
}

void FindColumns(ElasticRun* run) {
  std::vector<int> found;
  for (int i = 0; i < run->model->num_parameters(); ++i) {
    if (run->model->parameters()[i].law == ParameterLaw::kCompliance) found.push_back(i);
  }
  CHECK_EQ(found.size(), 10u);
  run->joint1 = found[0];
  run->columns = {found[5], found[4], found[3], found[2], found[1], found[6], found[7], found[8], found[9]};
}

Eigen::VectorXd Repeated(const Eigen::VectorXd& values, int times) { return values.replicate(times, 1); }

// Intervals of other sets of 18 configurations: which set it is matters by a factor.
void AddRandomSets(const PublishedData& published, const ReproduceOptions& options, GeometricRun* run) {
  Experiment experiment;
  experiment.noise = run->problem->experiment().noise;
  std::map<std::string, std::vector<double>> logs;
  for (int set = 0; set < kRandomSets; ++set) {
    Measurements rows = published.geometric_rows;
    const std::vector<Eigen::VectorXd> drawn = DrawConfigurations(
        published.kr270.chain, static_cast<int>(rows.configurations.size()), options.seed + 5000 + set);
    for (size_t c = 0; c < drawn.size(); ++c) rows.configurations[c].q = drawn[c];
    const std::vector<Vector3<double>> sigma(rows.observations.size(),
                                             Vector3<double>::Constant(*experiment.noise.sigma));
    const Measurements data = SimulateMeasurements(rows, TruthOf(published, rows), sigma, options.seed + set);
    const Estimate estimate = EstimateJointly(MakeCalibrationProblem(published.kr270, data, experiment));
    for (const ParameterEstimate& row : estimate.table) {
      if (IsUsable(estimate.status) && row.sigma > 0.0) logs[row.name].push_back(std::log(row.sigma));
    }
  }
  for (const auto& [name, values] : logs) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    run->random_sigma[name] = std::exp(sum / values.size());
  }
}

}  // namespace

GeometricRun RunGeometric(const PublishedData& published, const ReproduceOptions& options) {
  Measurements rows = published.geometric_rows;
  Experiment experiment;
  AddValidation(published.kr270.chain, options.seed + 1000, &rows, &experiment.validation);
  experiment.noise.from = NoiseSpec::From::kSigma;
  experiment.noise.sigma = kMillimetre * published.kr270_truth.at("noise").at("sigma_mm").get<double>();
  const std::vector<Vector3<double>> sigma(rows.observations.size(),
                                           Vector3<double>::Constant(*experiment.noise.sigma));
  const Measurements data = SimulateMeasurements(rows, TruthOf(published, rows), sigma, options.seed);
  GeometricRun run;
  run.problem = std::make_unique<CalibrationProblem>(MakeCalibrationProblem(published.kr270, data, experiment));
  run.estimate = EstimateJointly(*run.problem);
  if (!IsUsable(run.estimate.status)) throw Failure("no geometric estimate: " + run.estimate.message);
  run.calibration = run.problem->CalibrationObservations();
  run.validation = run.problem->ValidationObservations();
  run.residuals = ResidualsAt(*run.problem, run.estimate.parameters);
  run.residuals_before = ResidualsAt(*run.problem, run.estimate.aligned);
  AddRandomSets(published, options, &run);
  return run;
}

Eigen::VectorXd TrueDeflections(const ForwardModel& model, const ElasticScene& scene) {
  const std::vector<double> theta = model.NominalValues();
  const int markers = static_cast<int>(scene.markers.size());
  Eigen::VectorXd deflections(3 * markers * scene.shots.size());
  std::vector<PointPrediction> loaded, unloaded;
  for (size_t s = 0; s < scene.shots.size(); ++s) {
    const bool found = model.Predict(scene.shots[s], theta.data(), {}, scene.base_in_station, scene.markers, &loaded) &&
                       model.Predict(ShotInput(scene.shots[s].conditions.q), theta.data(), {}, scene.base_in_station,
                                     scene.markers, &unloaded);
    if (!found) throw Failure("the published load folds the arm: no equilibrium");
    for (int m = 0; m < markers; ++m) {
      deflections.segment<3>(3 * (markers * s + m)) = loaded[m].point - unloaded[m].point;
    }
  }
  return deflections;
}

ElasticRun RunElastic(const PublishedData& published, const ReproduceOptions& options) {
  ElasticRun run;
  const nlohmann::json& given = published.tables.at("scene");
  const nlohmann::json& compliance = published.tables.at("compliance");
  Robot robot = WithGeometricErrors(published.kr270, PublishedErrors(published.kr270_truth));
  AddCompliances(compliance, &robot);
  run.model = std::make_unique<ForwardModel>(robot);
  FindColumns(&run);
  run.truth.resize(run.columns.size());
  for (int p = 0; p < run.truth.size(); ++p) run.truth[p] = run.model->parameters()[run.columns[p]].nominal;

  ElasticScene frame;
  frame.base_in_station.translation = kMillimetre * VectorFrom(given.at("base_xyz_mm"));
  frame.base_in_station.rotation = RotationFromVector<double>(1e-3 * VectorFrom(given.at("base_rotvec_mrad")));
  Vector3<double> centroid = Vector3<double>::Zero();
  for (const nlohmann::json& point : given.at("markers_mm")) {
    frame.markers.push_back({robot.chain.FlangeFrame(), kMillimetre * VectorFrom(point)});
    centroid += frame.markers.back().point / given.at("markers_mm").size();
  }
  std::vector<Eigen::VectorXd> configurations;
  for (const Configuration& configuration : published.elastic_rows.configurations) {
    configurations.push_back(configuration.q);
  }
  const double weight = given.at("load_kg").get<double>() * given.at("gravity").get<double>();
  run.scene = LoadedScene(frame, configurations, centroid, weight);
  const ElasticScene off_axis =
      LoadedScene(frame, configurations, centroid + Vector3<double>(0.0, 0.0, kOffAxis), weight);
  run.validation = LoadedScene(frame, DrawConfigurations(robot.chain, kValidationConfigurations, options.seed + 2000),
                               centroid, weight);

  for (const nlohmann::json& row : published.tables.at("003-1").at("sigma_um")) {
    run.sigma.push_back(kMicro * VectorFrom(row));
  }
  const int markers = static_cast<int>(frame.markers.size()), repeats = given.at("repeats").get<int>();
  run.design = MakeWeightDesign(ElasticColumns(*run.model, run.scene, run.columns), run.sigma, markers, repeats);
  run.off_axis = MakeWeightDesign(ElasticColumns(*run.model, off_axis, run.columns), run.sigma, markers, repeats);
  run.joint1_deflection = Repeated(ElasticColumns(*run.model, off_axis, {run.joint1}).col(0), repeats) *
                          run.model->parameters()[run.joint1].nominal;

  NormalNumbers normal(options.seed);
  run.measured = Repeated(TrueDeflections(*run.model, run.scene), repeats);
  for (int i = 0; i < run.measured.size(); ++i) run.measured[i] += run.design.sigma[i] * normal();
  const double typical = run.design.sigma.norm() / std::sqrt(static_cast<double>(run.design.sigma.size()));
  run.validation_measured = Repeated(TrueDeflections(*run.model, run.validation), kValidationRepeats);
  for (int i = 0; i < run.validation_measured.size(); ++i) run.validation_measured[i] += typical * normal();
  return run;
}

}  // namespace sagitta
