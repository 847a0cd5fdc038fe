// A foreign table with what its columns mean, by their headers and by what the user says of them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "problems/io/import/column_meaning.h"
#include "problems/io/import/text_table.h"

namespace sagitta {

struct MeantTable {
  TextTable table;
  std::vector<ColumnMeaning> meanings;  // of each column; empty without a header

  bool Has(Role role) const;
  // The same column of a table, by what it means; -1: there is none.
  int Find(const ColumnMeaning& other) const;
  const std::string& Cell(size_t row, int column) const { return table.rows[row].cells[static_cast<size_t>(column)]; }
};

// columns: what --map says, by column of measurements.csv; headers that the table does not have are of another one.
// A table of a name and three numbers without header gets one.
MeantTable Meant(TextTable table, const std::vector<Joint>& joints, const std::map<std::string, std::string>& columns);

// Throws InputError where --map names a header that none of the tables has.
void CheckMappedHeaders(const std::vector<MeantTable>& tables, const std::map<std::string, std::string>& columns);

// Whether names of poses may stand in such a column.
bool MayName(const ColumnMeaning& meaning);

// What a list of poses may say of points is no reading.
bool IsOfPoint(Role role);

// A column of x, y, z to fill in is no point.
bool HoldsPoints(const MeantTable& meant);

}  // namespace sagitta
