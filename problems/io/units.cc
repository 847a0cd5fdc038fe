#include "problems/io/units.h"

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "models/constants.h"
#include "problems/text.h"

namespace sagitta {

const std::vector<Unit>& UnitsOf(Dimension dimension) {
  static const std::vector<Unit> lengths = {{"mm", 1.0, 1e3}, {"m", 1.0, 1.0}};
  static const std::vector<Unit> small_lengths = {{"um", 1.0, 1e6}, {"mm", 1.0, 1e3}, {"m", 1.0, 1.0}};
  static const std::vector<Unit> angles = {
      {"deg", kDegree, 1.0}, {"rad", 1.0, 1.0}, {"mrad", 1.0, 1e3}, {"urad", 1.0, 1e6}};
  if (dimension == Dimension::kAngle) return angles;
  return dimension == Dimension::kLength ? lengths : small_lengths;
}

namespace {

// Of foreign tables alone, our own files have neither. An inch is 25.4 mm exactly (agreement of 1959).
const std::vector<Unit>& ForeignLengths() {
  static const std::vector<Unit> lengths = {{"cm", 1.0, 1e2}, {"in", 25.4, 1e3}};
  return lengths;
}

}  // namespace

const Unit& UnitNamed(const std::string& suffix) {
  for (const Unit& unit : ForeignLengths()) {
    if (suffix == unit.suffix) return unit;
  }
  for (const Dimension dimension : {Dimension::kSmallLength, Dimension::kAngle}) {
    for (const Unit& unit : UnitsOf(dimension)) {
      if (suffix == unit.suffix) return unit;
    }
  }
  throw std::logic_error("no unit is called '" + suffix + "'");
}

JointUnit UnitOf(const Joint& joint) {
  return joint.type == JointType::kRevolute ? JointUnit{1.0 / kDegree, "deg"} : JointUnit{1e3, "mm"};
}

std::string NamesWithUnits(const std::string& stem, Dimension dimension) {
  std::vector<std::string> names;
  for (const Unit& unit : UnitsOf(dimension)) names.push_back(stem + "_" + unit.suffix);
  return Joined(names);
}

std::optional<double> ParseNumber(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

double ToUnit(double si, const Unit& unit) {
  const double exact = si / unit.multiplier * unit.divisor;
  for (const int digits : {15, 16, 17}) {
    char buffer[64];
    const auto result = std::to_chars(buffer, buffer + sizeof(buffer), exact, std::chars_format::general, digits);
    const std::optional<double> shorter = ParseNumber(std::string_view(buffer, result.ptr - buffer));
    if (shorter && unit.ToSi(*shorter) == si) return *shorter;
  }
  return exact;
}

}  // namespace sagitta
