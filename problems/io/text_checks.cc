#include "problems/io/text_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "problems/io/files.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

constexpr std::string_view kFormulaStarts = "=+-@\t\r";

// Bytes that no reader of tables mistakes for anything else.
constexpr std::array<bool, 256> PlainBytes() {
  std::array<bool, 256> plain = {};
  for (const char c : std::string_view("0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz._")) {
    plain[static_cast<unsigned char>(c)] = true;
  }
  return plain;
}
constexpr std::array<bool, 256> kIsPlain = PlainBytes();

// Where a cell that stands as it is ends that begins at `at`: of plain bytes alone, as most are, or a negative decimal.
// What follows is no comma: it may be none.
size_t EndOfPlainCell(std::string_view cells, size_t at) {
  constexpr size_t kFinite = 300;  // digits: with many more it is infinite
  if (at == cells.size() || cells[at] != '-') {
    while (at < cells.size() && kIsPlain[static_cast<unsigned char>(cells[at])]) ++at;
    return at;
  }
  size_t digits = 0, points = 0, end = at + 1;
  for (; end < cells.size() && (cells[end] == '.' || (cells[end] >= '0' && cells[end] <= '9')); ++end) {
    ++(cells[end] == '.' ? points : digits);
  }
  return digits > 0 && digits <= kFinite && points <= 1 ? end : at;
}

// C1 in UTF-8 is C2 80 to C2 9F.
bool IsC1(std::string_view text, size_t i) {
  return text[i] == '\xC2' && i + 1 < text.size() && (text[i + 1] & 0xE0) == 0x80;
}

bool IsControl(std::string_view text, size_t i) {
  const auto byte = static_cast<unsigned char>(text[i]);
  return byte < 0x20 || byte == 0x7F || IsC1(text, i);
}

}  // namespace

size_t FindControlCharacter(std::string_view text) {
  for (size_t i = 0; i < text.size(); ++i) {
    if (IsControl(text, i)) return i;
  }
  return std::string_view::npos;
}

std::string NameOfControlCharacter(std::string_view text, size_t at) {
  return fmt::format("U+{:04X}", static_cast<unsigned char>(text[IsC1(text, at) ? at + 1 : at]));
}

std::string Printable(std::string_view text, bool keep_lines) {
  std::string printable;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (!IsControl(text, i) || (keep_lines && (c == '\n' || c == '\t'))) {
      printable += c;
    } else if (c == '\n' || c == '\t') {
      printable += c == '\n' ? "\\n" : "\\t";
    } else {
      if (IsC1(text, i)) ++i;
      printable += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i]));
    }
  }
  return printable;
}

std::string ValidUtf8(const std::string& text) {
  if (LineOfInvalidUtf8(text) == 0) return text;
  std::string valid;
  for (size_t i = 0; i < text.size();) {
    size_t length = 4;
    while (length > 0 && (i + length > text.size() || LineOfInvalidUtf8(text.substr(i, length)) != 0)) --length;
    valid += length > 0 ? text.substr(i, length) : "\xEF\xBF\xBD";
    i += length > 0 ? length : 1;
  }
  return valid;
}

std::string CsvCell(const std::string& text) {
  const size_t first = text.find_first_not_of('\'');
  const bool is_formula = first != std::string::npos && first + 1 < text.size() &&
                          kFormulaStarts.find(text[first]) != std::string_view::npos &&
                          !(first == 0 && ParseNumber(text));
  const std::string cell = is_formula ? "'" + text : text;
  const bool has_blank_ends = !cell.empty() && (cell.front() == ' ' || cell.back() == ' ');
  if (cell.find_first_of(",\"\n\r") == std::string::npos && cell.find('#') != 0 && !has_blank_ends) return cell;
  std::string quoted = "\"";
  for (const char c : cell) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

void AddCsvCell(std::string_view text, std::string* line) {
  if (!AddCsvCells(text, 1, line)) *line += CsvCell(std::string(text));
}

bool AddCsvCells(std::string_view cells, size_t count, std::string* line) {
  size_t commas = 0, end = EndOfPlainCell(cells, 0);
  for (; end < cells.size() && cells[end] == ','; ++commas) end = EndOfPlainCell(cells, end + 1);
  if (end < cells.size() || commas + 1 != count) return false;
  *line += cells;
  return true;
}

std::string UnguardedCell(std::string cell) {
  if (cell.empty() || cell[0] != '\'') return cell;
  const size_t first = cell.find_first_not_of('\'');
  const bool is_guarded = first != std::string::npos && first + 1 < cell.size() &&
                          kFormulaStarts.find(cell[first]) != std::string_view::npos;
  return is_guarded ? cell.substr(1) : cell;
}

std::string ShellWord(const std::string& word) {
  constexpr const char* kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace sagitta
