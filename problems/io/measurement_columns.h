// Which column of a measurement file means what (FORMATS section 2).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "problems/io/csv_table.h"
#include "problems/io/units.h"

namespace sagitta {

struct NumberColumn {
  int index = -1;  // -1: the file has none
  std::string name;
  Unit unit{"", 1.0, 1.0};

  bool present() const { return index >= 0; }
};

struct MeasurementColumns {
  int config = -1, marker = -1, station = -1, visit = -1, repeat = -1, load = -1, set = -1;
  std::vector<NumberColumn> q;  // one per joint
  std::array<NumberColumn, 3> point, sigma, sim;
  std::array<NumberColumn, 3> rotation, rotation_sigma;  // rotation vector
  std::array<NumberColumn, 4> quaternion;                // scalar first; instead of the vector
  NumberColumn common_rotation_sigma;                    // sigma_rot, instead of rotation_sigma
  std::array<NumberColumn, 6> wrench;                    // force, then moment
  NumberColumn time, temperature;
  std::vector<NumberColumn> approach;  // one per joint
  std::vector<NumberColumn> torque;    // one per joint; N m, or N where it slides
  std::vector<std::string> unread;     // carried along
};

// Throws InputError: missing, misspelt, reserved, in a wrong unit, or for
// another number of joints.
MeasurementColumns FindMeasurementColumns(const CsvTable& table, const std::vector<std::string>& joints,
                                          const std::vector<bool>& prismatic, bool points_required);

}  // namespace sagitta
