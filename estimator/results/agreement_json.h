// What estimate.json says of the agreement between parts of the data.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estimator/estimate/agreement_report.h"

namespace sagitta {

// null where nothing was compared.
nlohmann::ordered_json AgreementToJson(const AgreementReport& report);

}  // namespace sagitta
