#include "problems/measurements.h"

#include <algorithm>

namespace sagitta {

int MeasurementFile::FindColumn(const std::string& name) const {
  const auto found = std::find(header.begin(), header.end(), name);
  return found == header.end() ? -1 : static_cast<int>(found - header.begin());
}

std::string Measurements::Cell(const Observation& observation, const std::string& column) const {
  if (observation.file < 0) return "";
  const MeasurementFile& file = files[observation.file];
  const int index = file.FindColumn(column);
  return index < 0 ? "" : file.rows[observation.row].cells[index];
}

std::string Measurements::SourceOf(const Observation& observation) const {
  if (observation.file < 0) return "";
  const MeasurementFile& file = files[observation.file];
  return file.path + ":" + std::to_string(file.rows[observation.row].line);
}

}  // namespace sagitta
