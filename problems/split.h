// Which configurations are held out for validation (FORMATS section 3).
#pragma once

#include "problems/experiment.h"
#include "problems/measurements.h"

namespace sagitta {

// Marks Configuration::is_validation. Fraction: configurations with equal joint
// values count as one, named by the first; sorted by the hex SHA-256 of
// "<seed>:<config>"; the first ceil(fraction * n) are validation. by time: the
// last ones. Throws InputError when nothing or everything is held out, a column
// is absent, or one configuration has both kinds of rows.
void SplitConfigurations(const ValidationSpec& spec, Measurements* data);

}  // namespace sagitta
