// Kinds of scalar unknowns: their units in results and the limits that decide
// what data can determine (FORMATS section 4).
#pragma once

#include <string>

namespace sagitta {

enum class Quantity {
  kLength,
  kAngle,
  kRotationVector,
  kCompliance,        // rad/(N m)
  kLinearCompliance,  // m/N
  kSpringRate,        // N/m
  kSmallAngle,        // rad, stated in urad
  kHardening,         // rad/(N m)^3
  kRatio,             // 1, stated in ppm
  kMass,              // kg
  kFirstMoment,       // kg m
  kDrift,             // m/s
  kTurnRate,          // rad/s
  kGrowth,            // 1/K
  kShift,             // m, stated in um
  kCurvature,         // rad/m
  kCount,             // how many there are; no quantity itself
};

// How a quantity is written, and when it counts as held or weak.
struct QuantityTraits {
  const char* unit;    // in results
  double si_per_unit;  // SI value of one unit
  double hold_limit;   // SI; a direction whose sigma exceeds it is unidentifiable
  double weak_limit;   // SI; known worse than this is "weak"; 0: worse than half its value
};

// The traits of a quantity.
const QuantityTraits& TraitsOf(Quantity quantity);

// SI value of one unit of results ("mm", "urad/Nm"); 0 for an unknown unit.
double SiPerUnit(const std::string& unit);

}  // namespace sagitta
