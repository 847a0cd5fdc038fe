// What --map may say, and units as the names of columns have them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "problems/io/import/import_plan.h"

namespace sagitta {

bool IsLengthUnit(const std::string& unit);
bool IsAngleUnit(const std::string& unit);
std::string TorqueUnit(const Joint& joint);  // Nm; N where it slides

// {"x", "mm"} of x_mm.
std::pair<std::string, std::string> StemAndUnit(const std::string& column);

// Of a rotation or its standard deviations: rx, ow, sigma_rx, …
bool IsRotationStem(const std::string& stem);

// Throws InputError for a name that measurements.csv has not, and where the header says another unit.
void CheckMappedColumn(const TextTable& table, const std::vector<Joint>& joints, const std::string& column,
                       const PlannedColumn& planned);

// Three angles or the four parts of a quaternion, not both, put in front of their standard deviations.
void SortMappedRotation(const TextTable& table, std::vector<PlannedColumn>* rotation_columns);

// How --map names these joints of a robot (from 0), in units that they can have.
std::string HintOfJoints(const std::vector<Joint>& of_robot, const std::vector<size_t>& joints);

}  // namespace sagitta
