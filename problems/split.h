// Which configurations are held out for validation (FORMATS section 3).
#pragma once

#include <string>
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

// Names for configurations that are still to be measured: "<stem><number>", numbered on after those that the data have.
// A fraction that is held out by name holds out none of these, however many of them are measured; numbers that it would
// hold out are passed over. Where it leaves no room for them, or goes by time, no name helps.
std::vector<std::string> NamesThatAreFitted(const ValidationSpec& spec, const Measurements& data,
                                            const std::string& stem, int count);

// Configurations with equal joint values, in order of appearance.
std::vector<std::vector<int>> GroupsOfEqualJointValues(const Measurements& data);
// The place of each configuration's group among them.
std::vector<int> GroupsOfConfigurations(const Measurements& data);

}  // namespace sagitta
