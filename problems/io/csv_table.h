// A measurement file as a table of cells.
#pragma once

#include <string>
#include <vector>

#include "problems/measurements.h"

namespace sagitta {

struct CsvTable {
  MeasurementFile file;
  int header_line = 0;
};

// What a table is of: `sagitta import` reads measurements of other formats, and no targets.
enum class CsvContent { kMeasurements, kTargets };

// UTF-8 (with or without BOM), commas, LF or CRLF, '#' comments, blank lines
// skipped, cells optionally in double quotes. Throws InputError: unreadable,
// empty, no rows, a row of another length than the header, a column name that
// is empty or stands twice, a control character, more than limits::kColumns or
// limits::kCells.
CsvTable ReadCsvTable(const std::string& path, CsvContent content = CsvContent::kMeasurements);
// The same of text that was read: `path` is what messages call it.
CsvTable ParseCsvTable(const std::string& text, const std::string& path,
                       CsvContent content = CsvContent::kMeasurements);
// The same of columns in memory, of one length, with what the reader refuses but for quotes and comments. Row 1 is the
// first; `name` is what messages call the table.
CsvTable CsvTableOf(const std::string& name, std::vector<std::string> header,
                    const std::vector<std::vector<std::string>>& columns);

}  // namespace sagitta
