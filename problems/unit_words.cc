#include "problems/unit_words.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "problems/input_error.h"
#include "problems/text.h"

namespace sagitta {
namespace {

const std::map<std::string, std::string>& SpellingsOfUnits() {
  static const std::map<std::string, std::string> kWords = {
      {"mm", "mm"},       {"millimeter", "mm"}, {"millimeters", "mm"}, {"millimetre", "mm"}, {"millimetres", "mm"},
      {"m", "m"},         {"meter", "m"},       {"meters", "m"},       {"metre", "m"},       {"metres", "m"},
      {"um", "um"},       {"µm", "um"},         {"μm", "um"},          {"micron", "um"},     {"microns", "um"},
      {"cm", "cm"},       {"centimeter", "cm"}, {"centimeters", "cm"}, {"centimetre", "cm"}, {"centimetres", "cm"},
      {"in", "in"},       {"inch", "in"},       {"inches", "in"},      {"deg", "deg"},       {"degree", "deg"},
      {"degrees", "deg"}, {"°", "deg"},         {"rad", "rad"},        {"radian", "rad"},    {"radians", "rad"},
      {"mrad", "mrad"},   {"urad", "urad"},     {"µrad", "urad"},      {"s", "s"},           {"sec", "s"},
      {"seconds", "s"},   {"degc", "degC"},     {"°c", "degC"},        {"c", "degC"},        {"celsius", "degC"},
      {"n", "N"},         {"nm", "Nm"},         {"kg", "kg"}};
  return kWords;
}

const std::set<std::string>& UnreadUnits() {
  static const std::set<std::string> kWords = {
      "ft",         "foot", "feet", "yd",      "mil",    "mils", "thou",  "km",     "gon",    "gons",   "grad",
      "grads",      "rev",  "revs", "turns",   "counts", "incr", "ticks", "arcmin", "arcsec", "degs",   "kp",
      "kilopond",   "kgf",  "gf",   "tf",      "lb",     "lbs",  "lbf",   "oz",     "ozf",    "kn",     "dan",
      "dyn",        "mn",   "mnm",  "knm",     "nmm",    "ncm",  "danm",  "degf",   "degr",   "degk",   "kelvin",
      "fahrenheit", "°f",   "°k",   "rankine", "ms",     "us",   "msec",  "usec",   "hours",  "minutes"};
  return kWords;
}

// Units of force times units of length, in either order: a moment.
bool IsMoment(const std::string& word) {
  static const std::set<std::string> kForces = {"kgf", "kg", "kp", "gf", "tf", "lb", "lbs", "lbf", "oz", "ozf", "kn"};
  static const std::set<std::string> kLengths = {"m", "cm", "mm", "in", "inch", "ft"};
  std::string letters;
  std::copy_if(word.begin(), word.end(), std::back_inserter(letters),
               [](char c) { return std::string("_-.* ").find(c) == std::string::npos; });
  for (size_t i = 1; i < letters.size(); ++i) {
    const std::string one = letters.substr(0, i), other = letters.substr(i);
    if (kForces.count(one) + kLengths.count(other) == 2 || kLengths.count(one) + kForces.count(other) == 2) return true;
  }
  return false;
}

// What follows the stem, without brackets and bars: "kp" of "fx_kp" and "fx [kp]".
std::string AfterStem(const std::string& name, const std::string& stem) {
  static const std::string kBetween = " _-.[]()/";
  if (name.size() < stem.size() + 2 || name.compare(0, stem.size(), stem) != 0) return "";
  if (kBetween.find(name[stem.size()]) == std::string::npos) return "";
  const size_t first = name.find_first_not_of(kBetween, stem.size()), last = name.find_last_not_of(kBetween);
  return first == std::string::npos ? "" : name.substr(first, last - first + 1);
}

// What one quantity alone is called, and the short units that it alone has.
struct OwnWords {
  std::string abbreviation;
  std::set<std::string> units;
};

const OwnWords& OwnWordsOf(const std::string& stem) {
  static const std::map<std::string, OwnWords> kWords = {{"temperature", {"temp", {"f", "r"}}},
                                                         {"time", {"", {"m", "min", "h", "d"}}}};
  static const OwnWords kNone;
  const auto found = kWords.find(stem);
  return found == kWords.end() ? kNone : found->second;
}

}  // namespace

std::string SpellingOfUnit(const std::string& word) {
  const auto found = SpellingsOfUnits().find(word);
  return found == SpellingsOfUnits().end() ? "" : found->second;
}

bool IsUnreadUnit(const std::string& word) { return UnreadUnits().count(word) > 0 || IsMoment(word); }

bool IsUnitWord(const std::string& word) {
  static const std::set<std::string> kShort = {"g", "t", "k"};
  return !SpellingOfUnit(word).empty() || IsUnreadUnit(word) || kShort.count(word) > 0;
}

std::string ForeignUnit::Words() const { return "'" + unit + "' is no unit that " + stem + " is read in"; }

std::string ForeignUnit::Hint() const {
  return "convert the values; column" + std::string(allowed.size() == 1 ? " '" : "s '") + Joined(allowed, "', '") + "'";
}

std::optional<ForeignUnit> ForeignUnitOf(const std::string& name, const std::vector<std::string>& listed) {
  const std::string lower = LowerCaseOf(name);
  ForeignUnit foreign;
  for (const std::string& candidate : listed) {
    if (NameDistance(name, candidate) == 0) return std::nullopt;
    const size_t bar = candidate.rfind('_');
    if (bar == std::string::npos) continue;
    const std::string stem = candidate.substr(0, bar);
    const OwnWords& own = OwnWordsOf(stem);
    std::string unit = AfterStem(lower, stem);
    if (unit.empty() && !own.abbreviation.empty()) unit = AfterStem(lower, own.abbreviation);
    if (!IsUnitWord(unit) && own.units.count(unit) == 0) continue;
    foreign.stem = stem;
    foreign.unit = name.substr(lower.rfind(unit), unit.size());
    foreign.allowed.push_back(candidate);
  }
  if (foreign.allowed.empty()) return std::nullopt;
  return foreign;
}

}  // namespace sagitta
