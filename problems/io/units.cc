#include "problems/io/units.h"

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

namespace {

// Appends the digits that a text begins with to `whole`; returns how many there are.
std::size_t TakeDigits(std::string_view text, std::uint64_t* whole) {
  std::size_t i = 0;
  for (; i < text.size(); ++i) {
    const auto digit = static_cast<unsigned>(text[i]) - static_cast<unsigned>('0');
    if (digit > 9) break;
    *whole = 10 * *whole + digit;
  }
  return i;
}

// A decimal without exponent, as most cells are: whole / 10^decimals of two numbers that are doubles without loss is
// one division, which is rounded correctly (Clinger 1990). False: it is none, or has more digits.
bool ParseShortDecimal(std::string_view text, double* value) {
  constexpr std::size_t kMostDigits = 18;                     // below 2^64
  constexpr std::uint64_t kLargest = std::uint64_t{1} << 53;  // a double without loss, as 10^22 is
  static constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8, 1e9,
                                       1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18};
  const bool is_negative = !text.empty() && text.front() == '-';
  if (is_negative) text.remove_prefix(1);
  if (text.size() > kMostDigits + 1) return false;
  std::uint64_t whole = 0;
  const std::size_t before = TakeDigits(text, &whole);
  std::size_t decimals = 0;
  if (before < text.size()) {
    if (text[before] != '.') return false;
    decimals = TakeDigits(text.substr(before + 1), &whole);
    if (before + 1 + decimals != text.size()) return false;
  }
  if (before + decimals == 0 || before + decimals > kMostDigits || whole > kLargest) return false;
  const double size = static_cast<double>(whole) / kPowers[decimals];
  *value = is_negative ? -size : size;
  return true;
}

}  // namespace

std::optional<double> ParseNumber(std::string_view text) {
  if (double value = 0.0; ParseShortDecimal(text, &value)) return value;
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
