// Kinds of scalar unknowns: their units in results and the limits that decide
// what data can tell (FORMATS section 4).
#pragma once

namespace sagitta {

enum class Quantity {
  kLength,
  kAngle,
  kRotationVector,
  kCompliance,        // rad/(N m)
  kLinearCompliance,  // m/N
  kSpringRate,        // N/m
};

struct QuantityTraits {
  const char* unit;     // in results
  double si_per_unit;   // SI value of one unit
  double hold_limit;    // SI; a direction whose sigma exceeds it is unidentifiable
  double weak_limit;    // SI; known worse than this is "weak"; 0: worse than half its value
};

const QuantityTraits& TraitsOf(Quantity quantity);

}  // namespace sagitta
