// What a text from a file may hold where it is shown or written again.
#pragma once

#include <string>
#include <string_view>

namespace sagitta {

// The first control character's place (bytes below 32, 127, and C1: U+0080 to U+009F); npos: none. Names that hold one
// are refused by the readers: on a terminal it is a command, in a table it ends a cell or a line.
size_t FindControlCharacter(std::string_view text);
inline bool HasControlCharacter(std::string_view text) { return FindControlCharacter(text) != std::string_view::npos; }

// "U+001B" of the one at `at`.
std::string NameOfControlCharacter(std::string_view text, size_t at);

// The text with control characters as \x1b and, unless `keep_lines` keeps them, line ends and tabs as \n and \t.
std::string Printable(std::string_view text, bool keep_lines = false);

// The same text in UTF-8 for certain: bytes that are none become U+FFFD.
std::string ValidUtf8(const std::string& text);

// A cell of a CSV file: quoted where it has to be, and, where it is a text that a spreadsheet would compute (=1+1,
// +cmd, -x, @f), with an apostrophe before it, which UnguardedCell removes. Numbers stay numbers.
std::string CsvCell(const std::string& text);
// Appends the same to a line.
void AddCsvCell(std::string_view text, std::string* line);
// Appends cells that lie one behind the other with a comma between two, where all of them stand as they are. False, and
// nothing is appended: one of them may not.
bool AddCsvCells(std::string_view cells, size_t count, std::string* line);
// The cell as it was before CsvCell guarded it.
std::string UnguardedCell(std::string cell);

// A word as a POSIX shell reads it back: as it stands where it holds nothing but [A-Za-z0-9_@%+=:,./-], else in single
// quotes.
std::string ShellWord(const std::string& word);

}  // namespace sagitta
