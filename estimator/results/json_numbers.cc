#include "estimator/results/json_numbers.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "problems/io/units.h"

namespace sagitta {

namespace {

using Json = nlohmann::ordered_json;

}  // namespace

Json Finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json Millimetres(double metres) {
  return std::isfinite(metres) ? Json(ToUnit(metres, UnitNamed("mm"))) : Json(nullptr);
}

Json Millimetres(const Vector3<double>& metres) {
  return Json::array({Millimetres(metres.x()), Millimetres(metres.y()), Millimetres(metres.z())});
}

}  // namespace sagitta
