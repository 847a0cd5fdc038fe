// What a column of a foreign table means, by its name.
//
// Only names that say so are read as measured points; commanded, nominal and
// target positions and differences are recognised as such and left out with the
// reason. How an angle is meant, no name says (rotation_reading.h).
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"

namespace sagitta {

enum class Role {
  kJoint,       // index: joint from 0
  kPoint,       // index: 0 x, 1 y, 2 z
  kSigma,       // of the point
  kTarget,      // where the point was meant to be; index as of kPoint
  kDifference,  // between measured and target; index as of kPoint
  kRotation,    // an angle; index: 0 about x, 1 about y, 2 about z
  kQuaternion,  // index: 0 w, 1 x, 2 y, 3 z
  kAngleSigma,  // of kRotation
  kTorque,      // measured, of a joint; index: joint
  kWrench,      // index: fx fy fz mx my mz
  kApproach,    // index: joint
  kTemperature,
  kTime,
  kText,  // a column that measurements.csv has by the same name: config, marker, station …
  kOther  // not used
};

struct ColumnMeaning {
  Role role = Role::kOther;
  int index = -1;
  std::string name;              // of kText
  std::string unit;              // "" where the header does not say
  bool is_commanded = false;     // a joint value that the name calls commanded
  bool is_actual = false;        // a joint value that the name calls actual
  bool is_numbered = false;      // a joint value whose name has the joint's number and no joint's own name
  bool says_measured = false;    // a point or rotation that the name calls measured
  bool may_be_expanded = false;  // of kSigma: an uncertainty, and no word for how many standard deviations
  bool is_mapped = false;        // --map says it
  std::string why;               // of kOther and kTarget, in words
  std::string unread_unit;       // of kOther: the unit, as written, for which alone it has no other role
};

// `joints`: the robot's joint names, empty when it is not known.
ColumnMeaning MeaningOf(const std::string& header, const std::vector<std::string>& joints);

// Of all headers together. Base, Shoulder, Elbow, Wrist 1 … 3, as Universal Robots' pendant has them, are joints where
// all six are there. E1 [mm], A1 [deg] … A6 [deg] of a robot with the joints E1, j1 … j6: numbers count the turning
// joints where their units are of these and the robot's own names number them so.
std::vector<ColumnMeaning> MeaningsOf(const std::vector<std::string>& headers, const std::vector<Joint>& joints);

}  // namespace sagitta
