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

// UTF-8 (with or without BOM), commas, LF or CRLF, '#' comments, blank lines
// skipped, cells optionally in double quotes. Throws InputError: unreadable,
// empty, no rows, a row of another length than the header, a column name that
// is empty or stands twice, a control character, more than limits::kColumns or
// limits::kCells.
CsvTable ReadCsvTable(const std::string& path);
// The same of text that was read: `path` is what messages call it.
CsvTable ParseCsvTable(const std::string& text, const std::string& path);
// The same of columns in memory, of one length, with what the reader refuses but for quotes and comments. `name` is
// what messages call the table, `lines` what they call its rows; without, row 1 is the first.
CsvTable CsvTableOf(const std::string& name, std::vector<std::string> header,
                    const std::vector<std::vector<std::string>>& columns, const std::vector<int>& lines = {});

}  // namespace sagitta
