#include "models/quantity.h"

#include "models/constants.h"

namespace sagitta {

const QuantityTraits& TraitsOf(Quantity quantity) {
  // 5 mm, 5 mrad, 10 urad/Nm; ten typical sizes for the rest.
  static const QuantityTraits kLength{"mm", 1e-3, 5e-3, 1e-3};
  static const QuantityTraits kAngle{"deg", kDegree, 5e-3, 1e-3};
  static const QuantityTraits kRotationVector{"mrad", 1e-3, 5e-3, 1e-3};
  static const QuantityTraits kCompliance{"urad/Nm", 1e-6, 1e-5, 0.0};
  static const QuantityTraits kLinearCompliance{"um/N", 1e-6, 1e-5, 0.0};
  static const QuantityTraits kSpringRate{"N/mm", 1e3, 1e6, 0.0};
  static const QuantityTraits kSmallAngle{"urad", 1e-6, 1e-3, 0.0};
  static const QuantityTraits kHardening{"urad/kNm3", 1e-15, 1e-14, 0.0};
  static const QuantityTraits kRatio{"ppm", 1e-6, 2e-3, 0.0};
  static const QuantityTraits kMass{"kg", 1.0, 200.0, 0.0};
  static const QuantityTraits kFirstMoment{"kgm", 1.0, 100.0, 0.0};
  static const QuantityTraits kDrift{"um/h", 1e-6 / 3600.0, 5e-4 / 3600.0, 0.0};
  static const QuantityTraits kTurnRate{"urad/h", 1e-6 / 3600.0, 2e-4 / 3600.0, 0.0};
  static const QuantityTraits kGrowth{"ppm/K", 1e-6, 2e-4, 0.0};
  static const QuantityTraits kCurvature{"urad/m", 1e-6, 1e-3, 0.0};
  static const QuantityTraits kShift{"um", 1e-6, 5e-3, 0.0};
  switch (quantity) {
    case Quantity::kSmallAngle:
      return kSmallAngle;
    case Quantity::kHardening:
      return kHardening;
    case Quantity::kRatio:
      return kRatio;
    case Quantity::kMass:
      return kMass;
    case Quantity::kFirstMoment:
      return kFirstMoment;
    case Quantity::kDrift:
      return kDrift;
    case Quantity::kTurnRate:
      return kTurnRate;
    case Quantity::kGrowth:
      return kGrowth;
    case Quantity::kShift:
      return kShift;
    case Quantity::kCurvature:
      return kCurvature;
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
    case Quantity::kCount:
      break;
  }
  return kLength;
}

double SiPerUnit(const std::string& unit) {
  for (int i = 0; i < static_cast<int>(Quantity::kCount); ++i) {
    const QuantityTraits& traits = TraitsOf(static_cast<Quantity>(i));
    if (unit == traits.unit) return traits.si_per_unit;
  }
  return 0.0;
}

}  // namespace sagitta
