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

// Of one file. A table whose header has no comma may be separated, and its numbers written, otherwise (text_table.h);
// it comes with the numbers as we write them. What was read otherwise is added to `notes`, in words. Throws InputError.
CsvTable ReadTargetTable(const std::string& path, std::vector<std::string>* notes);

// Gives columns the names that target files have for what they say: of joints by the robot's own names for them or
// their numbers, X, Y, Z, KUKA's A, B, C and FANUC's W, P, R (the roll, pitch and yaw about fixed axes), the name of
// the row. What was renamed is added to `notes`, in words.
void RenameTargetColumns(const std::vector<Joint>& joints, std::vector<std::string>* header,
                         std::vector<std::string>* notes);

}  // namespace sagitta
