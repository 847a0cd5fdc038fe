// Rows of foreign tables as one measurements.csv.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "problems/io/import/table_rows.h"

namespace sagitta {

class ImportedRows {
 public:
  // Reads rows by the plan, of all shots or of every `stride`-th. Lost readings (an empty, NaN or
  // -9999 cell among joints and points, or 0, 0, 0) are left out and counted; a cell that
  // is neither a number nor lost is an InputError with file and line.
  void Add(const TextTable& table, const ImportPlan& plan, const RowDefaults& defaults, size_t stride = 1);

  // Rows of equal joint values are one configuration, unless a column says so.
  std::string ToCsv(int joints) const;

  size_t size() const { return rows_.size(); }
  // File and line of a row, as in "tracker.csv:57".
  std::string SourceOf(size_t row) const;
  // Loads whose masses, kg, the cells state ("5 kg", or 5 where the header says kg).
  const std::map<std::string, double>& masses() const { return names_.masses; }
  const std::vector<std::string>& notes() const { return notes_; }  // lost readings, columns that say nothing

 private:
  void NameConfigurations(std::vector<ImportedRow>* rows, bool has_column, int joints);

  std::vector<ImportedRow> rows_;
  ImportedNames names_;
  std::vector<std::string> notes_;
};

}  // namespace sagitta
