#include "estimator/least_squares/structure.h"

#include <cmath>

namespace sagitta {
namespace {

// The loaded KR-270 of tests/benchmarks, 400 configurations from 2 to 100 stations, three markers (BENCHMARKS.md,
// "Sparse factors"): a sparse iteration costs what a dense one does at 120 unknowns, of which a reading touches 27 %,
// and a ninth of it at 630.
constexpr int kFewUnknowns = 100;
constexpr double kSparseShare = 0.3;
// There an iteration on sums needs 3 ns for the cube of the unknowns, a sparse one 4.5 us per row: n^3 of what a row is
// worth.
constexpr double kCubePerRow = 1500.0;

}  // namespace

bool Structure::IsSparse() const { return unknowns >= kFewUnknowns && touched <= kSparseShare; }

bool Structure::IsSparserThanSums() const { return IsSparse() && std::pow(unknowns, 3) > kCubePerRow * rows; }

Structure StructureOf(const CalibrationProblem& problem, const ResidualSelection& selection,
                      const ParameterSet& parameters) {
  const auto count = [&](const ParameterBlock& block) {
    double estimated = 0.0;
    for (int i = 0; i < block.tangent_size; ++i) {
      if (parameters.coordinates()[block.first_coordinate + i].estimated()) estimated += 1.0;
    }
    return estimated;
  };
  double of_model = 0.0;
  for (int i = 0; i < parameters.num_model_parameters(); ++i) of_model += count(parameters.model_parameter(i));
  std::vector<double> of_station, of_point, of_rotation;
  for (int s = 0; s < parameters.num_stations(); ++s) {
    of_station.push_back(count(parameters.station_translation(s)) + count(parameters.station_rotation(s)));
  }
  for (int m = 0; m < parameters.num_markers(); ++m) {
    of_point.push_back(count(parameters.read_block(m, ReadingKind::kPoint)));
    of_rotation.push_back(parameters.is_oriented(m) ? count(parameters.read_block(m, ReadingKind::kRotation)) : 0.0);
  }
  double touched = 0.0;
  for (const int i : selection.observations) {
    const Observation& observation = problem.data().observations[i];
    const std::vector<double>& of_marker = observation.is_point() ? of_point : of_rotation;
    touched += of_model + of_station[problem.data().shots[observation.shot].station] + of_marker[observation.marker];
  }
  Structure structure;
  structure.unknowns = static_cast<int>(parameters.EstimatedCoordinates().size());
  structure.rows = 3 * static_cast<int>(selection.observations.size());
  const double all = static_cast<double>(structure.unknowns) * static_cast<double>(selection.observations.size());
  if (all > 0.0) structure.touched = touched / all;
  return structure;
}

}  // namespace sagitta
