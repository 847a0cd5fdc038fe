// joint_compliance has a home of its own in files, `compliance:` (FORMATS section 2): a joint gives way by one number,
// wherever it is stated.
#pragma once

#include "models/robot.h"

namespace sagitta {

// Adds the compliances that are stated among the robot's effects to its own. Those stay effects that have a prior, and
// those by which a joint would give way less than nothing, as where a simulation is softer than the arm.
void MoveCompliancesHome(Robot* robot);

}  // namespace sagitta
