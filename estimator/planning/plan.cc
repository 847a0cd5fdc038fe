#include "estimator/planning/plan.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimator/alignment/starting_values.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/planning/pose_space.h"
#include "problems/excitation.h"
#include "problems/input_error.h"
#include "problems/split.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr int kMostPatterns = 8;       // ways to measure a configuration that are offered for every pose
constexpr int kRandomTests = 100;      // poses; their mean square is known to about a tenth
constexpr double kTolerance = 0.005;   // of the certificate: half a per cent of the cost
constexpr double kSizePerHold = 0.02;  // rivals are compared at a size that moves 0.1 mm or 0.1 mrad (hold limit: 5)

// Measured rows, candidates and tests side by side.
struct Scene {
  Measurements data;
  std::vector<int> candidates, tests, measured;  // configurations
  int infeasible = 0;
  std::vector<std::string> words;
};

bool IsCalibration(const Configuration& configuration) { return !configuration.is_validation; }

void AddDrawn(const Robot& robot, const Measurements& data, const ShotPatterns& patterns, int count, std::uint64_t seed,
              const char* prefix, Measurements* to, std::vector<int>* list) {
  const std::vector<Eigen::VectorXd> poses = PosesInLimits(robot.chain, count, seed);
  for (size_t i = 0; i < poses.size(); ++i) {
    for (const int pattern : patterns.configurations) {
      list->push_back(AppendConfiguration(data, pattern, poses[i], prefix + std::to_string(i + 1), to));
    }
  }
}

void AddListed(const Robot& robot, const Measurements& from, Scene* scene, std::vector<int>* list) {
  const int files = static_cast<int>(scene->data.files.size());
  scene->data.files.insert(scene->data.files.end(), from.files.begin(), from.files.end());
  for (size_t c = 0; c < from.configurations.size(); ++c) {
    if (list == &scene->candidates && !OutsideLimits(robot.chain, from.configurations[c].q).empty()) {
      ++scene->infeasible;
      continue;
    }
    const size_t first = scene->data.observations.size();
    list->push_back(AppendConfiguration(from, static_cast<int>(c), {}, "", &scene->data));
    for (size_t k = first; k < scene->data.observations.size(); ++k) scene->data.observations[k].file += files;
  }
}

Scene MakeScene(const Robot& robot, const Measurements& data, const PlanRequest& request) {
  Scene scene;
  scene.data = data;
  for (size_t c = 0; c < data.configurations.size(); ++c) {
    if (request.augment && IsCalibration(data.configurations[c])) scene.measured.push_back(static_cast<int>(c));
  }
  const ShotPatterns patterns = PatternsOf(data, kMostPatterns);
  if (patterns.left_out > 0) {
    scene.words.push_back("The rows show " + std::to_string(patterns.left_out) +
                          " more ways to measure a pose than the " + std::to_string(kMostPatterns) +
                          " most frequent ones that are offered.");
  }
  if (request.candidates != nullptr) {
    AddListed(robot, *request.candidates, &scene, &scene.candidates);
  } else {
    AddDrawn(robot, data, patterns, request.pool, request.seed, "P", &scene.data, &scene.candidates);
  }
  if (request.tests != nullptr) {
    AddListed(robot, *request.tests, &scene, &scene.tests);
  } else if (request.random_tests) {
    AddDrawn(robot, data, patterns, kRandomTests, request.seed + 1, "T", &scene.data, &scene.tests);
  } else {
    const bool has_validation =
        std::any_of(data.configurations.begin(), data.configurations.end(),
                    [](const Configuration& configuration) { return configuration.is_validation; });
    for (size_t c = 0; c < data.configurations.size(); ++c) {
      if (!has_validation || data.configurations[c].is_validation) scene.tests.push_back(static_cast<int>(c));
    }
  }
  return scene;
}

CalibrationProblem ProblemOf(const Robot& robot, const Scene& scene, const Experiment& experiment,
                             const std::vector<EffectSpec>& rivals) {
  Robot extended = robot;
  for (const EffectSpec& rival : rivals) {
    const bool is_there = std::any_of(robot.effects.begin(), robot.effects.end(),
                                      [&](const EffectSpec& own) { return own.Path() == rival.Path(); });
    if (!is_there) extended.effects.push_back(rival);
  }
  Experiment whole = experiment;
  whole.validation = ValidationSpec();
  whole.validation.kind = ValidationSpec::Kind::kNone;
  CalibrationProblem problem = MakeCalibrationProblem(std::move(extended), scene.data, std::move(whole));
  for (const EffectSpec& rival : rivals) {
    for (const int i : problem.parameters.Match(rival.Path())) problem.parameters.coordinate(i).free = true;
  }
  return problem;
}

// Base and markers: registered to the readings where there are any, else as the experiment states them.
void PlaceScene(const Measurements& data, CalibrationProblem* problem, std::vector<std::string>* words) {
  std::vector<int> read;
  for (size_t k = 0; k < data.observations.size(); ++k) {
    if (data.observations[k].point_in_station.allFinite()) read.push_back(static_cast<int>(k));
  }
  if (!read.empty()) {
    FindStartingValues(*problem, read, {}, &problem->parameters);
    words->push_back("Base and markers are those that fit the readings best with the robot as its file states it.");
    return;
  }
  for (const std::string& marker : problem->data.markers) {
    const auto spec = problem->experiment.markers.find(marker);
    if (spec != problem->experiment.markers.end() && spec->second.point) continue;
    throw InputError({problem->experiment.file, 0, "markers"},
                     "nothing says where marker '" + marker + "' is: no row has a reading",
                     "state markers: {" + marker + ": {xyz_mm: …}} in the experiment file");
  }
  words->push_back("Base, markers and robot are taken as the files state them: no row has a reading.");
}

// Puts the readings that are expected into these configurations; drops those whose load folds the arm.
void ExpectReadings(CalibrationProblem* problem, const std::vector<std::vector<int>>& observations, Scene* scene) {
  std::vector<bool> folds(problem->data.configurations.size(), false);
  for (std::vector<int>* list : {&scene->candidates, &scene->tests}) {
    for (const int c : *list) {
      const Eigen::Matrix3Xd points = PredictPoints(*problem, problem->parameters, observations[c]);
      folds[c] = !points.allFinite();
      for (size_t k = 0; k < observations[c].size() && !folds[c]; ++k) {
        problem->data.observations[observations[c][k]].Read(points.col(k), Vector3<double>::Zero());
      }
    }
    const size_t before = list->size();
    list->erase(std::remove_if(list->begin(), list->end(), [&](int c) { return folds[c]; }), list->end());
    const size_t dropped = before - list->size();
    if (list == &scene->candidates) scene->infeasible += static_cast<int>(dropped);
    if (list == &scene->tests && dropped > 0) {
      throw InputError({problem->experiment.file, 0, "loads"},
                       "at " + std::to_string(dropped) + " test poses the load folds the arm: no equilibrium",
                       "check the load and the compliances, or take these poses out");
    }
  }
}

std::vector<int> Joined(const std::vector<std::vector<int>>& observations, const std::vector<int>& configurations) {
  std::vector<int> all;
  for (const int c : configurations) all.insert(all.end(), observations[c].begin(), observations[c].end());
  return all;
}

NoiseRoots StatedNoise(const CalibrationProblem& problem, const std::vector<int>& observations) {
  const NoiseRoots roots = ObservationNoise(problem, observations, 0.0);
  if (std::all_of(roots.begin(), roots.end(), IsStated)) return roots;
  throw InputError({problem.experiment.file, 0, "noise"}, "a plan weighs readings, and nothing states their noise",
                   "give --sigma_mm, or noise: {sigma_mm: …} in the experiment file");
}

// What the search works on: scaled columns.
struct Numbers {
  std::vector<int> columns;  // coordinates
  Eigen::VectorXd scale;     // SI value of one unit of each column
  CandidateSet set;
  Eigen::MatrixXd known;      // priors, hold limits, measured rows
  Eigen::MatrixXd test_rows;  // m per unit, three per test point
  int equations_known = 0;    // measured rows and priors
};

Numbers MakeNumbers(const CalibrationProblem& problem, const Scene& scene) {
  const std::vector<std::vector<int>> observations = ObservationsByConfiguration(problem.data);
  Numbers numbers;
  numbers.columns = problem.parameters.EstimatedCoordinates();
  const auto linearize = [&](const std::vector<int>& rows, const NoiseRoots& roots, LatentTreatment treatment) {
    return Linearize(problem, problem.parameters, rows, numbers.columns, roots, treatment);
  };
  const std::vector<int> of_candidates = Joined(observations, scene.candidates);
  numbers.set.rows =
      linearize(of_candidates, StatedNoise(problem, of_candidates), LatentTreatment::kMarginalise).jacobian;
  numbers.set.first = {0};
  for (const int c : scene.candidates) {
    numbers.set.first.push_back(numbers.set.first.back() + 3 * static_cast<int>(observations[c].size()));
  }
  const int n = static_cast<int>(numbers.columns.size());
  numbers.scale.resize(n);
  Eigen::VectorXd held(n);  // 1 / hold limit
  for (int i = 0; i < n; ++i) {
    const double limit = problem.parameters.coordinates()[numbers.columns[i]].hold_limit;
    const double norm = numbers.set.rows.col(i).norm() / std::sqrt(static_cast<double>(scene.candidates.size()));
    numbers.scale[i] = norm * limit > 1e-6 ? 1.0 / norm : limit;
    held[i] = numbers.scale[i] / limit;
  }
  numbers.set.rows = numbers.set.rows * numbers.scale.asDiagonal();

  Linearization beside = linearize({}, {}, LatentTreatment::kIgnore);
  const std::vector<int> of_measured = Joined(observations, scene.measured);
  if (!of_measured.empty()) {
    beside = linearize(of_measured, StatedNoise(problem, of_measured), LatentTreatment::kMarginalise);
  }
  AppendPriors(problem.parameters, &beside);
  numbers.equations_known = beside.num_rows();
  const Eigen::MatrixXd rows = beside.jacobian * numbers.scale.asDiagonal();
  numbers.known = Eigen::MatrixXd(held.cwiseAbs2().asDiagonal()) + rows.transpose() * rows;

  const std::vector<int> points = problem.data.PointsAmong(Joined(observations, scene.tests));
  const NoiseRoots metres(points.size(), Matrix3<double>::Identity());
  numbers.test_rows = linearize(points, metres, LatentTreatment::kIgnore).jacobian * numbers.scale.asDiagonal();
  return numbers;
}

Criterion CriterionFor(const CalibrationProblem& problem, const Numbers& numbers, const PlanRequest& request) {
  Criterion criterion;
  criterion.kind = request.discriminate.empty() ? request.criterion : CriterionKind::kDiscriminate;
  criterion.weight = numbers.test_rows.transpose() * numbers.test_rows / (numbers.test_rows.rows() / 3.0);
  std::vector<double> sizes;
  for (size_t i = 0; i < numbers.columns.size(); ++i) {
    const Coordinate& coordinate = problem.parameters.coordinates()[numbers.columns[i]];
    if (criterion.kind != CriterionKind::kDiscriminate) {
      if (problem.parameters.blocks()[coordinate.block].kind == BlockKind::kModelParameter) {
        criterion.interest.push_back(static_cast<int>(i));
      }
      continue;
    }
    for (size_t k = 0; k < request.discriminate.size(); ++k) {
      if (coordinate.name.rfind(request.discriminate[k].Path() + "/", 0) != 0) continue;
      criterion.interest.push_back(static_cast<int>(i));
      criterion.rival_of.push_back(static_cast<int>(k));
      sizes.push_back(kSizePerHold * coordinate.hold_limit / numbers.scale[i]);
    }
  }
  criterion.size = Eigen::Map<Eigen::VectorXd>(sizes.data(), sizes.size());
  if (criterion.interest.empty() && criterion.kind != CriterionKind::kI) {
    throw InputError({problem.experiment.file, 0, "estimate"}, "no parameter of the robot is free",
                     "the criteria D, A, E and O1 to O5 need some; use I");
  }
  return criterion;
}

double PositionRms(const Criterion& criterion, const Eigen::MatrixXd& covariance) {
  return std::sqrt(criterion.weight.cwiseProduct(covariance).sum());
}

// The least number of poses that has as many equations as unknowns.
int LeastPoses(const Numbers& numbers) {
  int most = 1;
  for (int i = 0; i < numbers.set.size(); ++i) most = std::max(most, numbers.set.count(i));
  const int missing = static_cast<int>(numbers.columns.size()) - numbers.equations_known;
  return std::max(1, (missing + most - 1) / most);
}

void CheckEnough(const Numbers& numbers, int poses) {
  const int least = LeastPoses(numbers);
  if (poses >= least) return;
  throw InputError({"", 0, "--poses"},
                   "fewer readings than unknowns: " + std::to_string(poses) + " poses cannot determine " +
                       std::to_string(numbers.columns.size()) + " parameters",
                   "at least " + std::to_string(least) +
                       " poses; or free less (estimate.geometry, --fixed), or give --augment where the rows of the "
                       "experiment are measured already");
}

struct Found {
  int poses = 0;
  ApproximateDesign approximate;
  ExactDesign exact;
};

class Search {
 public:
  Search(const Numbers& numbers, const Criterion& criterion, const PlanRequest& request)
      : numbers_(numbers), criterion_(criterion), request_(request) {
    options_.repeats = request.candidates == nullptr;
    options_.seed = request.seed;
  }

  Found At(int poses, int starts) {
    if (!options_.repeats && poses > numbers_.set.size()) {
      throw InputError({"", 0, "--poses"},
                       std::to_string(poses) + " poses are asked for and there are " +
                           std::to_string(numbers_.set.size()) + " feasible candidates",
                       "ask for fewer, or list more");
    }
    if (request_.progress) request_.progress("best " + std::to_string(poses) + " poses");
    options_.starts = starts;
    Found found;
    found.poses = poses;
    found.approximate = SolveApproximate(numbers_.set, numbers_.known, criterion_, poses, kTolerance);
    found.exact = SolveExact(numbers_.set, numbers_.known, criterion_, poses, found.approximate, options_);
    curve_.push_back({poses, PositionRms(criterion_, found.exact.covariance)});
    return found;
  }

  // The smallest number of poses that reaches the accuracy: doubled until it does, then bisected.
  Found Reaching(double accuracy) {
    const int limit = options_.repeats ? request_.most_poses : std::min(request_.most_poses, numbers_.set.size());
    int low = LeastPoses(numbers_) - 1;
    int high = std::min(low + 1, limit);
    Found best = At(high, 1);
    while (Rms(best) > accuracy) {
      if (high == limit) {
        throw InputError({"", 0, "--accuracy_mm"},
                         "even " + std::to_string(limit) + " poses leave " + Significant(1e3 * Rms(best), 3) +
                             " mm at the test poses",
                         "ask for less accuracy, measure more exactly, or at test poses nearer to the candidates");
      }
      low = high;
      high = std::min(2 * high, limit);
      best = At(high, 1);
    }
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      Found trial = At(middle, 1);
      (Rms(trial) <= accuracy ? high : low) = middle;
      if (high == middle) best = std::move(trial);
    }
    return best;
  }

  double Rms(const Found& found) const { return PositionRms(criterion_, found.exact.covariance); }

  std::vector<PosesAndAccuracy> Curve() const {
    std::vector<PosesAndAccuracy> curve = curve_;
    std::sort(curve.begin(), curve.end(), [](const auto& a, const auto& b) { return a.poses < b.poses; });
    return curve;
  }

 private:
  const Numbers& numbers_;
  const Criterion& criterion_;
  const PlanRequest& request_;
  ExactOptions options_;
  std::vector<PosesAndAccuracy> curve_;
};

void FillParameters(const CalibrationProblem& problem, const Numbers& numbers, const Eigen::MatrixXd& covariance,
                    Plan* plan) {
  for (size_t i = 0; i < numbers.columns.size(); ++i) {
    const Coordinate& coordinate = problem.parameters.coordinates()[numbers.columns[i]];
    const double variance = covariance(i, i) * numbers.scale[i] * numbers.scale[i];
    // The hold limit is among the information: what the data alone would say is 1 / (1/variance - 1/limit^2).
    const double limit = coordinate.hold_limit * coordinate.hold_limit;
    plan->parameters.push_back({coordinate.name, coordinate.quantity, std::sqrt(variance), variance < 0.5 * limit});
  }
}

void FillRows(const Measurements& data, const Scene& scene, const std::vector<int>& picks, bool keep_ids, Plan* plan) {
  plan->rows.files = data.files;
  plan->rows.stations = data.stations;
  plan->rows.markers = data.markers;
  int number = 0;
  for (const int pick : picks) {
    const int c = scene.candidates[pick];
    const Configuration& configuration = data.configurations[c];
    const std::string id = keep_ids ? configuration.id : "plan" + std::to_string(++number);
    AppendConfiguration(data, c, configuration.q, id, &plan->rows);
  }
}

void FillWords(const PlanRequest& request, const Plan& plan, std::vector<std::string>* words) {
  words->push_back(
      "Checked of each pose: joint limits, and that the arm holds the load. Not checked: collisions with "
      "itself, the cell and the floor, line of sight and the reflectors' acceptance.");
  if (request.candidates == nullptr) {
    words->push_back("Candidates are " + std::to_string(request.pool) +
                     " poses spread evenly in the joint limits, each with every way in which the rows measure one.");
  }
  std::vector<std::string> vague;
  for (const PlannedParameter& parameter : plan.parameters) {
    if (!parameter.identifiable) vague.push_back(parameter.name);
  }
  if (!vague.empty()) words->push_back("The plan does not determine " + Enumerate(vague, 6) + ".");
}

}  // namespace

Plan MakePlan(const Robot& robot, const Measurements& data, const Experiment& experiment, const PlanRequest& request) {
  if (experiment.torques_measured) {
    throw InputError({experiment.file, 0, "torques"}, "torques of poses that are not measured yet are not known",
                     "plan with torques: model");
  }
  Measurements split = data;
  SplitConfigurations(experiment.validation, &split);
  Scene scene = MakeScene(robot, split, request);
  if (scene.candidates.empty()) {
    throw InputError({"", 0, "--candidates"}, "no candidate lies within the joint limits",
                     "check the units of the list and the limits of the robot file");
  }
  CalibrationProblem problem = ProblemOf(robot, scene, experiment, request.discriminate);
  PlaceScene(split, &problem, &scene.words);
  SetHoldLimits(problem, &problem.parameters);
  ExpectReadings(&problem, ObservationsByConfiguration(problem.data), &scene);
  if (scene.candidates.empty()) {
    throw InputError({experiment.file, 0, "loads"}, "at no candidate does the arm hold its load: no equilibrium",
                     "check the load and the compliances");
  }
  const Numbers numbers = MakeNumbers(problem, scene);
  const Criterion criterion = CriterionFor(problem, numbers, request);
  Search search(numbers, criterion, request);
  if (request.poses > 0) CheckEnough(numbers, request.poses);
  Found found = request.poses > 0 ? search.At(request.poses, request.starts) : search.Reaching(request.accuracy);
  if (request.poses > 0) {  // more than asked for, for the curve
    if (request.candidates == nullptr || 2 * request.poses <= numbers.set.size()) search.At(2 * request.poses, 1);
    if (request.poses / 2 >= LeastPoses(numbers)) search.At(request.poses / 2, 1);
  }
  Plan plan;
  plan.criterion = criterion;
  plan.cost = found.exact.cost;
  if (criterion.HasCertificate()) {
    plan.bound = std::min(found.approximate.bound, plan.cost);
    plan.efficiency = criterion.Efficiency(plan.cost, plan.bound);
    if (criterion.kind == CriterionKind::kI) plan.best_rms = std::sqrt(std::max(0.0, plan.bound));
  }
  const Eigen::MatrixXd& covariance = found.exact.covariance;
  plan.position_rms = search.Rms(found);
  const Eigen::VectorXd variances = (numbers.test_rows * covariance).cwiseProduct(numbers.test_rows).rowwise().sum();
  for (int i = 0; i + 2 < variances.size(); i += 3) {
    plan.position_max = std::max(plan.position_max, std::sqrt(variances.segment<3>(i).sum()));
  }
  plan.indices.setZero();
  if (!criterion.interest.empty()) {
    plan.indices = ObservabilityIndices(covariance(criterion.interest, criterion.interest));
  }
  FillParameters(problem, numbers, covariance, &plan);
  plan.curve = search.Curve();
  plan.candidates = numbers.set.size();
  plan.infeasible = scene.infeasible;
  plan.tests = static_cast<int>(numbers.test_rows.rows() / 3);
  plan.measured = static_cast<int>(scene.measured.size());
  FillRows(problem.data, scene, found.exact.picks, request.candidates != nullptr, &plan);
  plan.words = scene.words;
  FillWords(request, plan, &plan.words);
  return plan;
}

}  // namespace sagitta
