// Experiment files (sagitta/experiment/1, FORMATS section 3).
#pragma once

#include <string>

#include "problems/experiment.h"

namespace sagitta {

// Throws InputError. Paths inside are made relative to the working directory.
Experiment ReadExperimentFile(const std::string& path);
// The same of text that was read; `path`: what messages call it, and what the paths inside are relative to.
Experiment ReadExperimentText(const std::string& text, const std::string& path);

// The keys of such a file other than schema, robot and measurements: what is stated of data that come in another way.
Experiment ReadExperimentSettings(const std::string& text, const std::string& file_in_messages);

}  // namespace sagitta
