#include "models/quantity.h"

namespace sagitta {

const QuantityTraits& TraitsOf(Quantity quantity) {
  constexpr double kDegree = 3.14159265358979323846 / 180.0;
  // 5 mm, 5 mrad, 10 urad/Nm; ten typical sizes for the rest.
  static const QuantityTraits kLength{"mm", 1e-3, 5e-3, 1e-3};
  static const QuantityTraits kAngle{"deg", kDegree, 5e-3, 1e-3};
  static const QuantityTraits kRotationVector{"mrad", 1e-3, 5e-3, 1e-3};
  static const QuantityTraits kCompliance{"urad/Nm", 1e-6, 1e-5, 0.0};
  static const QuantityTraits kLinearCompliance{"um/N", 1e-6, 1e-5, 0.0};
  static const QuantityTraits kSpringRate{"N/mm", 1e3, 1e6, 0.0};
  switch (quantity) {
    case Quantity::kLength:
      return kLength;
    case Quantity::kAngle:
      return kAngle;
    case Quantity::kRotationVector:
      return kRotationVector;
    case Quantity::kCompliance:
      return kCompliance;
    case Quantity::kLinearCompliance:
      return kLinearCompliance;
    case Quantity::kSpringRate:
      return kSpringRate;
  }
  return kLength;
}

}  // namespace sagitta
