// Units at the file edge: the suffixes a quantity may carry, and its SI value.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "models/chain.h"

namespace sagitta {

// si = number * multiplier / divisor. Dividing by 1000 rounds better than
// multiplying by 0.001.
struct Unit {
  const char* suffix;
  double multiplier;
  double divisor;

  double ToSi(double number) const { return number * multiplier / divisor; }
};

enum class Dimension { kLength, kSmallLength, kAngle };

// Where the size of numbers alone says their unit: angles of joints are less in rad (a turn and a bit), coordinates of
// arms are less in m (longer than any arm on its track that one instrument sees). Beyond they are deg, and mm.
constexpr double kMostRadians = 7.0, kMostMetres = 50.0;

// The allowed ones, the usual one first.
const std::vector<Unit>& UnitsOf(Dimension dimension);
const Unit& UnitNamed(const std::string& suffix);

// What people read a joint's values in: deg, or mm where it slides.
struct JointUnit {
  double factor;  // per SI unit
  const char* name;
};
JointUnit UnitOf(const Joint& joint);

// "a_mm, a_m"
std::string NamesWithUnits(const std::string& stem, Dimension dimension);

// A whole text as a finite number; nothing when it is anything else.
std::optional<double> ParseNumber(std::string_view text);

// The shortest number in the unit that reads back to the SI value, to the last
// bit where there is one.
double ToUnit(double si, const Unit& unit);

}  // namespace sagitta
