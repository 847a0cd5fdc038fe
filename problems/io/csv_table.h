// A measurement file as a table of cells.
#pragma once

#include <string>

#include "problems/measurements.h"

namespace sagitta {

struct CsvTable {
  MeasurementFile file;
  int header_line = 0;
};

// UTF-8 (with or without BOM), commas, LF or CRLF, '#' comments, blank lines
// skipped, cells optionally in double quotes. Throws InputError: unreadable,
// empty, no rows, a row of another length than the header, a column name that
// is empty or stands twice, a control character, more than limits::kColumns or
// limits::kCells.
CsvTable ReadCsvTable(const std::string& path);
// The same of text that was read: `path` is what messages call it.
CsvTable ParseCsvTable(const std::string& text, const std::string& path);

}  // namespace sagitta
