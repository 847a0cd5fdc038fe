// The commands, one file each.
#pragma once

#include "tools/command_line.h"

namespace sagitta {

Command CalibrateCommand();
Command PredictCommand();
Command SimulateCommand();
Command ChangedCommand();
Command CompareCommand();
Command CompensateCommand();
Command ConvertCommand();
Command CoverageCommand();
Command DiagnoseCommand();
Command ImportCommand();
Command InspectCommand();
Command PlanCommand();
Command ValidateCommand();

}  // namespace sagitta
