// A table in a text file of any make: encoding, separator, decimal comma, header
// and units are found out, and what had to be guessed is said.
//
//   encoding   UTF-8 (with or without BOM), UTF-16, else Windows-1252
//   separator  tab, semicolon, bar, comma or blanks: the one by which most cells are numbers
//   decimals   point, or comma where the separator leaves it free
//   header     the last line above the numbers with as many cells as they have, if it
//              holds words; `#` or `%` before it is no cell; a line of units may follow
//   others     lines before the header are kept as a preamble, `#` and `%` lines as comments
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace sagitta {

struct TextTable {
  struct Row {
    int line = 0;  // in the file, from 1
    std::vector<std::string> cells;
  };
  std::string path;
  std::vector<std::string> header;  // one per column; "" without a header line
  int header_line = 0;              // 0: none
  std::vector<Row> rows;
  std::vector<std::string> preamble;  // lines before the table and comments, for words like "modified"
  std::string encoding;               // in words
  std::string separator;              // in words
  bool decimal_comma = false;
  std::string joined_with;       // in words: where columns of another file are from
  bool joined_in_order = false;  // and not by names
  struct NotJoined {
    std::string header, why;  // as printed
    bool moved = false;       // an axis outside the arm that did not stand still
  };
  std::vector<NotJoined> not_joined;  // columns of that file that are not used
  std::vector<std::string> guesses;   // what a reader could understand otherwise, in words

  bool has_header() const { return header_line > 0; }
  int columns() const { return static_cast<int>(header.size()); }
  // A cell's number; nothing where it is empty, no number, or could be two.
  std::optional<double> Number(const std::string& cell) const;
};

// Throws InputError: no table of numbers, a workbook, rows of unequal length, a
// separator or decimal sign that cannot be decided.
TextTable ReadTextTable(const std::string& path);
TextTable ParseTextTable(const std::string& bytes, const std::string& path);

// The bytes as UTF-8, by BOM, zero bytes or validity; says in words what it was.
std::string DecodeText(const std::string& bytes, const std::string& path, std::string* encoding);

// A number with decimal comma or point; both signs: the last is the decimal one and
// the other groups by three. Nothing where a single sign could mean either.
std::optional<double> ParseLocalNumber(const std::string& cell, bool decimal_comma);

constexpr double kLostReading = -9999.0;
// A reading that is none: empty, NaN, n/a, -, or that number.
bool IsLostCell(const std::string& cell);

}  // namespace sagitta
