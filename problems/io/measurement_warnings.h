// What rows that can be read show that nobody means: labels that are slips of the hand, readings that are copies,
// clocks and temperatures that are none. Each is a warning of the measurements, with file and line.
#pragma once

#include "problems/measurements.h"

namespace sagitta {

void WarnOfRows(Measurements* data);

}  // namespace sagitta
