// Joints that headers name together: an arm's by the names that its maker gives them all, a gantry's X, Y, Z, the one
// that slides.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "problems/io/import/column_meaning.h"

namespace sagitta {

// Changes the meanings of these columns. joints: of the robot; empty where it is not known.
void NameJointsTogether(const std::vector<std::string>& headers, const std::vector<Joint>& joints,
                        std::vector<ColumnMeaning>* meanings);

// The joint that a column is called by; -1: none.
int JointNamed(const std::string& header, const std::vector<Joint>& joints);
// joint_of: of columns that are joints.
void SetJoints(const std::map<size_t, int>& joint_of, std::vector<ColumnMeaning>* meanings);

// E1 … E6, "Rail [mm]": an axis outside the arm, where it is none of the robot's joints.
bool NamesExternalAxis(const std::string& header);

}  // namespace sagitta
