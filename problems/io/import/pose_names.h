// The names of poses in the cells of a table: all of them, or before or behind what else they hold.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace sagitta {

// Where in a cell the name of a pose stands: it is all of it, or else what is before one of its separators, or
// behind, or between two.
enum class PoseNameAt { kWhole, kBefore, kBehind, kWithin };

// Parts of a name end at signs that are no letters or digits.
bool SeparatesParts(unsigned char c);

// As names are compared: in small letters, numbers without zeros in front, so that P007 is p7; or as they are written.
std::string Plain(const std::string& name, bool as_written = false);

// A name that may be a pose's, and what else the cell holds.
struct NameInCell {
  std::string name, rest;
};

// The longest first: of P_07_SMR2 {p_7_smr2, p_7, p} or {p_7_smr2, 7_smr2, smr2}. A remark of many parts is whole.
std::vector<NameInCell> NamesIn(const std::string& cell, PoseNameAt at, bool as_written);

// Whatever stands between two separators: of m1_l20 {m1, m1_l20, l20}.
std::set<std::string> PiecesOf(const std::string& text);

}  // namespace sagitta
