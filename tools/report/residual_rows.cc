#include "tools/report/residual_rows.h"

#include <algorithm>

#include "models/constants.h"

namespace sagitta {
namespace {

bool IsDrawn(const Observation& row) { return row.is_point() && !row.excluded && row.point_in_station.allFinite(); }

// Of each station.
std::vector<Pose<double>> BasesOf(const DrawnReadings& readings) {
  std::vector<Pose<double>> bases;
  for (int s = 0; s < readings.parameters.num_stations(); ++s) {
    bases.push_back(readings.parameters.BaseInStation(s));
  }
  return bases;
}

std::vector<ResidualRow> RowsToDraw(const DrawnReadings& readings) {
  const CalibrationProblem& problem = readings.problem;
  std::vector<int> rows;
  std::vector<double> distances;  // m
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    const Observation& row = problem.data().observations[i];
    const auto predicted = readings.predicted.col(static_cast<Eigen::Index>(i));
    if (!IsDrawn(row) || !predicted.allFinite()) continue;
    rows.push_back(static_cast<int>(i));
    distances.push_back((row.point_in_station - predicted).norm());
  }
  const bool are_many = rows.size() > kMostDrawn;
  std::vector<double> sorted = are_many ? distances : std::vector<double>();
  if (are_many) std::nth_element(sorted.begin(), sorted.end() - kFarthestKept, sorted.end());
  const double far = are_many ? *(sorted.end() - kFarthestKept) : 0.0;
  constexpr size_t kEven = kDrawnOfMany - kFarthestKept;
  const std::vector<Pose<double>> bases = BasesOf(readings);
  std::vector<ResidualRow> drawn;
  drawn.reserve(std::min(rows.size(), kMostDrawn));
  for (size_t i = 0; i < rows.size(); ++i) {
    const bool is_next = i * kEven / rows.size() != (i + 1) * kEven / rows.size();  // kEven of them, evenly
    if (are_many && !is_next && distances[i] <= far) continue;
    const Observation& row = problem.data().observations[static_cast<size_t>(rows[i])];
    const Pose<double>& base = bases[static_cast<size_t>(problem.data().shots[row.shot].station)];
    const Vector3<double> predicted = readings.predicted.col(rows[i]);
    drawn.push_back({rows[i], kMillimetresPerMetre * (base.rotation.transpose() * (predicted - base.translation)),
                     kMillimetresPerMetre * (base.rotation.transpose() * (row.point_in_station - predicted))});
  }
  return drawn;
}

}  // namespace

DrawnReadings::DrawnReadings(const CalibrationProblem& of, const ParameterSet& values, const Eigen::Matrix3Xd& points)
    : problem(of), parameters(values), predicted(points), rows(RowsToDraw(*this)) {}

std::string NameOfRow(const Measurements& data, const Observation& row) {
  const std::string name = data.ConfigurationOf(row).id + " " + data.markers[row.marker];
  return data.stations.size() < 2 ? name : name + " " + data.stations[data.shots[row.shot].station];
}

std::string LeftOutInWords(const CalibrationProblem& problem, size_t drawn) {
  const std::vector<Observation>& all = problem.data().observations;
  const auto points = static_cast<size_t>(std::count_if(all.begin(), all.end(), IsDrawn));
  if (drawn >= points) return "";
  return "; drawn: " + std::to_string(drawn) + " of " + std::to_string(points) + " points, the farthest among them";
}

}  // namespace sagitta
