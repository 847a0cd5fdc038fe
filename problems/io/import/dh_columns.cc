#include "problems/io/import/dh_columns.h"

#include <algorithm>
#include <map>
#include <set>

#include "problems/input_error.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/mapped_columns.h"
#include "problems/io/pattern.h"
#include "problems/text.h"

namespace sagitta {
namespace {

const std::map<std::string, DhColumn>& Names() {
  static const std::map<std::string, DhColumn> kNames = {{"a", DhColumn::kA},
                                                         {"r", DhColumn::kR},
                                                         {"length", DhColumn::kA},
                                                         {"link length", DhColumn::kA},
                                                         {"alpha", DhColumn::kAlpha},
                                                         {"α", DhColumn::kAlpha},
                                                         {"twist", DhColumn::kAlpha},
                                                         {"link twist", DhColumn::kAlpha},
                                                         {"d", DhColumn::kD},
                                                         {"link offset", DhColumn::kD},
                                                         {"theta", DhColumn::kTheta},
                                                         {"θ", DhColumn::kTheta},
                                                         {"joint angle", DhColumn::kTheta},
                                                         {"q", DhColumn::kTheta},
                                                         {"theta offset", DhColumn::kThetaOffset},
                                                         {"θ offset", DhColumn::kThetaOffset},
                                                         {"offset", DhColumn::kOffset},
                                                         {"joint offset", DhColumn::kOffset},
                                                         {"q offset", DhColumn::kOffset},
                                                         {"beta", DhColumn::kBeta},
                                                         {"β", DhColumn::kBeta},
                                                         {"joint", DhColumn::kName},
                                                         {"link", DhColumn::kName},
                                                         {"axis", DhColumn::kName},
                                                         {"name", DhColumn::kName},
                                                         {"j", DhColumn::kName},
                                                         {"i", DhColumn::kName},
                                                         {"nr", DhColumn::kName},
                                                         {"no", DhColumn::kName},
                                                         {"achse", DhColumn::kName},
                                                         {"kinematics", DhColumn::kName},
                                                         {"type", DhColumn::kType},
                                                         {"joint type", DhColumn::kType},
                                                         {"sigma", DhColumn::kType},
                                                         {"sign", DhColumn::kSign},
                                                         {"direction", DhColumn::kSign},
                                                         {"min", DhColumn::kMin},
                                                         {"lower", DhColumn::kMin},
                                                         {"lower limit", DhColumn::kMin},
                                                         {"min limit", DhColumn::kMin},
                                                         {"limit min", DhColumn::kMin},
                                                         {"theta min", DhColumn::kMin},
                                                         {"qmin", DhColumn::kMin},
                                                         {"q min", DhColumn::kMin},
                                                         {"max", DhColumn::kMax},
                                                         {"upper", DhColumn::kMax},
                                                         {"upper limit", DhColumn::kMax},
                                                         {"max limit", DhColumn::kMax},
                                                         {"limit max", DhColumn::kMax},
                                                         {"theta max", DhColumn::kMax},
                                                         {"qmax", DhColumn::kMax},
                                                         {"q max", DhColumn::kMax}};
  return kNames;
}

std::string Spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

bool BeginsWithOneOf(const std::string& name, const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    const bool begins = name.compare(0, word.size(), word) == 0;
    return begins && (name.size() == word.size() || name[word.size()] == ' ');
  });
}

// Words of kinematics that a row of a, alpha, d, theta has no place for.
bool IsOfKinematics(const std::string& name) {
  static const std::vector<std::string> kWords = {
      "coupling", "coupled", "mimic",    "driver",   "b",     "gamma", "phi",   "psi",    "dx",     "dy",
      "dz",       "rx",      "ry",       "rz",       "delta", "da",    "dd",    "dalpha", "dtheta", "dbeta",
      "flip",     "invert",  "inverted", "reversed", "base",  "tool",  "scale", "sense"};
  return BeginsWithOneOf(name, kWords);
}

// Lengths and angles that are none of the kinematics.
bool IsOfNoKinematics(const std::string& name) {
  static const std::vector<std::string> kWords = {"home",       "rest",     "reach",  "range",  "working range",
                                                  "com",        "cog",      "center", "centre", "repeatability",
                                                  "resolution", "backlash", "stroke"};
  return BeginsWithOneOf(name, kWords);
}

bool IsZeroOrNone(const std::string& cell, bool decimal_comma) {
  const std::optional<TypedNumber> number = ParseTypedNumber(cell, decimal_comma);
  return IsLostCell(cell) || (number && number->value == 0.0);
}

// The row in which a column that is not known says something, nullptr where there is none.
const TextTable::Row* RowThatMatters(const TextTable& table, size_t c) {
  const std::string name = Spaced(NameWithoutUnit(table.header[c])), unit = UnitInHeader(table.header[c]);
  const bool has_unit = IsLengthUnit(unit) || IsAngleUnit(unit);
  if (IsOfNoKinematics(name) || (!IsOfKinematics(name) && !has_unit)) return nullptr;
  for (const TextTable::Row& row : table.rows) {
    const std::string& cell = row.cells[c];
    const bool counts = IsOfKinematics(name) || ParseTypedNumber(cell, table.decimal_comma);
    if (counts && !IsZeroOrNone(cell, table.decimal_comma)) return &row;
  }
  return nullptr;
}

void CheckNotTwice(const TextTable& table, const std::vector<DhColumn>& columns, size_t c) {
  static const std::set<DhColumn> kOnce = {DhColumn::kA,    DhColumn::kR,    DhColumn::kAlpha, DhColumn::kD,
                                           DhColumn::kBeta, DhColumn::kType, DhColumn::kSign};
  const auto end = columns.begin() + static_cast<long>(c);
  const auto is_same = [&](DhColumn other) {
    return other == columns[c] || (other == DhColumn::kA && columns[c] == DhColumn::kR) ||
           (other == DhColumn::kR && columns[c] == DhColumn::kA);
  };
  const auto before = std::find_if(columns.begin(), end, is_same);
  if (before == end || kOnce.count(columns[c]) == 0) return;
  throw InputError({table.path, table.header_line, table.header[c]},
                   "the columns '" + table.header[static_cast<size_t>(before - columns.begin())] + "' and '" +
                       table.header[c] + "' mean the same",
                   "one of them is expected");
}

}  // namespace

bool IsLength(DhColumn column) { return column == DhColumn::kA || column == DhColumn::kR || column == DhColumn::kD; }
bool IsAngle(DhColumn column) {
  return column == DhColumn::kAlpha || column == DhColumn::kTheta || column == DhColumn::kBeta ||
         column == DhColumn::kOffset || column == DhColumn::kThetaOffset;
}

DhColumn ColumnOf(const std::string& header, bool* is_previous) {
  std::string name = NameWithoutUnit(header);
  const std::regex previous = MakePattern(R"([_ ]*[\{\(]?[ij_ n]*-+ *1[\}\)]?$)");
  const std::regex index = MakePattern(R"([_ ]*[\{\(]?(i|j|n)[\}\)]?$)");
  *is_previous = SearchPattern(name, previous) && ReplacePattern(name, previous, "") != name;
  name = ReplacePattern(name, previous, "");
  auto found = Names().find(Spaced(name));
  if (found == Names().end()) found = Names().find(Spaced(ReplacePattern(name, index, "")));
  return found == Names().end() ? DhColumn::kOther : found->second;
}

bool IsDhHeader(const std::vector<std::string>& header) {
  std::set<DhColumn> columns;
  bool ignored = false;
  for (const std::string& name : header) columns.insert(ColumnOf(name, &ignored));
  return columns.count(DhColumn::kA) + columns.count(DhColumn::kR) > 0 && columns.count(DhColumn::kAlpha) &&
         columns.count(DhColumn::kD);
}

bool SetLengths(bool is_khalil, std::vector<DhColumn>* columns) {
  const bool has_r = std::count(columns->begin(), columns->end(), DhColumn::kR) > 0;
  if (!has_r) return false;
  for (DhColumn& column : *columns) {
    if (column == DhColumn::kD && is_khalil) {
      column = DhColumn::kA;
    } else if (column == DhColumn::kR) {
      column = is_khalil ? DhColumn::kD : DhColumn::kA;
    }
  }
  return true;
}

std::vector<DhColumn> DhColumnsOf(const TextTable& table, bool* has_previous) {
  std::vector<DhColumn> columns;
  for (size_t c = 0; c < table.header.size(); ++c) {
    bool previous = false;
    const bool counts_rows = c == 0 && table.header[c].empty();
    columns.push_back(counts_rows ? DhColumn::kName : ColumnOf(table.header[c], &previous));
    *has_previous |= previous;
    CheckNotTwice(table, columns, c);
    const TextTable::Row* row = columns[c] == DhColumn::kOther ? RowThatMatters(table, c) : nullptr;
    if (!row) continue;
    throw InputError({table.path, row->line, table.header[c]},
                     "a row of a, alpha, d and theta has no place for '" + row->cells[c] + "' of this column",
                     "columns that are read: a, alpha, d, theta, beta, offset, joint, type, sign, min, max; remove the "
                     "column where it does not describe how the robot moves");
  }
  return columns;
}

std::string ColumnsNotRead(const TextTable& table, const std::vector<DhColumn>& columns) {
  std::vector<std::string> names;
  for (size_t c = 0; c < columns.size(); ++c) {
    if (columns[c] != DhColumn::kOther) continue;
    names.push_back(table.header[c].empty() ? std::to_string(c + 1) : "'" + table.header[c] + "'");
  }
  return Joined(names);
}

}  // namespace sagitta
