#include "estimator/planning/numbers.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/row_batches.h"
#include "estimator/planning/model_field.h"
#include "estimator/planning/pose_space.h"
#include "models/effects/catalogue.h"
#include "problems/input_error.h"

namespace sagitta {
namespace {

// Rivals are compared at the size that the robot file states, else at one that moves 0.1 mm or 0.1 mrad (hold limit:
// 5).
constexpr double kSizePerHold = 0.02;

std::vector<int> RowsOfConfigurations(const std::vector<std::vector<int>>& observations,
                                      const std::vector<int>& configurations) {
  std::vector<int> all;
  for (const int c : configurations) all.insert(all.end(), observations[c].begin(), observations[c].end());
  return all;
}

NoiseRoots StatedNoise(const CalibrationProblem& problem, const std::vector<int>& observations) {
  const NoiseRoots roots = ObservationNoise(problem, observations, 0.0);
  if (std::all_of(roots.begin(), roots.end(), IsStated)) return roots;
  throw InputError({problem.experiment().file, 0, "noise"}, "a plan weighs readings, and nothing states their noise",
                   "give --sigma_mm, or noise: {sigma_mm: …} in the experiment file");
}

Eigen::MatrixXd RowsOf(const CalibrationProblem& problem, const std::vector<int>& observations,
                       const std::vector<int>& columns) {
  return Linearize(problem, problem.parameters, observations, columns, StatedNoise(problem, observations)).jacobian;
}

// Columns of base and markers that no candidate and no measured row changes.
std::vector<bool> OnlyTested(const CalibrationProblem& problem, const PlanNumbers& numbers,
                             const Eigen::MatrixXd& beside) {
  std::vector<bool> only(numbers.columns.size(), false);
  for (size_t i = 0; i < only.size(); ++i) {
    const Coordinate& coordinate = problem.parameters.coordinates()[numbers.columns[i]];
    const bool of_robot = problem.parameters.blocks()[coordinate.block].kind == BlockKind::kModelParameter;
    only[i] = !of_robot && numbers.set.rows.col(i).isZero(0.0) && beside.col(i).isZero(0.0);
  }
  return only;
}

// Columns of the field's effects.
std::vector<bool> OfField(const CalibrationProblem& problem, const PlanScene& scene, const std::vector<int>& columns) {
  std::vector<bool> of_field(columns.size(), false);
  for (const EffectSpec& term : scene.field) {
    const std::vector<int> own = problem.parameters.Match(term.Path());
    for (size_t i = 0; i < columns.size(); ++i) {
      if (std::find(own.begin(), own.end(), columns[i]) != own.end()) of_field[i] = true;
    }
  }
  return of_field;
}

void ScaleColumns(const CalibrationProblem& problem, int candidates, PlanNumbers* numbers) {
  const int n = static_cast<int>(numbers->columns.size());
  numbers->scale.resize(n);
  Eigen::VectorXd held(n);  // 1 / hold limit
  for (int i = 0; i < n; ++i) {
    const double limit = problem.parameters.coordinates()[numbers->columns[i]].hold_limit;
    // Columns of unit mean square over the candidates, or in units of the hold limit where no candidate moves anything.
    const double norm = numbers->set.rows.col(i).norm() / std::sqrt(static_cast<double>(candidates));
    numbers->scale[i] = norm * limit > 1e-6 ? 1.0 / norm : limit;
    numbers->set.rows.col(i) *= numbers->scale[i];
    held[i] = numbers->scale[i] / limit;
  }
  numbers->known = held.cwiseAbs2().asDiagonal();
}

}  // namespace

int Absorb(const std::vector<bool>& columns, Eigen::MatrixXd* rows) {
  std::vector<int> open;
  for (size_t i = 0; i < columns.size(); ++i) {
    if (columns[i]) open.push_back(static_cast<int>(i));
  }
  if (open.empty()) return 0;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr((*rows)(Eigen::all, open));
  qr.setThreshold(1e-10);
  Eigen::MatrixXd rotated = qr.householderQ().transpose() * *rows;
  rotated.topRows(qr.rank()).setZero();
  *rows = qr.householderQ() * rotated;
  (*rows)(Eigen::all, open).setZero();
  return static_cast<int>(qr.rank());
}

int PlanNumbers::unknowns() const {
  int count = 0;
  for (size_t i = 0; i < columns.size(); ++i) count += registered[i] || of_field[i] ? 0 : 1;
  return count;
}

PlanNumbers::FieldSplit PlanNumbers::SplitByField(const Eigen::MatrixXd& covariance) const {
  FieldSplit split;
  for (size_t i = 0; i < columns.size(); ++i) (of_field[i] ? split.field : split.rest).push_back(static_cast<int>(i));
  const Eigen::LLT<Eigen::MatrixXd> own(covariance(split.field, split.field).eval());
  split.moved = own.solve(Eigen::MatrixXd(covariance(split.field, split.rest))).transpose();
  return split;
}

Eigen::MatrixXd PlanNumbers::ByNoiseAlone(const FieldSplit& split, const Eigen::MatrixXd& covariance) {
  Eigen::MatrixXd alone = Eigen::MatrixXd::Zero(covariance.rows(), covariance.cols());
  alone(split.rest, split.rest) =
      covariance(split.rest, split.rest) - split.moved * covariance(split.field, split.rest);
  return alone;
}

Eigen::MatrixXd PlanNumbers::ByNoiseAlone(const Eigen::MatrixXd& covariance) const {
  return has_field() ? ByNoiseAlone(SplitByField(covariance), covariance) : covariance;
}

Eigen::MatrixXd PlanNumbers::OfPlainFit(const Eigen::MatrixXd& covariance) const {
  if (!has_field()) return covariance;
  const FieldSplit split = SplitByField(covariance);
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(covariance.rows(), static_cast<long>(split.field.size()));
  moved(split.rest, Eigen::all) = split.moved;
  moved(split.field, Eigen::all).setIdentity();
  moved.array().rowwise() *= (field_amplitude / scale(split.field).array()).transpose();
  return ByNoiseAlone(split, covariance) + moved * moved.transpose();
}

int PlanNumbers::LeastPoses() const {
  int most = 1;
  for (int i = 0; i < set.size(); ++i) most = std::max(most, set.count(i));
  const int missing = unknowns() - equations_known;
  return std::max(1, (missing + most - 1) / most);
}

namespace {

// Rows of the test points as they are once the marked columns are registered there (PlanNumbers::test_rows).
TestRegistration RegisterOnTests(const std::vector<bool>& registered, Eigen::MatrixXd* rows) {
  TestRegistration registration;
  std::vector<bool> sees(static_cast<size_t>(rows->rows() / 3), false);
  for (size_t i = 0; i < registered.size(); ++i) {
    if (!registered[i] || rows->col(static_cast<long>(i)).isZero(0.0)) continue;
    ++registration.unknowns;
    for (size_t p = 0; p < sees.size(); ++p) {
      if (!rows->block<3, 1>(3 * static_cast<long>(p), static_cast<long>(i)).isZero(0.0)) sees[p] = true;
    }
  }
  if (!registration.has_any()) return registration;
  std::vector<int> counting;  // rows
  for (size_t p = 0; p < sees.size(); ++p) {
    if (sees[p]) registration.coordinates += 3;
    for (int axis = 0; axis < 3 && !sees[p]; ++axis) counting.push_back(3 * static_cast<int>(p) + axis);
  }
  if (registration.unknowns < registration.coordinates) {
    registration.left = registration.coordinates - Absorb(registered, rows);
  }
  if (registration.left > 0) {
    const double share = static_cast<double>(registration.coordinates) / registration.left;
    for (size_t p = 0; p < sees.size(); ++p) {
      if (sees[p]) rows->middleRows<3>(3 * static_cast<long>(p)) *= std::sqrt(share);
    }
    return registration;
  }
  if (counting.empty()) {
    throw InputError({"", 0, "--tests"},
                     "stations and markers that only the test poses see have " + std::to_string(registration.unknowns) +
                         " unknowns, and the test points " + std::to_string(registration.coordinates) +
                         " coordinates: registering them there leaves nothing to be accurate at",
                     "give more test poses of them, at least three of a station; or test poses of stations and markers "
                     "that the rows of the plan see");
  }
  *rows = (*rows)(counting, Eigen::all).eval();
  return registration;
}

}  // namespace

PlanNumbers MakePlanNumbers(const PlanScene& scene, double model_error, std::optional<double> amplitude) {
  const CalibrationProblem& problem = *scene.problem;
  const std::vector<std::vector<int>> observations = ObservationsByConfiguration(problem.data());
  PlanNumbers numbers;
  numbers.columns = problem.parameters.EstimatedCoordinates();
  numbers.set.rows = RowsOf(problem, RowsOfConfigurations(observations, scene.candidates), numbers.columns);
  numbers.set.first = {0};
  for (const int c : scene.candidates) {
    numbers.set.first.push_back(numbers.set.first.back() + 3 * static_cast<int>(observations[c].size()));
  }
  ScaleColumns(problem, static_cast<int>(scene.candidates.size()), &numbers);
  numbers.of_field = OfField(problem, scene, numbers.columns);
  if (numbers.has_field()) {
    numbers.field_amplitude =
        amplitude ? *amplitude : FieldAmplitude(scene, numbers.columns, numbers.of_field, model_error);
    const double least = 1e-12;  // rad: known to be 0
    for (size_t i = 0; i < numbers.columns.size(); ++i) {
      if (!numbers.of_field[i]) continue;
      const double units = numbers.scale[i] / std::max(least, numbers.field_amplitude);
      numbers.known(i, i) += units * units;
    }
  }

  Linearization beside = Linearize(problem, problem.parameters, {}, numbers.columns, {}, LatentTreatment::kIgnore);
  std::vector<int> of_measured = RowsOfConfigurations(observations, scene.measured);
  const auto is_lost = [&](int i) { return !problem.data().observations[i].IsRead(); };
  of_measured.erase(std::remove_if(of_measured.begin(), of_measured.end(), is_lost), of_measured.end());
  if (!of_measured.empty()) {
    beside = Linearize(problem, problem.parameters, of_measured, numbers.columns, StatedNoise(problem, of_measured));
  }
  AppendPriors(problem.parameters, &beside);
  numbers.equations_known = beside.num_rows();
  numbers.registered = OnlyTested(problem, numbers, beside.jacobian);
  const Eigen::MatrixXd rows = beside.jacobian * numbers.scale.asDiagonal();
  numbers.known += rows.transpose() * rows;

  const std::vector<int> points = problem.data().PointsAmong(RowsOfConfigurations(observations, scene.tests));
  const NoiseRoots metres(points.size(), Matrix3<double>::Identity());
  numbers.test_rows =
      Linearize(problem, problem.parameters, points, numbers.columns, metres, LatentTreatment::kIgnore).jacobian *
      numbers.scale.asDiagonal();
  numbers.registration = RegisterOnTests(numbers.registered, &numbers.test_rows);
  return numbers;
}

Criterion CriterionFor(const CalibrationProblem& problem, const PlanNumbers& numbers, const PlanRequest& request) {
  Criterion criterion;
  criterion.kind = request.discriminate.empty() ? request.criterion : CriterionKind::kDiscriminate;
  criterion.weight = numbers.test_rows.transpose() * numbers.test_rows / (numbers.test_rows.rows() / 3.0);
  std::vector<double> sizes;
  for (size_t i = 0; i < numbers.columns.size(); ++i) {
    if (numbers.of_field[i]) continue;
    const Coordinate& coordinate = problem.parameters.coordinates()[numbers.columns[i]];
    if (criterion.kind != CriterionKind::kDiscriminate) {
      if (problem.parameters.blocks()[coordinate.block].kind == BlockKind::kModelParameter) {
        criterion.interest.push_back(static_cast<int>(i));
      }
      continue;
    }
    for (size_t k = 0; k < request.discriminate.size(); ++k) {
      if (!IsParameterOf(request.discriminate[k], coordinate.name)) continue;
      criterion.interest.push_back(static_cast<int>(i));
      criterion.rival_of.push_back(static_cast<int>(k));
      const double stated = std::abs(problem.parameters.Value(numbers.columns[i]));
      sizes.push_back((stated > 0.0 ? stated : kSizePerHold * coordinate.hold_limit) / numbers.scale[i]);
    }
  }
  criterion.size = Eigen::Map<Eigen::VectorXd>(sizes.data(), sizes.size());
  if (criterion.interest.empty() && criterion.kind != CriterionKind::kI) {
    throw InputError({problem.experiment().file, 0, "estimate"}, "no parameter of the robot is free",
                     "the criteria D, A, E and O1 to O5 need some; use I");
  }
  return criterion;
}

PoseRows::PoseRows(PlanScene* scene, const PlanNumbers& numbers) : scene_(scene), numbers_(numbers) {
  const Measurements& data = scene->problem->data();
  all_shots_ = ShotsByConfiguration(data);
  const std::vector<std::vector<int>> observations = ObservationsByConfiguration(data);
  for (const int c : scene->movable) {
    shots_.push_back(all_shots_[c]);
    observations_.push_back(observations[c]);
    sights_.push_back(SightsOf(data, all_shots_[c]));
  }
}

bool PoseRows::IsFeasible(const PlannedPose& pose) const {
  return scene_->feasible->WhyNot(pose.q, sights_[pose.way]).empty();
}

namespace {

// A shot at the moment of another finds what time and temperature left there; of what the joints left, it is
// the first.
void RememberAs(const CalibrationProblem& problem, const ShotInput& other, ShotInput* shot) {
  const Robot& robot = problem.robot();
  bool any = false;
  for (size_t i = 0; i < robot.effects.size(); ++i) {
    const EffectDefinition& definition = *FindEffect(robot, robot.effects[i].effect);
    if (!CarriesOn(definition, robot.effects[i])) continue;
    if (definition.DrivenBy(robot.effects[i]) == EffectDriver::kJoint) continue;
    shot->memory[i] = other.memory[i];
    any = true;
  }
  if (any) problem.model().PrepareAgain(shot);
}

}  // namespace

void PoseRows::Move(const PlannedPose& pose) {
  CalibrationProblem& problem = *scene_->problem;
  const bool has_conditions = pose.like >= 0 && (scene_->goes_with_time || scene_->goes_with_temperature);
  for (size_t k = 0; k < shots_[pose.way].size(); ++k) {
    const int s = shots_[pose.way][k];
    ShotInput& input = (*problem.mutable_shot_inputs())[s];
    if (has_conditions) {  // made of the same shots in the same order
      const int as = all_shots_[pose.like][k];
      std::vector<Shot>& shots = problem.mutable_data()->shots;
      const ShotConditions& when = problem.shot_inputs()[as].conditions;
      shots[s].time = shots[as].time;
      shots[s].campaign = input.conditions.campaign = shots[as].campaign;
      shots[s].temperature = shots[as].temperature;
      input.conditions.time = when.time;
      input.conditions.station_time = when.station_time;
      input.conditions.temperature = when.temperature;
    }
    input.conditions.q = pose.q;
    if (!pose.approach.empty()) {
      input.conditions.approach = pose.approach;
      problem.mutable_data()->shots[s].approach = pose.approach;
    }
    problem.model().Prepare(&input);
    if (has_conditions) RememberAs(problem, problem.shot_inputs()[all_shots_[pose.like][k]], &input);
  }
}

bool PoseRows::Expect(int way) {
  CalibrationProblem& problem = *scene_->problem;
  const std::vector<int>& observations = observations_[way];
  const Eigen::Matrix3Xd points = PredictPoints(problem, problem.parameters, observations);
  if (!points.allFinite()) return false;
  for (size_t k = 0; k < observations.size(); ++k) {
    problem.mutable_data()->observations[observations[k]].Read(points.col(k), Vector3<double>::Zero());
  }
  return true;
}

int PoseRows::MoveTo(const PlannedPose& pose) {
  Move(pose);
  Expect(pose.way);
  return scene_->movable[pose.way];
}

Eigen::MatrixXd PoseRows::At(const PlannedPose& pose) {
  Move(pose);
  CalibrationProblem& problem = *scene_->problem;
  const std::vector<int>& observations = observations_[pose.way];
  if (problem.experiment().noise.from == NoiseSpec::From::kInstrument) {  // depends on where the point is
    if (!Expect(pose.way)) return Eigen::MatrixXd();
  } else {  // not measured: derivatives are those of the prediction
    for (const int k : observations) {
      problem.mutable_data()->observations[k].point_in_station.setConstant(std::numeric_limits<double>::quiet_NaN());
      problem.mutable_data()->observations[k].mutable_rotation()->in_station.setConstant(
          std::numeric_limits<double>::quiet_NaN());
    }
  }
  const Linearization rows = LinearizeByModel(problem, problem.parameters, observations, numbers_.columns,
                                              ObservationNoise(problem, observations, 0.0));
  if (!rows.valid) return Eigen::MatrixXd();
  return rows.jacobian * numbers_.scale.asDiagonal();
}

}  // namespace sagitta
