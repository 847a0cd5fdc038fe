// Which plan the size of the numbers alone speaks for.
#include <algorithm>
#include <cmath>

#include "problems/io/import/import_plan.h"
#include "problems/io/import/mapped_columns.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

double LargestOf(const TextTable& table, const PlannedColumn& column) {
  double largest = 0.0;
  for (const TextTable::Row& row : table.rows) {
    const std::optional<double> number = table.Number(row.cells[column.source]);
    if (number && *number != kLostReading) largest = std::max(largest, std::abs(*number));
  }
  return largest;
}

}  // namespace

size_t PlanBySize(const TextTable& table, const std::vector<ImportPlan>& plans) {
  // The bounds of the check in calibrate (unit_guess.cc).
  for (size_t i = 0; i < plans.size(); ++i) {
    double angle = 0.0, length = 0.0;
    std::string angle_unit, length_unit;
    for (const PlannedColumn& column : plans[i].columns) {
      if (column.stem[0] == 'q' && IsAngleUnit(column.unit)) {
        angle = std::max(angle, LargestOf(table, column));
        angle_unit = column.unit;
      }
      if (column.stem.size() == 1) {
        length = std::max(length, LargestOf(table, column));
        length_unit = column.unit;
      }
    }
    const bool angles_fit = angle_unit.empty() || (angle > kMostRadians) == (angle_unit == "deg");
    const bool lengths_fit = (length > kMostMetres) == (length_unit == "mm");
    if (angles_fit && lengths_fit) return i;
  }
  return 0;
}

}  // namespace sagitta
