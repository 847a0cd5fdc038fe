// How intervals came about by refits, or why the model's stand.
#pragma once

#include <string>

#include "estimator/estimate/estimate.h"

namespace sagitta {

// Of a bootstrap with its report; configurations: that were drawn from.
std::string BootstrapInWords(const IntervalReport& report, int configurations);
std::string BootstrapRefused(int failed, int replicates);
std::string ProfileInWords(int open_ends);
std::string ProfileRefused();
std::string ProfileFindsBetterFit();

}  // namespace sagitta
