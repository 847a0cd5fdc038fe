// The key `prior` of an experiment file, which only the diagnosis reads.
#pragma once

#include <string>

#include "problems/io/yaml_reader.h"
#include "problems/prior_masses.h"

namespace sagitta {

PriorMasses ReadPriorMasses(const YamlValue& value);

// Of an experiment file; as they are by default where it does not say, or there is no file ("").
PriorMasses ReadDiagnosisPrior(const std::string& experiment_file);
// The same of its text.
PriorMasses ReadDiagnosisPriorText(const std::string& text, const std::string& file_in_messages);

}  // namespace sagitta
