// Which columns say what marker and what pose a row is of, where no header does. Rows of equal joint values see one
// pose: where their points lie apart they are of several markers, and the marker's column is the one whose values part
// the points.
#pragma once

#include <string>
#include <vector>

#include "problems/io/import/import_plan.h"

namespace sagitta {

// What has to be equal for two rows to see the same: joints, and where and under what the arm stands.
bool IsOfPose(const PlannedColumn& column);

// Adds the column to the plans of a table with a header: the whole of its cells, or a part that recurs from pose to
// pose (SMR2 of P07_SMR2). `is_mapped`: the user names the column; then only its part is decided. A guess where the
// header does not say it.
void NameMarkers(const TextTable& table, bool is_mapped, std::vector<ImportPlan>* plans);

// Adds a column of texts, or the first part of its cells, as the names of configurations where none says so and each
// name has joint values of its own.
void NamePoses(const TextTable& table, std::vector<ImportPlan>* plans);

// Rows that the plan reads as one marker at one pose and load, and how far their points lie apart: the median over the
// poses that have several rows, in the points' unit, and two rows of such a pose. Nothing: no pose has two rows.
struct ApartRows {
  double distance = 0.0;
  int line = 0, other_line = 0;
};
ApartRows RowsOfOneMarker(const TextTable& table, const ImportPlan& plan);

// Of unequal joint values, loads or stations.
size_t DifferentPoses(const TextTable& table, const ImportPlan& plan);

}  // namespace sagitta
