// What the readers of robot programs share: code without comments, numbers with their places, aggregates.
#pragma once

#include <cctype>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "problems/io/programs/robot_program.h"

namespace sagitta {

// A program as its reader sees it, in UTF-8 whatever the file is in: without comments and quoted strings, and with one
// blank for every run of blanks, one \n where the run holds the end of a line. std::regex goes a call deeper for every
// byte that a pattern loops over: what a pattern can loop over is short here, and a word or a line that is not is an
// InputError.
class ProgramCode {
 public:
  // A quoted string of the file; in the code there is a blank in its place.
  struct Quote {
    size_t at = 0;  // of the blank
    std::string text;
  };

  // `comment`: what starts one. `longest_line`: bytes.
  ProgramCode(const RobotProgram& program, const std::string& comment, char quote,
              size_t longest_line = std::string::npos);
  const std::string& text() const { return text_; }
  const std::vector<Quote>& quotes() const { return quotes_; }
  ProgramCode InCapitals() const;
  int LineAt(size_t position) const;  // in the file, from 1
  // Numbers of the program's points: from where they stand in the code to where they stand in the file.
  void PlaceInFile(RobotProgram* program) const;

 private:
  void CheckLengths(const std::string& path, size_t longest_line) const;

  std::string text_;
  std::vector<size_t> place_;  // in the file, of every byte of the code and of its end
  std::vector<size_t> lines_;  // where they begin in the file
  std::vector<Quote> quotes_;
};

// Bytes beyond ASCII of a text that is not UTF-8 are letters of ISO 8859-1, as controllers write them.
std::string InUtf8(const std::string& text);

// As MakePattern, for code: letters of names may be beyond ASCII (\w).
std::regex MakeCodePattern(const std::string& expression);

std::string UpperCase(std::string text);
std::string Unspaced(std::string text);

// Where `name` stands as a word of its own.
std::vector<size_t> PlacesOf(const std::string& code, const std::string& name);

// Whether the program names a tool, base or load so: "BASE_DATA[1]" also as BAS(#BASE,1) and BASE_NO 1.
bool NameStandsIn(const RobotProgram& program, const std::string& name);

inline bool IsWordCharacter(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= 0x80 || std::isalnum(byte) != 0 || c == '_' || c == '$';
}

// What stands before the sign of an assignment at `sign`: "VAR num n", "gun.tload.mass", "p1[2]".
struct Assigned {
  std::string word, name, parts;  // "VAR num n" -> num, n; "gun.tload.mass" -> gun, .tload.mass
  size_t at = 0;                  // of the name
};
Assigned AssignedBefore(const std::string& code, size_t sign);

// The end of the bracket that opens at `open`, one past it; npos: it is not closed.
size_t EndOfBracket(std::string_view code, size_t open);

// The parts of code[begin, end) between commas outside of all brackets, as (begin, end) without blanks.
using TextRange = std::pair<size_t, size_t>;
std::vector<TextRange> PartsOf(std::string_view code, size_t begin, size_t end);

// The range as one number. False: it is anything else.
bool NumberAt(std::string_view code, TextRange range, TextNumber* number);

// code[range] on one line, cut where it is long.
std::string Quoted(std::string_view code, TextRange range);

// Why a point stays of which an external axis has a value.
std::string ExternalAxisInWords(const std::string& axis, std::string_view code, const TextNumber& value);
constexpr const char* kMoreThanSixJoints =
    "the robot file has more than six joints: which of them are external axes of the program is not stated";

// The target of a motion command as it is written at `target`. Its point is still to be found.
ProgramMotion MotionTo(const std::string& command, const ProgramCode& code, TextRange target);

// The numbers of "[1, 2, 3]" at `open`, nested brackets flattened. Empty: something in it is no number.
std::vector<TextNumber> NumbersInBracket(std::string_view code, size_t open);

}  // namespace sagitta
