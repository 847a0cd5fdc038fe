// Measurement files (FORMATS section 2): comma, header row, '#' comments.
#pragma once

#include <string>
#include <vector>

#include "models/robot.h"
#include "problems/io/csv_table.h"
#include "problems/measurements.h"

namespace sagitta {

struct MeasurementReadOptions {
  bool points_required = true;  // predict and plan: x, y, z may be absent
  bool row_sigmas_used = true;  // false: the rows' standard deviations are replaced, and not even looked at
};

// Several files make one set of data; ids are shared across them. Columns are q1 .. qN by position, in the unit that
// the robot's joint has to have. Throws InputError.
Measurements ReadMeasurementsFor(const Robot& robot, const std::vector<std::string>& paths,
                                 const MeasurementReadOptions& options = {});

// The same of tables that are in memory already.
Measurements MeasurementsFromTables(std::vector<CsvTable> tables, const Robot& robot,
                                    const MeasurementReadOptions& options = {});
// The same of text that was read.
Measurements ReadMeasurementsText(const Robot& robot, const std::string& text, const std::string& file_in_messages,
                                  const MeasurementReadOptions& options = {});

}  // namespace sagitta
