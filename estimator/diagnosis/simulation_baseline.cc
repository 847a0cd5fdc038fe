#include "estimator/diagnosis/simulation_baseline.h"

#include <cmath>
#include <optional>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/calibration/unit_guess.h"
#include "estimator/least_squares/linearization.h"
#include "problems/input_error.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

// A coordinate, m, of the column that its file has, in whichever unit.
double SimulatedCoordinate(const Measurements& data, const Observation& observation, const std::string& stem) {
  for (const Unit& unit : UnitsOf(Dimension::kLength)) {
    const std::string column = stem + "_" + unit.suffix;
    const std::string cell = data.Cell(observation, column);
    if (cell.empty()) continue;
    if (const std::optional<double> number = ParseNumber(cell)) return unit.ToSi(*number);
    throw InputError({data.SourceOf(observation), 0, column}, "'" + cell + "' is no number");
  }
  throw InputError({data.SourceOf(observation), 0, NamesWithUnits(stem, Dimension::kLength)},
                   "the row states no simulated point",
                   "--simulation=columns needs sim_x_mm, sim_y_mm, sim_z_mm in every row");
}

Vector3<double> SimulatedPoint(const Measurements& data, const Observation& observation) {
  return {SimulatedCoordinate(data, observation, "sim_x"), SimulatedCoordinate(data, observation, "sim_y"),
          SimulatedCoordinate(data, observation, "sim_z")};
}

// Else the gap would be metres wide, and the search for its cause need minutes.
void RefuseWrongUnit(const CalibrationProblem& of_simulation) {
  if (const std::optional<UnitFinding> finding = GuessWrongUnit(of_simulation, "sim_")) {
    throw InputError({finding->file, finding->line, finding->column}, finding->words, finding->hint);
  }
}

}  // namespace

SimulationBaseline AgainstSimulation(const CalibrationProblem& problem) {
  std::vector<int> all;
  std::vector<Vector3<double>> simulated;
  for (const Observation& observation : problem.data().observations) {
    all.push_back(static_cast<int>(all.size()));
    simulated.push_back(SimulatedPoint(problem.data(), observation));
  }
  CalibrationProblem of_simulation = problem;
  std::vector<Observation>& rows_of_simulation = of_simulation.mutable_data()->observations;
  for (Observation& observation : rows_of_simulation) observation.excluded |= !observation.is_point();
  for (const int i : all) rows_of_simulation[i].point_in_station = simulated[i];
  RefuseWrongUnit(of_simulation);
  SimulationBaseline baseline{problem, Eigen::Matrix3Xd(3, all.size()), 0.0};
  AlignNominal(of_simulation, &baseline.problem.parameters);
  const Eigen::Matrix3Xd nominal = PredictPoints(problem, baseline.problem.parameters, all);
  baseline.shift.setZero();
  int points = 0;
  for (const int i : all) {
    Observation& row = baseline.problem.mutable_data()->observations[i];
    row.excluded |= !row.is_point();  // another simulation's columns predict points
    if (!row.is_point()) continue;
    ++points;
    baseline.shift.col(i) = nominal.col(i) - simulated[i];
    row.point_in_station += baseline.shift.col(i);
  }
  // Of the whole model: what AlignNominal returns is the misfit of the rigid arm, without its deflections.
  baseline.reproduced = std::sqrt(baseline.shift.squaredNorm() / points);
  return baseline;
}

void SimulationBaseline::Unshift(CalibrationProblem* extended, Estimate* estimate) const {
  std::vector<Observation>& rows = extended->mutable_data()->observations;
  for (long i = 0; i < shift.cols(); ++i) rows[i].point_in_station -= shift.col(i);
  estimate->predicted -= shift;
}

}  // namespace sagitta
