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

// Several files make one set of data; ids are shared across them. `joints` are
// the robot's joint names, for messages; columns are q1 .. qN by position,
// `prismatic[j]` states which unit column j has to have. Throws InputError.
Measurements ReadMeasurements(const std::vector<std::string>& paths, const std::vector<std::string>& joints,
                              const std::vector<bool>& prismatic, const MeasurementReadOptions& options = {});

// With the columns that this robot's joints ask for.
Measurements ReadMeasurementsFor(const Robot& robot, const std::vector<std::string>& paths,
                                 const MeasurementReadOptions& options = {});

// The same of tables that are in memory already.
Measurements MeasurementsFromTables(std::vector<CsvTable> tables, const Robot& robot,
                                    const MeasurementReadOptions& options = {});
// The same of text that was read.
Measurements ReadMeasurementsText(const Robot& robot, const std::string& text, const std::string& file_in_messages,
                                  const MeasurementReadOptions& options = {});

}  // namespace sagitta
