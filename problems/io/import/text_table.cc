#include "problems/io/import/text_table.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <string_view>

#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/files.h"
#include "problems/io/import/header_words.h"
#include "problems/io/text_checks.h"
#include "problems/io/trimmed.h"
#include "problems/io/units.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

struct TableLine {
  int number = 0;
  std::string text;
  bool is_comment = false;  // a sign of comments in front, removed
};

// Of text behind its blanks: '#', '%' or "//"; 0: it is no comment.
size_t LengthOfCommentSign(std::string_view text) {
  if (text.substr(0, 2) == "//") return 2;
  return !text.empty() && (text.front() == '#' || text.front() == '%') ? 1 : 0;
}

// Spreadsheets of some countries write U+2212 where a number is negative.
std::string WithPlainMinus(std::string text) {
  constexpr char kMinus[] = "\u2212";
  for (size_t at = text.find(kMinus); at != std::string::npos; at = text.find(kMinus, at)) {
    text.replace(at, sizeof kMinus - 1, "-");
  }
  return text;
}

std::vector<TableLine> LinesOf(const std::string& text) {
  std::vector<TableLine> lines;
  int number = 0;
  for (size_t at = 0; at <= text.size();) {
    CheckInterruption();
    size_t end = text.find_first_of("\r\n", at);
    if (end == std::string::npos) end = text.size();
    ++number;
    // Trailing tabs are empty cells: only leading blanks of the line go.
    TableLine line{number, text.substr(at, end - at)};
    at = end + (text.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    if (Trimmed(line.text, kBlanks).empty()) continue;
    const size_t first = line.text.find_first_not_of(' ');
    if (const size_t sign = LengthOfCommentSign(std::string_view(line.text).substr(first))) {
      line.is_comment = true;
      line.text = line.text.substr(first + sign);
    }
    // Frames drawn around tables: +----+----+
    if (line.text.find_first_not_of("+-=| \t\r") == std::string::npos && line.text.find('-') != std::string::npos &&
        line.text.find("--") != std::string::npos) {
      continue;
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<std::string> SplitAtBlanks(const std::string& text) {
  std::vector<std::string> cells;
  size_t at = text.find_first_not_of(kBlanks);
  while (at != std::string::npos) {
    const size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    std::string cell = text.substr(at, end - at);
    // A unit that stands apart belongs to the name before it: x [mm].
    if (!cells.empty() && (cell[0] == '[' || cell[0] == '(')) {
      cells.back() += cell;
    } else {
      cells.push_back(cell);
    }
    at = text.find_first_not_of(kBlanks, end);
  }
  return cells;
}

std::vector<std::string> Split(const std::string& text, char separator) {
  if (separator == ' ') return SplitAtBlanks(text);
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : text) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  for (std::string& cell : cells) cell = std::string(Trimmed(cell, kBlanks));
  if (separator == '|' && cells.size() > 2 && cells.front().empty()) cells.erase(cells.begin());
  return cells;
}

bool IsNumeric(const std::string& cell) {
  return ParseLocalNumber(cell, false).has_value() || ParseLocalNumber(cell, true).has_value();
}

// Cells with something in them.
size_t CountFilled(const std::vector<std::string>& cells) {
  return std::count_if(cells.begin(), cells.end(), [](const std::string& cell) { return !cell.empty(); });
}

// Half of what it holds are numbers, or three are: a point, with the names of a collection, a group and its own.
bool HoldsNumbers(const std::vector<std::string>& cells, size_t* numeric) {
  *numeric = std::count_if(cells.begin(), cells.end(), IsNumeric);
  return *numeric >= 3 || (*numeric > 0 && 2 * *numeric >= CountFilled(cells));
}

struct Layout {
  char separator = ',';
  size_t columns = 0;
  size_t numbers = 0;  // cells that are numbers, in rows with that many columns
};

Layout LayoutWith(char separator, const std::vector<TableLine>& lines) {
  std::map<size_t, size_t> numbers_by_columns;
  for (const TableLine& line : lines) {
    CheckInterruption();
    if (line.is_comment) continue;
    const std::vector<std::string> cells = Split(line.text, separator);
    size_t numeric = 0;
    if (HoldsNumbers(cells, &numeric)) numbers_by_columns[cells.size()] += numeric;
  }
  Layout layout{separator, 0, 0};
  for (const auto& [columns, numbers] : numbers_by_columns) {
    if (columns > 1 && numbers >= layout.numbers) layout = {separator, columns, numbers};
  }
  return layout;
}

Layout FindLayout(const std::vector<TableLine>& lines, const std::string& path) {
  Layout best;
  for (const char separator : {'\t', ';', '|', ',', ' '}) {
    const Layout layout = LayoutWith(separator, lines);
    if (layout.numbers > best.numbers) best = layout;
  }
  if (best.columns > limits::kColumns) {
    throw InputError({path, 0, ""}, "the table has more than " + std::to_string(limits::kColumns) + " columns");
  }
  if (best.numbers == 0) {
    throw InputError({path, 0, ""}, "no table of numbers is found",
                     "rows of numbers with tabs, semicolons, commas, bars or blanks between them are expected");
  }
  return best;
}

std::string SeparatorName(char separator) {
  switch (separator) {
    case '\t':
      return "tab";
    case ';':
      return "semicolon";
    case '|':
      return "bar";
    case ',':
      return "comma";
    default:
      return "blanks";
  }
}

bool IsUnitWord(std::string cell) {
  for (const char* bracket : {"[", "]", "(", ")"}) {
    const size_t at = cell.find(bracket);
    if (at != std::string::npos) cell.erase(at, 1);
  }
  return cell.empty() || cell == "-" || IsUnit(cell);
}

class Builder {
 public:
  Builder(std::string path, std::vector<TableLine> lines, const Layout& layout)
      : lines_(std::move(lines)), layout_(layout) {
    table_.path = std::move(path);
    table_.separator = SeparatorName(layout.separator);
  }

  TextTable Build() && {
    const size_t first = FirstRow();
    size_t header = first;
    TakeHeader(first, &header);
    for (size_t i = 0; i < lines_.size(); ++i) {
      CheckInterruption();
      const bool is_title = table_.has_header() && i >= header && i < first;
      if (!is_title && (i < first || lines_[i].is_comment)) table_.preamble.push_back(lines_[i].text);
    }
    for (size_t i = first; i < lines_.size(); ++i) {
      CheckInterruption();
      if (!lines_[i].is_comment) AddRow(lines_[i]);
    }
    DropEmptyLastColumn();
    FindDecimalSign();
    return std::move(table_);
  }

 private:
  std::vector<std::string> Cells(const TableLine& line) const { return Split(line.text, layout_.separator); }

  bool IsRow(const TableLine& line) const {
    if (line.is_comment) return false;
    const std::vector<std::string> cells = Cells(line);
    size_t numeric = 0;
    return cells.size() == layout_.columns && HoldsNumbers(cells, &numeric);
  }

  // Rows above it whose numbers are all lost hold no number, and no title.
  size_t FirstRow() const {
    size_t i = 0;
    while (!IsRow(lines_[i])) ++i;
    const std::vector<std::string> cells = Cells(lines_[i]);
    while (i > 0 && IsLostRow(lines_[i - 1], cells)) --i;
    return i;
  }

  bool IsLostRow(const TableLine& line, const std::vector<std::string>& row) const {
    const std::vector<std::string> cells = Cells(line);
    if (line.is_comment || cells.size() != row.size() || CountFilled(cells) == 0) return false;
    for (size_t c = 0; c < row.size(); ++c) {
      if (IsNumeric(row[c]) && !IsLostCell(cells[c])) return false;
    }
    return true;
  }

  bool IsTitle(const TableLine& line) const {
    const std::vector<std::string> cells = Cells(line);
    return cells.size() == layout_.columns && std::none_of(cells.begin(), cells.end(), IsNumeric);
  }

  // Names, and the units that may stand in a line of their own below.
  void TakeHeader(size_t first, size_t* header) {
    table_.header.assign(layout_.columns, "");
    if (first == 0 || !IsTitle(lines_[first - 1])) {
      // A header with another number of cells would shift the names silently.
      if (first > 0 && !lines_[first - 1].is_comment && Cells(lines_[first - 1]).size() > 2) {
        RefuseHalfNumbers(lines_[first - 1]);
        throw InputError({table_.path, lines_[first - 1].number, ""},
                         "this line has " + std::to_string(Cells(lines_[first - 1]).size()) +
                             " cells, the rows below have " + std::to_string(layout_.columns) +
                             " (separator: " + table_.separator + ")",
                         layout_.separator == ',' ? "commas as decimals and as separators? save with semicolons"
                                                  : "one name per column is expected");
      }
      return;
    }
    std::vector<std::string> names = Cells(lines_[first - 1]), units;
    *header = first - 1;
    if (first > 1 && IsTitle(lines_[first - 2]) && std::all_of(names.begin(), names.end(), IsUnitWord)) {
      units = names;
      names = Cells(lines_[first - 2]);
      *header = first - 2;
    }
    NameByTheLineAbove(header, &names);
    table_.header_line = lines_[*header].number;
    for (size_t c = 0; c < names.size(); ++c) {
      const bool has_unit = !units.empty() && !units[c].empty() && units[c] != "-";
      if (names[c].size() > limits::kWordBytes) {
        throw InputError({table_.path, table_.header_line, ""}, "column " + std::to_string(c + 1) + " has a name of " +
                                                                    std::to_string(names[c].size()) + " bytes");
      }
      table_.header[c] = names[c] + (has_unit ? (units[c][0] == '[' ? " " + units[c] : " [" + units[c] + "]") : "");
    }
  }

  // X, Y, Z, X, Y, Z below Rotation, Rotation … and Position … (motion capture) are no names yet: with the line above
  // they are.
  void NameByTheLineAbove(size_t* header, std::vector<std::string>* names) const {
    const auto stands_twice = [names](const std::string& name) {
      return !name.empty() && std::count(names->begin(), names->end(), name) > 1;
    };
    if (*header == 0 || std::none_of(names->begin(), names->end(), stands_twice)) return;
    const TableLine& line = lines_[*header - 1];
    if (line.is_comment || !IsTitle(line)) return;
    const std::vector<std::string> above = Cells(line);
    for (size_t c = 0; c < names->size(); ++c) {
      std::string& name = (*names)[c];
      if (!above[c].empty() && above[c] != name) name = above[c] + (name.empty() ? "" : " " + name);
    }
    --*header;
  }

  // As many cells as the rows below, but neither names nor mostly numbers.
  void RefuseHalfNumbers(const TableLine& line) const {
    const std::vector<std::string> cells = Cells(line);
    if (cells.size() != layout_.columns) return;
    const auto other = std::find_if_not(cells.begin(), cells.end(), IsNumeric);
    throw InputError({table_.path, line.number, ""},
                     "this line is no header, as some of its cells are numbers, and no row, as most are not: '" +
                         *other + "' is no number",
                     "numbers like -12.5, one header above them");
  }

  void AddRow(const TableLine& line) {
    TextTable::Row row{line.number, Cells(line)};
    if (row.cells.size() != layout_.columns) {
      throw InputError({table_.path, line.number, ""},
                       "the row has " + std::to_string(row.cells.size()) + " cells, the others have " +
                           std::to_string(layout_.columns) + " (separator: " + table_.separator + ")",
                       layout_.separator == ' ' ? "an empty cell cannot be seen between blanks: use another separator"
                                                : "the table has to end with the file");
    }
    for (const std::string& cell : row.cells) {
      const size_t found = FindControlCharacter(cell);
      if (found == std::string::npos) continue;
      throw InputError({table_.path, line.number, ""},
                       "a cell holds the control character " + NameOfControlCharacter(cell, found));
    }
    table_.rows.push_back(std::move(row));
  }

  // A separator at the end of every line.
  void DropEmptyLastColumn() {
    const auto is_empty = [](const TextTable::Row& row) { return row.cells.back().empty(); };
    if (!table_.header.back().empty() || !std::all_of(table_.rows.begin(), table_.rows.end(), is_empty)) return;
    table_.header.pop_back();
    for (TextTable::Row& row : table_.rows) row.cells.pop_back();
  }

  // Comma where it stands in numbers alone; both alone: one of them groups thousands, and which cannot be decided.
  void FindDecimalSign() {
    const TextTable::Row* comma = nullptr;
    const TextTable::Row* point = nullptr;
    bool comma_last = false, point_last = false, by_three = true;
    for (const TextTable::Row& row : table_.rows) {
      CheckInterruption();
      for (const std::string& cell : row.cells) {
        if (!IsNumeric(cell)) continue;
        const size_t c = cell.rfind(','), p = cell.rfind('.');
        if (c != std::string::npos && p != std::string::npos) (c > p ? comma_last : point_last) = true;
        if (c != std::string::npos && p == std::string::npos) {
          comma = &row;
          by_three &= cell.size() - c == 4;
        }
        if (p != std::string::npos && c == std::string::npos) point = &row;
      }
    }
    const bool as_comma = comma != nullptr || comma_last, as_point = point != nullptr || point_last;
    if (as_comma && as_point) {
      throw InputError({table_.path,
                        (comma   ? comma
                         : point ? point
                                 : &table_.rows[0])
                            ->line,
                        ""},
                       "some numbers have a comma and some a point: which is the decimal sign cannot be determined",
                       "one decimal sign and no thousands are expected");
    }
    table_.decimal_comma = as_comma;
    if (as_comma && !comma_last && by_three) {
      table_.guesses.push_back(
          "the comma is the decimal sign: three digits follow it everywhere, it could group thousands");
    }
  }

  std::vector<TableLine> lines_;
  Layout layout_;
  TextTable table_;
};

}  // namespace

bool IsLostCell(const std::string& cell) {
  std::string lower;
  for (const char c : cell) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  static const std::vector<std::string> kWords = {"nan",      "-nan",   "n/a",     "na",     "null",
                                                  "none",     "#n/a",   "inf",     "-inf",   "1.#qnan",
                                                  "-1.#qnan", "1.#ind", "-1.#ind", "1.#inf", "-1.#inf"};
  if (cell.find_first_not_of('-') == std::string::npos || cell.find_first_not_of('*') == std::string::npos) return true;
  if (std::find(kWords.begin(), kWords.end(), lower) != kWords.end()) return true;
  for (const bool comma : {false, true}) {
    const std::optional<double> number = ParseLocalNumber(cell, comma);
    if (number && *number == kLostReading) return true;
  }
  return false;
}

std::optional<double> ParseLocalNumber(const std::string& cell, bool decimal_comma) {
  const size_t comma = cell.rfind(','), point = cell.rfind('.');
  std::string text = cell;
  if (comma != std::string::npos && point != std::string::npos) {
    const char groups = comma > point ? '.' : ',';
    const size_t decimal = std::max(comma, point);
    // Groups of three digits before the decimal sign.
    for (size_t i = decimal; i-- > 0;) {
      if (text[i] == groups && (decimal - i) % 4 != 0) return std::nullopt;
    }
    text.erase(std::remove(text.begin(), text.end(), groups), text.end());
  } else if (decimal_comma ? point != std::string::npos : comma != std::string::npos) {
    return std::nullopt;
  }
  const size_t last = text.rfind(',');
  if (last != text.find(',')) return std::nullopt;
  if (last != std::string::npos) text[last] = '.';
  return ParseNumber(text);
}

std::optional<double> TextTable::Number(const std::string& cell) const { return ParseLocalNumber(cell, decimal_comma); }

TextTable ParseTextTable(const std::string& bytes, const std::string& path) {
  std::string encoding;
  const std::string text = WithPlainMinus(DecodeText(bytes, path, &encoding));
  std::vector<TableLine> lines = LinesOf(text);
  const Layout layout = FindLayout(lines, path);
  TextTable table = Builder(path, std::move(lines), layout).Build();
  table.encoding = encoding;
  return table;
}

TextTable ReadTextTable(const std::string& path) { return ParseTextTable(ReadTextFile(path), path); }

}  // namespace sagitta
