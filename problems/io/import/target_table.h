// Lists of targets as spreadsheets and controllers write them, as ours are (target_file.h).
//
//   Name;A1 [deg];A2 [deg];…       target,q1_deg,q2_deg,…
//   P1;10,5;-60;…                  P1,10.5,-60,…
//
// Only names that say what they are and in which unit are read as ours; whatever else is there keeps its name, and the
// reader of targets says what it thinks of it.
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"
#include "problems/io/csv_table.h"

namespace sagitta {

// A table with its cells as they stand there.
struct TargetTable {
  CsvTable table;
  bool decimal_comma = false;
};
// Of one file. A table whose header has no comma may be separated, and its numbers written, otherwise (text_table.h).
// What was read otherwise is added to `notes`, in words. Throws InputError.
TargetTable ReadTargetTable(const std::string& path, std::vector<std::string>* notes);

// Numbers with a decimal comma as we write them, in the columns that are read as numbers; everything else stays.
void WriteNumbersAsOurs(const std::vector<size_t>& columns, MeasurementFile* file);

// Gives columns the names that target files have for what they say: of joints by the robot's own names for them or
// their numbers, X, Y, Z, KUKA's A, B, C and FANUC's W, P, R (the roll, pitch and yaw about fixed axes), the name of
// the row. X, Y and Z are joints that are called so where the columns state no pose by them. What was renamed is added
// to `notes`, in words.
void RenameTargetColumns(const std::vector<Joint>& joints, std::vector<std::string>* header,
                         std::vector<std::string>* notes);

}  // namespace sagitta
