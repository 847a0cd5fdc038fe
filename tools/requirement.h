// --require='validation.distance_rms_mm<0.3,fit.rms_mm<0.1': paths in a result JSON.
#pragma once

#include <gflags/gflags_declare.h>

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

DECLARE_string(require);

namespace sagitta {

struct Requirement {
  std::string text;
  std::string path;
  std::string comparison;  // < <= > >= ==
  double bound = 0.0;
};

// Throws InputError for anything that is no requirement.
std::vector<Requirement> ParseRequirements(const std::string& text);

// One sentence for each requirement that is not met. Throws InputError for a
// path that the result does not have or that leads to no number.
std::vector<std::string> UnmetRequirements(const std::vector<Requirement>& requirements,
                                           const nlohmann::ordered_json& result);

// Says each sentence on stderr; the exit status of a command that has done its work.
int EndWith(const std::vector<std::string>& unmet);

}  // namespace sagitta
