// The problem that the benchmarks share: a loaded KR-270 with three markers, two stations, six compliances, one shot
// per configuration, every second one loaded; and stock costs by automatic differentiation to compare with.
#pragma once

#include <ceres/dynamic_autodiff_cost_function.h>

#include <memory>

#include "estimator/least_squares/ceres_problem.h"
#include "estimator/least_squares/constrained_blocks.h"
#include "estimator/least_squares/rotation_manifold.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::benchmarks {

// More than two stations: the first one under as many names, each for its share of the shots.
inline CalibrationProblem LoadedArm(int configurations, double repeatability = 0.0, int stations = 2) {
  test::LoadedTruth truth;
  truth.loads["V250"] = {{0, 0, -test::kWeightOf250Kg}};
  test::LoadedDesign design;
  design.configurations = configurations;
  Measurements data = test::LoadedRows(design, truth);
  // Half of the shots, loaded and unloaded in turn: one shot per configuration.
  Measurements half = data;
  half.shots.clear();
  half.observations.clear();
  for (size_t s = 0; s < data.shots.size(); ++s) {
    if (s % 4 != 0 && s % 4 != 3) continue;
    Shot shot = data.shots[s];
    shot.observations.clear();
    for (const int i : data.shots[s].observations) {
      shot.observations.push_back(static_cast<int>(half.observations.size()));
      half.observations.push_back(data.observations[i]);
      half.observations.back().shot = static_cast<int>(half.shots.size());
    }
    half.shots.push_back(shot);
  }
  if (stations > 2) {
    for (Shot& shot : half.shots) shot.station = 0;
  }
  test::Measure(test::ExactPoints(truth, half), design.sigma, 5, &half);
  for (size_t s = 0; stations > 2 && s < half.shots.size(); ++s) {
    half.shots[s].station = static_cast<int>(s * stations / half.shots.size());
  }
  while (static_cast<int>(half.stations.size()) < stations) {
    half.stations.push_back("S" + std::to_string(half.stations.size() + 1));
  }
  test::LoadedSetup setup = test::SetupFor(truth);
  if (repeatability > 0.0) setup.experiment.repeatability.angle.common = repeatability;
  return MakeCalibrationProblem(setup.robot, half, setup.experiment);
}

// One marker by automatic differentiation, deflections to first order (torques of the undeflected arm).
struct JetMarker {
  const CalibrationProblem* problem;
  const Observation* observation;
  std::vector<double> theta;
  std::vector<int> active;
  Matrix3<double> whitener;

  template <typename T>
  bool operator()(T const* const* blocks, T* residuals) const {
    const Shot& shot = problem->data().shots[observation->shot];
    const ShotInput& input = problem->shot_inputs()[observation->shot];
    const Chain& chain = problem->model().chain();
    std::vector<T> values_of(theta.begin(), theta.end());
    for (size_t i = 0; i < active.size(); ++i) values_of[active[i]] = blocks[3 + i][0];
    const Eigen::Map<const Eigen::Quaternion<T>> q(blocks[1]);
    const Matrix3<T> rotation = q.normalized().toRotationMatrix();
    std::vector<T> values = problem->model().TransformValues(input, values_of.data());
    ChainState<T> state;
    if (!input.wrenches.empty()) {
      EvaluateChain(chain, values.data(), &state);
      for (const ElasticTerm& term : input.terms.elastic) {
        values[term.transform] += term.factor * values_of[term.parameter] *
                                  GeneralisedForce(chain, state, term.transform, input.wrenches, rotation);
      }
    }
    EvaluateChain(chain, values.data(), &state);
    const Eigen::Map<const Vector3<T>> point(blocks[2]), translation(blocks[0]);
    const Vector3<T> in_base = state.frames[problem->marker_frames()[observation->marker]] * Vector3<T>(point);
    const Vector3<T> seen = rotation * in_base + Vector3<T>(translation);
    Eigen::Map<Vector3<T>> out(residuals);
    out = whitener.cast<T>() * (seen - observation->point_in_station.cast<T>());
    (void)shot;
    return true;
  }
};

inline void AddJets(const CalibrationProblem& problem, const ResidualSelection& selection, ParameterSet* parameters,
                    ceres::Problem* ceres_problem) {
  std::vector<int> active;
  for (int i = 0; i < parameters->num_model_parameters(); ++i) {
    if (parameters->coordinates()[parameters->model_parameter(i).first_coordinate].estimated()) active.push_back(i);
  }
  for (size_t k = 0; k < selection.observations.size(); ++k) {
    const Observation& observation = problem.data().observations[selection.observations[k]];
    auto* functor =
        new JetMarker{&problem, &observation, parameters->ModelValues(), active, selection.noise[k].inverse()};
    auto* cost = new ceres::DynamicAutoDiffCostFunction<JetMarker, 8>(functor);
    const int station = problem.data().shots[observation.shot].station;
    std::vector<double*> blocks = {parameters->station_translation(station).values.data(),
                                   parameters->station_rotation(station).values.data(),
                                   parameters->marker(observation.marker).values.data()};
    for (const int size : {3, 4, 3}) cost->AddParameterBlock(size);
    for (const int i : active) {
      cost->AddParameterBlock(1);
      blocks.push_back(parameters->model_parameter(i).values.data());
    }
    cost->SetNumResiduals(3);
    ceres_problem->AddResidualBlock(cost, nullptr, blocks);
  }
  ConstrainBlocks(*parameters, ceres_problem);
}

}  // namespace sagitta::benchmarks
