// Numbers of result files.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "models/geometry.h"

namespace sagitta {

// null where it is not known (infinite or not a number).
nlohmann::ordered_json Finite(double value);

// A length in m, and a triple of them, in mm; null where it is not known.
nlohmann::ordered_json Millimetres(double metres);
nlohmann::ordered_json Millimetres(const Vector3<double>& metres);

}  // namespace sagitta
