// What rows that can be read show that nobody means: labels that are slips of the hand, readings that are copies,
// clocks and temperatures that are none. Each is a warning of the measurements, with file and line.
#pragma once

#include <cstddef>

#include "problems/measurements.h"

namespace sagitta {

constexpr size_t kFewestCopies = 3;  // readings that agree by chance: one, or two of a coarse display

void WarnOfRows(Measurements* data);

}  // namespace sagitta
