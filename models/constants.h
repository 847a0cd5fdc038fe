// Numbers that every layer uses.
#pragma once

#include <limits>

namespace sagitta {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180.0;  // rad
inline constexpr double kMillimetre = 1e-3;     // m
inline constexpr double kMillimetresPerMetre = 1e3;
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();  // "-" where it is read
inline constexpr double kMicro = 1e-6;                                         // of m or rad
inline constexpr double kStandardGravity = 9.80665;                            // m/s^2 (CGPM 1901)

}  // namespace sagitta
