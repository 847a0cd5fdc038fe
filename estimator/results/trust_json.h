// verdict, cross_validation, suspects and the two intervals of each parameter in estimate.json (FORMATS section 4).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estimator/validation/trust.h"

namespace sagitta {

// estimate: as EstimateToJson wrote it, of the estimate that `trust` judged.
void AddTrustTo(const Estimate& estimate, const Trust& trust, nlohmann::ordered_json* json);

// Of these the model error and the two intervals of each parameter alone.
void AddModelErrorTo(const Estimate& estimate, const Trust& trust, nlohmann::ordered_json* json);

}  // namespace sagitta
