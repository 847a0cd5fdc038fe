// Words that are units: what tables and keys may call them, read or not. One list for hints, for measurement files and
// for foreign tables. All words are in small letters.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace sagitta {

// This project's spelling of a unit that foreign tables are read in: "millimetres" -> mm, "°c" -> degC; "" for others.
std::string SpellingOfUnit(const std::string& word);

// A unit that tables come in, that is not read and that no name ends in by accident: gon, lbf, kgfm, ft_lb.
bool IsUnreadUnit(const std::string& word);

// Either of both, or a short one, which may mean other things as well: g, k, t.
bool IsUnitWord(const std::string& word);

// A column that would be read but for its unit: "fx_kp" where fx_N is listed.
struct ForeignUnit {
  std::string stem, unit;            // fx, kp
  std::vector<std::string> allowed;  // fx_N

  std::string Words() const;
  std::string Hint() const;
};
// Nothing where the name is a listed one in another spelling, or has none of their quantities.
std::optional<ForeignUnit> ForeignUnitOf(const std::string& name, const std::vector<std::string>& listed);

}  // namespace sagitta
