// joint_compliance has a home of its own in files, `compliance:` (FORMATS section 2): a joint gives way by one number,
// wherever it is stated.
#pragma once

#include "models/robot.h"

namespace sagitta {

// What becomes of a compliance that has a prior of its own (EffectSpec::prior_sigmas), for which there is no place at
// home: it stays an effect, or goes without.
enum class PriorOfCompliance { kStays, kIsDropped };

// Adds the compliances that are stated among the robot's effects to its own. Those stay effects by which a joint would
// give way less than nothing, as where a simulation is softer than the arm.
void MoveCompliancesHome(PriorOfCompliance prior, Robot* robot);

}  // namespace sagitta
