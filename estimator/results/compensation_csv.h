// `sagitta compensate`: from an estimate and targets to what is solved, and the rows that come out.
#pragma once

#include <string>
#include <vector>

#include "estimator/compensation/compensate.h"
#include "estimator/results/estimate_json.h"

namespace sagitta {

// The chain that the controller computes with: nominal geometry, rigid, no effects; couplings stay.
Chain NominalChain(const KnownRobot& known);

// Where targets are that do not say their station: the first one known. Throws InputError where there is none.
const std::string& StationOfTargets(const KnownRobot& known);

// What can be done where targets lack a column: a robot program has none.
enum class TargetsFrom { kTable, kProgram };

// Loads, tool and gravity are those of the estimate. Throws InputError for a station or load that is not known, and
// for a column that an effect of the robot needs.
CompensationInput MakeCompensationInput(const KnownRobot& known, const Targets& targets,
                                        TargetsFrom from = TargetsFrom::kTable);

// The rows of the targets with what was found added (docs/COMPENSATION.md).
std::string CompensationToCsv(const Targets& targets, const std::vector<CompensatedTarget>& results);

}  // namespace sagitta
