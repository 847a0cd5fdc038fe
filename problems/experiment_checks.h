// Numbers of an experiment, whoever made it: a file, a program that links the library, Python, flags.
#pragma once

#include "problems/experiment.h"

namespace sagitta {

// Throws InputError at the key whose value is out of range (problems/range.h), with its line where the experiment is a
// file. What only robot and data show to be wrong: problems/problem_checks.h.
void CheckExperiment(const Experiment& experiment);

}  // namespace sagitta
