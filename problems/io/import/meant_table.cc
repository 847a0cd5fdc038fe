#include "problems/io/import/meant_table.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include "problems/input_error.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/mapped_columns.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// A table of a name and three numbers without header.
void NameColumns(TextTable* table) {
  if (table->has_header() || table->columns() != 4 || table->rows.empty()) return;
  const std::vector<std::string>& cells = table->rows[0].cells;
  const bool are_points = !table->Number(cells[0]) && table->Number(cells[1]) && table->Number(cells[2]);
  if (!are_points || !table->Number(cells[3])) return;
  table->header = {"name", "x", "y", "z"};
  table->header_line = table->rows[0].line;
  table->guesses.push_back("there is no header: the columns are a name and x, y, z");
}

int ColumnOfHeader(const TextTable& table, const std::string& text) {
  const auto found = std::find(table.header.begin(), table.header.end(), text);
  return !table.has_header() || found == table.header.end() ? -1 : static_cast<int>(found - table.header.begin());
}

// The columns that --map names: one, or the two of a sum or difference; empty where this table has not all of them.
std::vector<int> ColumnsOfHeaders(const TextTable& table, const std::string& text) {
  const int whole = ColumnOfHeader(table, text);
  if (whole >= 0) return {whole};
  for (size_t at = 1; at < text.size(); ++at) {
    if (text[at] != '+' && text[at] != '-') continue;
    const int first = ColumnOfHeader(table, text.substr(0, at)), second = ColumnOfHeader(table, text.substr(at + 1));
    if (first >= 0 && second >= 0) return {first, second};
  }
  return {};
}

// The number behind the letters of q3, tau3, approach3, from 0.
std::optional<int> IndexBehind(const std::string& stem, const std::string& letters) {
  const std::string number = stem.size() > letters.size() ? stem.substr(letters.size()) : "";
  const bool is_number = std::all_of(number.begin(), number.end(), [](unsigned char c) { return std::isdigit(c); });
  if (stem.rfind(letters, 0) != 0 || number.empty() || !is_number || number.size() > 3) return std::nullopt;
  return std::stoi(number) - 1;
}

// What a column of measurements.csv is.
ColumnMeaning MeaningOfOurs(const std::string& column) {
  static const std::map<std::string, Role> kRoles = {{"time", Role::kTime}, {"temperature", Role::kTemperature}};
  static const std::vector<std::pair<std::string, Role>> kNumbered = {
      {"q", Role::kJoint}, {"tau", Role::kTorque}, {"approach", Role::kApproach}};
  static const std::vector<std::pair<std::string, Role>> kOfAxes = {
      {"", Role::kPoint}, {"sigma_", Role::kSigma}, {"r", Role::kRotation}, {"sigma_r", Role::kAngleSigma}};
  ColumnMeaning meaning;
  meaning.is_mapped = true;
  const auto [stem, unit] = StemAndUnit(column);
  meaning.unit = unit;
  for (const auto& [letters, role] : kNumbered) {
    const std::optional<int> index = IndexBehind(stem, letters);
    if (index) meaning.role = role, meaning.index = *index;
  }
  for (const auto& [before, role] : kOfAxes) {
    for (int axis = 0; axis < 3; ++axis) {
      if (stem == before + "xyz"[axis]) meaning.role = role, meaning.index = axis, meaning.says_measured = true;
    }
  }
  static const std::vector<std::pair<std::vector<std::string>, Role>> kListed = {
      {{"ow", "ox", "oy", "oz"}, Role::kQuaternion}, {WrenchNames(), Role::kWrench}};
  for (const auto& [names, role] : kListed) {
    const auto found = std::find(names.begin(), names.end(), stem);
    if (found != names.end()) meaning.role = role, meaning.index = static_cast<int>(found - names.begin());
  }
  const auto known = kRoles.find(stem);
  if (known != kRoles.end()) meaning.role = known->second;
  if (meaning.role != Role::kOther) return meaning;
  meaning.role = Role::kText;
  meaning.name = stem;
  return meaning;
}

// Of one column, or of a sum or difference.
bool AreColumnNumbers(const std::string& text) { return text.find_first_not_of("0123456789+-") == std::string::npos; }

}  // namespace

bool MeantTable::Has(Role role) const {
  return std::any_of(meanings.begin(), meanings.end(), [role](const auto& each) { return each.role == role; });
}

int MeantTable::Find(const ColumnMeaning& other) const {
  const auto same = std::find_if(meanings.begin(), meanings.end(), [&](const ColumnMeaning& each) {
    return each.role == other.role && each.index == other.index && each.name == other.name;
  });
  return same == meanings.end() ? -1 : static_cast<int>(same - meanings.begin());
}

bool MayName(const ColumnMeaning& meaning) {
  return meaning.role == Role::kText || (meaning.role == Role::kOther && meaning.unit.empty());
}

bool IsOfPoint(Role role) {
  return role == Role::kPoint || role == Role::kTarget || role == Role::kDifference || role == Role::kRotation ||
         role == Role::kQuaternion || role == Role::kAngleSigma;
}

bool HoldsPoints(const MeantTable& meant) {
  for (int c = 0; c < static_cast<int>(meant.meanings.size()); ++c) {
    const Role role = meant.meanings[static_cast<size_t>(c)].role;
    if (role != Role::kPoint && role != Role::kDifference) continue;
    for (size_t r = 0; r < meant.table.rows.size(); ++r) {
      if (!IsLostCell(meant.Cell(r, c))) return true;
    }
  }
  return false;
}

MeantTable Meant(TextTable table, const std::vector<Joint>& joints, const std::map<std::string, std::string>& columns) {
  NameColumns(&table);
  MeantTable meant{std::move(table), {}};
  if (!meant.table.has_header()) return meant;
  meant.meanings = MeaningsOf(meant.table.header, joints);
  for (const auto& [column, text] : columns) {
    for (const int c : ColumnsOfHeaders(meant.table, text))
      meant.meanings[static_cast<size_t>(c)] = MeaningOfOurs(column);
  }
  return meant;
}

void CheckMappedHeaders(const std::vector<MeantTable>& tables, const std::map<std::string, std::string>& columns) {
  std::vector<std::string> headers;
  for (const MeantTable& each : tables)
    headers.insert(headers.end(), each.table.header.begin(), each.table.header.end());
  for (const auto& [column, text] : columns) {
    const auto has = [&text = text](const MeantTable& each) { return !ColumnsOfHeaders(each.table, text).empty(); };
    if (AreColumnNumbers(text) || std::any_of(tables.begin(), tables.end(), has)) continue;
    throw InputError({"", 0, "--map"}, "there is no column '" + text + "' in any of the files",
                     SpellingHint(text, headers));
  }
}

}  // namespace sagitta
