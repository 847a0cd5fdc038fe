#include "problems/io/rows_in_memory.h"

#include <algorithm>
#include <cmath>

#include "problems/text.h"

namespace sagitta {
namespace {

std::vector<std::string> CellsInMemory(const Measurements& data, const Observation& row) {
  const Shot& shot = data.shots[row.shot];
  std::vector<std::string> cells = {
      data.configurations[shot.configuration].id,    shot.visit, shot.repeat, shot.load, data.stations[shot.station],
      row.marker < 0 ? "" : data.markers[row.marker]};
  for (const double coordinate : row.point_in_station) {
    cells.push_back(std::isfinite(coordinate) ? FormatNumber(1e3 * coordinate) : "");
  }
  return cells;
}

}  // namespace

const Measurements& WithCells(const Measurements& data, std::optional<Measurements>* made) {
  const auto is_of_file = [](const Observation& row) { return row.file >= 0; };
  if (std::all_of(data.observations.begin(), data.observations.end(), is_of_file)) return data;
  Measurements& whole = made->emplace(data);
  MeasurementFile file;
  file.header = {"config", "visit", "repeat", "load", "station", "marker", "x_mm", "y_mm", "z_mm"};
  const int added = static_cast<int>(whole.files.size());
  for (Observation& row : whole.observations) {
    if (is_of_file(row)) continue;
    row.file = added;
    row.row = static_cast<int>(file.rows.size());
    file.rows.push_back({row.row + 1, CellsInMemory(data, row)});
  }
  whole.files.push_back(std::move(file));
  return whole;
}

}  // namespace sagitta
