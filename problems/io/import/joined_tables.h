// Readings whose joint values stand in another file: an instrument writes names and points, the list of the poses
// (plan.csv, a program's table) names and joint values. Rows are joined by the names, or one after the other where
// there are none.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "models/chain.h"
#include "problems/io/import/text_table.h"

namespace sagitta {

// Each table of points without joint values with the columns of the list of poses that names its rows; lists of poses
// are no tables of their own then. Without such a pair the tables as they are. `joints`: empty where the robot is not
// known; columns: what --map says, by header of either file. Throws InputError where neither names nor the number of
// rows join a pair, or a name is of several poses.
std::vector<TextTable> JoinPosesByName(std::vector<TextTable> tables, const std::vector<Joint>& joints,
                                       const std::map<std::string, std::string>& columns = {});

}  // namespace sagitta
