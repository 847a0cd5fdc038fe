#include "tools/report/residual_rows.h"

#include <algorithm>

#include "models/constants.h"

namespace sagitta {
namespace {

bool IsDrawn(const Observation& row) { return row.is_point() && !row.excluded && row.point_in_station.allFinite(); }

}  // namespace

std::vector<ResidualRow> RowsToDraw(const DrawnReadings& readings) {
  const CalibrationProblem& problem = readings.problem;
  std::vector<ResidualRow> rows;
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    const Observation& row = problem.data().observations[i];
    const Vector3<double> predicted = readings.predicted.col(static_cast<Eigen::Index>(i));
    if (!IsDrawn(row) || !predicted.allFinite()) continue;
    const Pose<double> base = readings.parameters.BaseInStation(problem.data().shots[row.shot].station);
    const Matrix3<double> base_from_station = base.rotation.transpose();
    rows.push_back({static_cast<int>(i), kMillimetresPerMetre * (base_from_station * (predicted - base.translation)),
                    kMillimetresPerMetre * (base_from_station * (row.point_in_station - predicted))});
  }
  if (rows.size() <= kMostDrawn) return rows;
  std::vector<double> distances;
  for (const ResidualRow& row : rows) distances.push_back(row.distance());
  std::nth_element(distances.begin(), distances.end() - kFarthestKept, distances.end());
  const double far = *(distances.end() - kFarthestKept);
  constexpr size_t kEven = kMostDrawn - kFarthestKept;
  std::vector<ResidualRow> drawn;
  for (size_t i = 0; i < rows.size(); ++i) {
    const bool is_next = i * kEven / rows.size() != (i + 1) * kEven / rows.size();  // kEven of them, evenly
    if (is_next || rows[i].distance() > far) drawn.push_back(rows[i]);
  }
  return drawn;
}

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
