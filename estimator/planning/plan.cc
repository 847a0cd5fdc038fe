#include "estimator/planning/plan.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "estimator/planning/pose_space.h"
#include "estimator/planning/route.h"
#include "estimator/planning/search.h"
#include "estimator/planning/written_order.h"
#include "estimator/report/planning_words.h"
#include "estimator/statistics/distributions.h"
#include "estimator/statistics/mutual_information.h"
#include "models/effects/catalogue.h"
#include "problems/experiment_checks.h"
#include "problems/input_error.h"
#include "problems/noise_model.h"
#include "problems/range.h"
#include "problems/split.h"

namespace sagitta {
namespace {

// Of each parameter, whether most of what it is uncertain by is along directions that the data know better than the
// hold limits do, which are among the information A with covariance C: with L = diag(limit) in units of the parameters,
// L^-1 C L^-1 = sum of 1 / (1 + m) v v', m what the data have over the limits along v.
std::vector<bool> AreKnownByData(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& limits) {
  const Eigen::MatrixXd by_limits =
      limits.cwiseInverse().asDiagonal() * covariance * limits.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(by_limits);
  std::vector<bool> known;
  for (long i = 0; i < limits.size(); ++i) {
    const Eigen::ArrayXd parts = eigen.eigenvectors().row(i).transpose().array().square() * eigen.eigenvalues().array();
    const double open = (eigen.eigenvalues().array() < 0.5).select(0.0, parts).sum();
    known.push_back(open <= 0.5 * parts.sum());
  }
  return known;
}

void FillPlannedParameters(const CalibrationProblem& problem, const PlanNumbers& numbers,
                           const Eigen::MatrixXd& covariance, Plan* plan) {
  std::vector<long> own;
  for (size_t i = 0; i < numbers.columns.size(); ++i) {
    if (!numbers.registered[i] && !numbers.of_field[i]) own.push_back(static_cast<long>(i));
  }
  Eigen::VectorXd limits(own.size());
  for (size_t k = 0; k < own.size(); ++k) {
    limits[k] = problem.parameters.coordinates()[numbers.columns[own[k]]].hold_limit / numbers.scale[own[k]];
  }
  const std::vector<bool> known = AreKnownByData(covariance(own, own), limits);
  for (size_t k = 0; k < own.size(); ++k) {
    const Coordinate& coordinate = problem.parameters.coordinates()[numbers.columns[own[k]]];
    const double sigma = std::sqrt(covariance(own[k], own[k])) * numbers.scale[own[k]];
    plan->parameters.push_back({coordinate.name, coordinate.quantity, sigma, known[k]});
  }
}

// Effects whose size goes with time: measured in the order of the poses they would be mistaken for a place.
bool DriftIsFree(const CalibrationProblem& problem) {
  const std::vector<EffectSpec>& effects = problem.robot().effects;
  return std::any_of(effects.begin(), effects.end(), [&](const EffectSpec& effect) {
    if (FindEffect(problem.robot(), effect.effect)->DrivenBy(effect) == EffectDriver::kJoint) return false;
    const std::vector<int> own = problem.parameters.Match(effect.Path());
    return std::any_of(own.begin(), own.end(), [&](int i) { return problem.parameters.coordinates()[i].estimated(); });
  });
}

std::vector<int> OrderOf(const PlanScene& scene, const FoundPlan& found, const PlanRequest& request, Plan* plan) {
  std::vector<Eigen::VectorXd> q;
  std::vector<int> kind, as_found;
  for (const PlannedPose& pose : found.poses) {
    as_found.push_back(static_cast<int>(q.size()));
    q.push_back(pose.q);
    kind.push_back(std::max(0, pose.way));
  }
  if (DriftIsFree(*scene.problem)) {
    plan->order = OrderIsMixed();
    std::vector<int> order = MixedRoute(static_cast<int>(q.size()), request.seed);
    if (!scene.goes_with_time) return order;
    std::vector<double> time;  // s, of each pose as it is assumed
    const std::vector<std::vector<int>> shots = ShotsByConfiguration(scene.problem->data());
    for (const PlannedPose& pose : found.poses) {
      const int c = pose.candidate >= 0 ? pose.candidate : pose.like;
      time.push_back(c < 0 || shots[c].empty() ? 0.0 : scene.problem->data().shots[shots[c].front()].time);
    }
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return time[a] < time[b]; });
    return order;
  }
  const std::vector<int> order = ShortRoute(q, kind);
  plan->travel = TravelOf(q, order);
  plan->travel_as_found = TravelOf(q, as_found);
  plan->order = OrderIsShort(plan->travel / std::max(plan->travel_as_found, 1e-12));
  return order;
}

// m, root mean square of a coordinate of the fitted rows as they state their noise; 0: nothing states it.
double NoiseOfRows(const Experiment& experiment, const Measurements& data) {
  double squares = 0.0;
  int rows = 0;
  for (const Observation& row : data.observations) {
    if (!row.is_point() || data.IsValidation(row)) continue;
    const Matrix3<double> root = StatedRoot(experiment, data, row, row.point_in_station);
    if (!root.allFinite() || !IsStated(root)) continue;
    squares += root.squaredNorm() / 3.0;
    ++rows;
  }
  return rows > 0 ? std::sqrt(squares / rows) : 0.0;
}

// With the model error that the former estimate shows beyond chance: FormerMisfit's e.
PlanRequest WithField(PlanRequest request, const Experiment& experiment, const Measurements& data) {
  FormerMisfit& former = request.former;
  if (former.kind != FormerMisfit::Kind::kMeasured) return request;
  double predicted = former.predicted;
  if (former.found_noise > 0.0) {
    const double own = NoiseOfRows(experiment, data);
    if (!(own > 0.0)) {
      former.kind = FormerMisfit::Kind::kNotCompared;
      return request;
    }
    predicted *= std::min(1.0, own / former.found_noise);
  }
  const std::optional<bool> is_beyond = former.IsBeyondChance(predicted, experiment.significance);
  if (!is_beyond.value_or(false)) {
    former.kind = is_beyond ? FormerMisfit::Kind::kWithinChance : FormerMisfit::Kind::kNotCompared;
    return request;
  }
  former.predicted = predicted;
  request.field = std::sqrt(std::max(0.0, former.rms * former.rms - predicted * predicted));
  return request;
}

// Before anything is measured a row or two stand for all that will be: there the split of the readings to come need not
// divide them.
void SplitForPlan(const ValidationSpec& validation, Measurements* data, std::vector<std::string>* words) {
  const auto is_read = [](const Observation& row) { return row.IsRead(); };
  if (std::any_of(data->observations.begin(), data->observations.end(), is_read)) {
    SplitConfigurations(validation, data);
    return;
  }
  Measurements split = *data;
  try {
    SplitConfigurations(validation, &split);
    *data = std::move(split);
  } catch (const InputError& error) {
    words->push_back(NothingIsHeldOut(error.what()));
  }
}

// Rows state the noise that the plan counts with: --sigma_mm stands for what they state.
void ReplaceSigmas(const NoiseSpec& noise, Measurements* rows) {
  if (!noise.replaces_rows || !noise.sigma) return;
  for (Observation& row : rows->observations) {
    if (!row.sigma.isZero(0.0)) row.sigma.setConstant(*noise.sigma);
  }
}

void FillRows(const FoundPlan& found, const std::vector<int>& order, PlanScene* scene, PoseRows* rows, Plan* plan) {
  const Measurements& data = scene->problem->data();
  const std::vector<std::vector<int>> shots = ShotsByConfiguration(data);
  const bool keep_ids = scene->way_of.empty();
  plan->rows.files = data.files;
  plan->rows.stations = data.stations;
  plan->rows.markers = data.markers;
  // Numbered on after poses of an earlier plan.
  const std::vector<std::string> names = NamesThatAreFitted({}, data, "plan", static_cast<int>(order.size()));
  for (size_t number = 0; number < order.size(); ++number) {
    const int k = order[number];
    const PlannedPose& pose = found.poses[k];
    const int c = pose.candidate >= 0 ? pose.candidate : rows->MoveTo(pose);
    const std::string id = keep_ids ? "" : names[number];
    AppendConfiguration(data, c, shots[c], keep_ids ? Eigen::VectorXd() : pose.q, id, &plan->rows);
  }
  ReplaceSigmas(scene->problem->experiment().noise, &plan->rows);
}

void FillWords(const PlanRequest& request, const PlanScene& scene, Plan* plan) {
  std::vector<std::string>& words = plan->words;
  words = scene.words;
  plan->checked = scene.feasible->Checked();
  plan->not_checked = scene.feasible->NotChecked();
  for (std::string& assumption : AssumptionsInWords(*plan, request.candidates == nullptr)) {
    words.push_back(std::move(assumption));
  }
}

void FillCost(const Criterion& criterion, const FoundPlan& found, Plan* plan) {
  plan->criterion = criterion;
  plan->cost = found.cost;
  if (criterion.HasCertificate()) {
    plan->bound = std::min(found.approximate.bound, plan->cost);
    plan->efficiency = criterion.Efficiency(plan->cost, plan->bound);
    if (criterion.kind == CriterionKind::kI) plan->best_rms = std::sqrt(std::max(0.0, plan->bound));
  }
}

// covariance: scaled, as of `numbers`. widening: where the model error is known as a factor alone.
void FillAccuracy(const CalibrationProblem& problem, const PlanNumbers& numbers, const Criterion& criterion,
                  const Eigen::MatrixXd& covariance, double widening, Plan* plan) {
  const Eigen::MatrixXd by_noise = numbers.ByNoiseAlone(covariance);
  plan->rms_with_model_error =
      widening * std::sqrt(criterion.weight.cwiseProduct(numbers.OfPlainFit(covariance)).sum());
  plan->position_max = 0.0;
  plan->parameters.clear();
  FillPlannedParameters(problem, numbers, by_noise, plan);
  plan->position_rms = std::sqrt(criterion.weight.cwiseProduct(by_noise).sum());
  const Eigen::VectorXd variances = (numbers.test_rows * by_noise).cwiseProduct(numbers.test_rows).rowwise().sum();
  for (int i = 0; i + 2 < variances.size(); i += 3) {
    plan->position_max = std::max(plan->position_max, std::sqrt(variances.segment<3>(i).sum()));
  }
  plan->tests = static_cast<int>(numbers.test_rows.rows() / 3);
  plan->indices.setZero();
  if (!criterion.interest.empty()) {
    plan->indices = ObservabilityIndices(covariance(criterion.interest, criterion.interest));
  }
  if (criterion.kind != CriterionKind::kDiscriminate) return;
  const std::vector<double> apart = criterion.Apart(covariance(criterion.interest, criterion.interest));
  plan->apart = plan->information = plan->decides = 0.0;
  for (const double d : apart) {
    const TwoApart two = InformationOfTwo(d);
    plan->apart += d / static_cast<double>(apart.size());
    plan->information += two.information / static_cast<double>(apart.size());
    plan->decides += two.decides / static_cast<double>(apart.size());
  }
}

}  // namespace

std::optional<bool> FormerMisfit::IsBeyondChance(double predicted_now, double significance) const {
  if (p_value && *p_value < significance) return true;  // and so beyond less than it predicted
  if (p_value && predicted_now >= predicted) return false;
  if (!(dof > 0.0)) return std::nullopt;
  return rms * rms * dof / ChiSquareQuantile(1.0 - significance, dof) > predicted_now * predicted_now;
}

void CheckOptions(const PlanRequest& request) {
  if (request.poses != 0) CheckIn(allowed::kPoses, request.poses, "PlanRequest.poses");
  if (request.accuracy != 0.0) CheckIn(allowed::kAccuracy, request.accuracy, "PlanRequest.accuracy");
  if ((request.poses != 0) == (request.accuracy != 0.0)) {
    throw InputError({"", 0, "PlanRequest.poses"}, "one of poses and accuracy is expected to say how many");
  }
  CheckIn(allowed::kWideningFactor, request.model_error, "PlanRequest.model_error");
  CheckIn(allowed::kMisfit, request.field, "PlanRequest.field");
  CheckIn(allowed::kPool, request.pool, "PlanRequest.pool");
  CheckIn(allowed::kPoses, request.most_poses, "PlanRequest.most_poses");
  CheckIn(allowed::kStarts, request.starts, "PlanRequest.starts");
}

Plan MakePlan(const Robot& robot, const Measurements& data, const Experiment& experiment, const PlanRequest& asked) {
  CheckOptions(asked);
  CheckExperiment(experiment);
  if (experiment.torques_measured) {
    throw InputError({experiment.file, 0, "torques"}, "torques of poses that are not measured yet are not known",
                     "plan with torques: model");
  }
  Measurements split = data;
  std::vector<std::string> of_split;
  SplitForPlan(experiment.validation, &split, &of_split);
  const PlanRequest request = WithField(asked, experiment, split);
  CheckIn(allowed::kMisfit, request.field, "PlanRequest.former");
  PlanScene scene = MakePlanScene(robot, split, experiment, request);
  scene.words.insert(scene.words.begin(), of_split.begin(), of_split.end());
  PlanNumbers numbers = MakePlanNumbers(scene, request.field);
  if (numbers.registration.has_any()) {
    scene.words.push_back(
        RegisteredOnTests(numbers.registration.unknowns, numbers.registration.coordinates, numbers.registration.left));
  }
  const Criterion criterion = CriterionFor(*scene.problem, numbers, request);
  const int drawn = numbers.set.size();
  PlanSearch search(&scene, &numbers, criterion, request);
  const FoundPlan found =
      request.poses > 0 ? search.At(request.poses) : search.Reaching(request.accuracy / search.Widening());
  search.Extend(static_cast<int>(found.poses.size()));
  Plan plan;
  FillCost(criterion, found, &plan);
  plan.model_error = request.model_error;
  plan.field = request.field;
  plan.former = request.former;
  plan.field_amplitude = numbers.field_amplitude;
  FillAccuracy(*scene.problem, numbers, criterion, found.covariance, search.Widening(), &plan);
  plan.curve = search.Curve();
  plan.knee = search.Knee();
  plan.candidates = drawn;
  plan.found_given_measured = search.found_given_measured();
  plan.moved =
      std::any_of(found.poses.begin(), found.poses.end(), [](const PlannedPose& pose) { return pose.candidate < 0; });
  plan.infeasible_because = scene.infeasible;
  for (const auto& [why, count] : scene.infeasible) plan.infeasible += count;
  plan.measured = static_cast<int>(scene.measured.size());
  plan.goes_with_time = scene.goes_with_time;
  plan.goes_with_temperature = scene.goes_with_temperature;
  FillRows(found, OrderOf(scene, found, request, &plan), &scene, &search.rows(), &plan);
  const std::vector<std::string> of_order = EffectsOfTheOrder(*scene.problem);
  if (!of_order.empty()) {
    const double searched = plan.rms_with_model_error;
    const WrittenPlan written =
        JudgeAsWritten(robot, split, experiment, request, scene, plan.rows, numbers.field_amplitude);
    FillAccuracy(*written.scene.problem, written.numbers, written.criterion, written.covariance, search.Widening(),
                 &plan);
    scene.words.push_back(JudgedInItsOrder(of_order, searched, plan.rms_with_model_error, request.accuracy));
  }
  FillWords(request, scene, &plan);
  return plan;
}

}  // namespace sagitta
