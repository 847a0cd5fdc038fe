// Which configurations are held out for validation (FORMATS section 3).
#pragma once

#include <vector>

#include "problems/experiment.h"
#include "problems/measurements.h"

namespace sagitta {

// Marks Configuration::is_validation. Fraction: configurations with equal joint
// values count as one, named by the first; sorted by the hex SHA-256 of
// "<seed>:<config>"; the first ceil(fraction * n) are validation. by time: the
// last ones. Throws InputError when nothing or everything is held out, a column
// is absent, or one configuration has both kinds of rows.
void SplitConfigurations(const ValidationSpec& spec, Measurements* data);

// Configurations with equal joint values, in order of appearance.
std::vector<std::vector<int>> GroupsOfEqualJointValues(const Measurements& data);
// The place of each configuration's group among them.
std::vector<int> GroupsOfConfigurations(const Measurements& data);

}  // namespace sagitta
