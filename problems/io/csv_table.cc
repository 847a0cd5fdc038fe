#include "problems/io/csv_table.h"

#include <algorithm>
#include <functional>
#include <future>
#include <set>
#include <string>
#include <string_view>

#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/files.h"
#include "problems/io/text_checks.h"
#include "problems/io/trimmed.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

struct CsvLine {
  std::string_view text;
  int number = 0;
};

// Hands out the lines that carry something.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {}

  bool Next(CsvLine* line) {
    while (!rest_.empty()) {
      const size_t end = rest_.find('\n');
      const std::string_view text = Trimmed(rest_.substr(0, end), kBlanks);
      rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
      ++number_;
      if (text.empty() || text.front() == '#') continue;
      *line = {text, number_};
      return true;
    }
    return false;
  }

 private:
  std::string_view rest_;
  int number_ = 0;
};

// Cuts a cell in quotes off the front of `rest`, the comma after it included.
// False: the quotes are not closed or something follows them.
bool TakeQuotedCell(std::string_view* rest, std::string* cell) {
  size_t i = 1;
  for (; i < rest->size(); ++i) {
    if ((*rest)[i] != '"') {
      *cell += (*rest)[i];
    } else if (i + 1 < rest->size() && (*rest)[i + 1] == '"') {
      *cell += (*rest)[++i];
    } else {
      break;
    }
  }
  if (i >= rest->size()) return false;
  const size_t comma = rest->find(',', i);
  const std::string_view after = rest->substr(i + 1, comma == std::string_view::npos ? comma : comma - i - 1);
  if (!Trimmed(after, kBlanks).empty()) return false;
  *rest = comma == std::string_view::npos ? std::string_view() : rest->substr(comma);
  return true;
}

// False: no byte of the text begins a control character but ends of lines, and tabs. Without a jump per byte: the
// compiler checks 16 at once.
bool MayHoldControl(std::string_view text) {
  unsigned char control = 0, returns = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_end = (byte == '\n') | (byte == '\t') | (byte == '\r');
    control |= static_cast<unsigned char>(((byte < 0x20) & !is_end) | (byte == 0x7F) | (byte == 0xC2));
    returns |= static_cast<unsigned char>(byte == '\r');
  }
  if (control != 0) return true;
  for (size_t i = 0; returns != 0 && i < text.size(); ++i) {
    if (text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n')) return true;
  }
  return false;
}

// A tab may stand between cells; whatever else moves a cursor or rings a bell may not. npos: there is none.
size_t FindControlButTab(std::string_view text) {
  size_t from = 0;
  while (true) {
    const size_t found = FindControlCharacter(text.substr(from));
    if (found == std::string_view::npos || text[from + found] != '\t') {
      return found == std::string_view::npos ? found : from + found;
    }
    from += found + 1;
  }
}

void CheckControl(const std::string& path, const CsvLine& line) {
  const size_t found = FindControlButTab(line.text);
  if (found == std::string_view::npos) return;
  throw InputError(
      {path, line.number, ""},
      "the line holds the control character " + NameOfControlCharacter(line.text, found) + ": this is not a text file",
      "save the table as plain text in UTF-8");
}

// Calls `take` for each cell, `quoted` being memory for those in quotes. At most limits::kColumns.
template <typename Take>
void ForEachCell(const std::string& path, const CsvLine& line, std::string* quoted, const Take& take) {
  size_t cells = 0;
  std::string_view rest = line.text;
  while (true) {
    ++cells;
    const size_t first = rest.find_first_not_of(kBlanks);
    std::string_view cell;
    if (first != std::string_view::npos && rest[first] == '"') {
      rest.remove_prefix(first);
      quoted->clear();
      if (!TakeQuotedCell(&rest, quoted)) {
        throw InputError({path, line.number, ""},
                         "the quotes of cell " + std::to_string(cells) + " are not closed before the comma");
      }
      cell = *quoted;
    } else {
      const size_t comma = rest.find(',');
      cell = Trimmed(rest.substr(0, comma), kBlanks);
      rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma);
    }
    if (!cell.empty() && cell.front() == '\'') {
      *quoted = UnguardedCell(std::string(cell));
      cell = *quoted;
    }
    take(cell);
    if (rest.empty()) return;
    if (cells == limits::kColumns) {
      throw InputError({path, line.number, ""}, "the row has more than " + std::to_string(limits::kColumns) + " cells");
    }
    rest.remove_prefix(1);  // the comma; what follows is one more cell, even if empty
  }
}

bool HasBlank(std::string_view line) {
  const auto holds = [line](char blank) { return line.find(blank) != std::string_view::npos; };
  return std::any_of(kBlanks.begin(), kBlanks.end(), holds);
}

std::vector<std::string> SplitCells(const std::string& path, const CsvLine& line) {
  CheckControl(path, line);
  std::vector<std::string> cells;
  std::string quoted;
  ForEachCell(path, line, &quoted, [&](std::string_view cell) { cells.emplace_back(cell); });
  return cells;
}

void CheckHeader(const std::string& path, const CsvLine& line, const std::vector<std::string>& header) {
  if (header.size() == 1 && line.text.find_first_of(";\t") != std::string_view::npos) {
    throw InputError({path, line.number, ""}, "the header has one column",
                     "columns are separated by commas, and numbers have a decimal point; 'sagitta import' reads other "
                     "tables as well");
  }
  std::set<std::string> seen;
  for (size_t c = 0; c < header.size(); ++c) {
    if (header[c].empty()) {
      throw InputError({path, line.number, ""}, "column " + std::to_string(c + 1) + " has no name",
                       c + 1 == header.size() ? "the lines end with a comma: remove it" : "");
    }
    if (header[c].size() > limits::kWordBytes) {
      throw InputError({path, line.number, ""}, "column " + std::to_string(c + 1) + " has a name of " +
                                                    std::to_string(header[c].size()) + " bytes");
    }
    if (!seen.insert(header[c]).second) throw InputError({path, line.number, header[c]}, "this column stands twice");
  }
}

// Of a large table while it is read, an eighth of the time; where there is no thread to be had, when it is asked
// for.
std::future<std::string> DigestMeanwhile(const std::string& text) {
  constexpr size_t kLarge = 1 << 20;  // bytes: half a millisecond, many times what a thread costs
  const std::launch later = std::launch::deferred;
  return std::async(text.size() < kLarge ? later : std::launch::async | later, Sha256, std::cref(text));
}

// The lines below the header.
void AddRows(const std::string& path, std::string_view content, bool has_control, LineReader* reader, CsvTable* table) {
  const size_t columns = table->file.header.size();
  MeasurementRows& rows = table->file.rows;
  const auto holds = [&](char c) { return content.find(c) != std::string_view::npos; };
  // No cell is guarded or in quotes; and none of all has blanks about it: '\r' stands at ends of lines alone.
  const bool is_plain = !holds('"') && !holds('\''), is_without_blanks = !has_control && !holds(' ') && !holds('\t');
  std::string quoted;
  CsvLine line;
  while (reader->Next(&line)) {
    CheckInterruption();
    if (has_control) CheckControl(path, line);
    if (rows.empty()) {
      const size_t lines = content.size() / (line.text.size() + 1) + 1;  // if all are as long as the first
      rows.Reserve(std::min(lines, limits::kCells / columns), std::min(lines * columns, limits::kCells),
                   content.size());
    }
    rows.BeginRow(line.number);
    if (is_plain && (is_without_blanks || !HasBlank(line.text))) {
      rows.AddCells(line.text);
    } else {
      ForEachCell(path, line, &quoted, [&](std::string_view cell) { rows.AddCell(cell); });
    }
    const size_t count = rows[rows.size() - 1].cells.size();
    if (count != columns) {
      throw InputError({path, line.number, ""},
                       "the row has " + std::to_string(count) + " cells, the header has " + std::to_string(columns),
                       count > columns ? "a decimal comma? numbers have a point" : "a comma is missing?");
    }
    if (rows.size() * columns > limits::kCells) {
      throw InputError({path, line.number, ""}, "the table has more than " + std::to_string(limits::kCells) + " cells",
                       "split the file, or leave out columns that nothing needs");
    }
  }
}

// Of a cell that no file held, or of a column's name.
void CheckCell(const std::string& cell, const InputError::Where& where) {
  if (LineOfInvalidUtf8(cell) > 0) throw InputError(where, "this is no text in UTF-8");
  const size_t control = FindControlButTab(cell);
  if (control == std::string::npos) return;
  throw InputError(where, "the text holds the control character " + NameOfControlCharacter(cell, control));
}

// Before they are copied.
void CheckSizes(const std::string& name, const std::vector<std::string>& header,
                const std::vector<std::vector<std::string>>& columns) {
  if (header.size() > limits::kColumns) {
    throw InputError({name, 0, ""}, "the table has more than " + std::to_string(limits::kColumns) + " columns");
  }
  size_t cells = 0, bytes = 0;
  for (const std::vector<std::string>& column : columns) {
    cells += column.size();
    for (const std::string& cell : column) bytes += cell.size() + 1;
  }
  if (cells > limits::kCells) {
    throw InputError({name, 0, ""}, "the table has more than " + std::to_string(limits::kCells) + " cells",
                     "split it, or leave out columns that nothing needs");
  }
  if (bytes > limits::kFileBytes) {
    throw InputError({name, 0, ""}, "the table has more than " + std::to_string(limits::kFileBytes >> 20) + " MB",
                     "split it, or leave out columns that nothing needs");
  }
}

// What a file of these cells would hold: it distinguishes one table from another, as SHA-256 of files do.
std::string TextOfTable(const MeasurementFile& file) {
  std::string text;
  const auto add = [&text](const auto& cells) {
    for (size_t c = 0; c < cells.size(); ++c) text.append(c > 0 ? "," : "").append(cells[c]);
    text += "\n";
  };
  add(file.header);
  for (const MeasurementFile::Row& row : file.rows) add(row.cells);
  return text;
}

}  // namespace

CsvTable CsvTableOf(const std::string& name, std::vector<std::string> header,
                    const std::vector<std::vector<std::string>>& columns, const std::vector<int>& lines) {
  if (columns.empty() || columns.front().empty()) throw InputError({name, 0, ""}, "there are no rows");
  for (const std::string& column : header) CheckCell(column, {name, 0, ""});
  CheckSizes(name, header, columns);
  CheckHeader(name, {"", 0}, header);
  CsvTable table;
  table.file.path = name;
  table.file.header = std::move(header);
  for (size_t r = 0; r < columns.front().size(); ++r) {
    const int line = lines.empty() ? static_cast<int>(r) + 1 : lines[r];
    table.file.rows.BeginRow(line);
    for (size_t c = 0; c < columns.size(); ++c) {
      CheckCell(columns[c][r], {name, line, table.file.header[c]});
      table.file.rows.AddCell(columns[c][r]);
    }
  }
  table.file.sha256 = Sha256(TextOfTable(table.file));
  return table;
}

CsvTable ReadCsvTable(const std::string& path) { return ParseCsvTable(*SharedText(path), path); }

CsvTable ParseCsvTable(const std::string& text, const std::string& path) {
  if (const int bad_line = LineOfInvalidUtf8(text))
    throw InputError({path, bad_line, ""}, "this is not a text file in UTF-8",
                     "save it as UTF-8, the sheet of a workbook as CSV; 'sagitta import' reads tables in UTF-16 and "
                     "Latin-1 as well");
  CsvTable table;
  table.file.path = path;
  std::future<std::string> digest = DigestMeanwhile(text);
  std::string_view content = text;
  if (content.substr(0, 3) == "\xEF\xBB\xBF") content.remove_prefix(3);

  const bool has_control = MayHoldControl(content);
  LineReader reader(content);
  CsvLine line;
  if (!reader.Next(&line)) throw InputError({path, 0, ""}, "the file is empty", "a header row is expected");
  table.header_line = line.number;
  table.file.header = SplitCells(path, line);
  CheckHeader(path, line, table.file.header);

  AddRows(path, content, has_control, &reader, &table);
  if (table.file.rows.empty()) throw InputError({path, table.header_line, ""}, "there are no rows below the header");
  table.file.sha256 = digest.get();
  return table;
}

}  // namespace sagitta
