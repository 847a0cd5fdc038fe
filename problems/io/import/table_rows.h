// Rows of one foreign table as rows of measurements.csv.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "problems/io/import/import_plan.h"
#include "problems/io/import/time_column.h"

namespace sagitta {

using ImportedRow = std::map<std::string, std::string>;  // cell by column of measurements.csv

// What stands for columns that a table does not have.
struct RowDefaults {
  std::string station = "S1";
  std::string marker = "M1";
};

// What all tables of an import share.
struct ImportedNames {
  std::map<std::string, std::string> unit_of;  // by stem, as the first table has it
  std::map<std::string, double> masses;        // kg, of loads whose cells state them
  std::optional<TimeOrigin> times_from;        // as the first table with times counts them
  std::string times_of;                        // that table's path
};

// Reads a table by its plan. A cell that is neither a number nor lost is an InputError with file and line.
class TableRows {
 public:
  TableRows(const TextTable& table, const ImportPlan& plan, const RowDefaults& defaults, ImportedNames* names);

  // The readings, of all shots or of every `stride`-th; lost ones are left out and counted.
  std::vector<ImportedRow> Read(size_t stride);
  // Of what was read last: columns that say nothing, lost readings.
  std::vector<std::string> Notes() const;

 private:
  enum class Found { kReading, kLost, kZeros };

  void RefuseOtherClock(const PlannedColumn& column);
  std::string ShotOf(const TextTable::Row& source) const;
  // The cells of points, joints, loads, times; whether these are a reading.
  Found ReadRow(const TextTable::Row& source, ImportedRow* row);
  std::string TextCell(const PlannedColumn& column, const std::string& cell);
  void AddTime(const TextTable::Row& source, const PlannedColumn& column, ImportedRow* row) const;
  // A number of one or two columns; nothing where it is lost.
  std::optional<double> NumberIn(const TextTable::Row& source, const PlannedColumn& column) const;
  void AddNumber(const PlannedColumn& column, double number, ImportedRow* row);
  std::string LoadName(const PlannedColumn& column, const std::string& cell);
  void AddRotation(const TextTable::Row& source, ImportedRow* row);
  void DropPartOfTorques(ImportedRow* row) const;

  const TextTable& table_;
  const ImportPlan& plan_;
  const RowDefaults& defaults_;
  ImportedNames* names_;
  TimeColumn time_;
  bool sigma_is_lost_ = false;  // of the row that is read
  size_t lost_ = 0, zeros_ = 0, without_sigma_ = 0, without_rotation_ = 0;
  int first_lost_ = 0;  // its line
};

}  // namespace sagitta
