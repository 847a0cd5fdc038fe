// Loads of rows or targets other than those that an estimate knows.
#pragma once

namespace sagitta {

struct KnownRobot;
struct Measurements;

// Throws InputError for a load that neither the estimate nor the row itself states: name, point and force.
void CheckLoadsAreKnown(const KnownRobot& known, const Measurements& data);

}  // namespace sagitta
