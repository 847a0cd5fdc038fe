// What the readers of robot programs share: code without comments, numbers with their places, aggregates.
#pragma once

#include <cctype>
#include <string>
#include <string_view>
#include <vector>

#include "problems/io/programs/robot_program.h"

namespace sagitta {

// The text with comments and quoted strings blanked out, byte for byte in place; a line that ends with a carriage
// return alone ends with \n. `comment`: what starts one.
std::string WithoutComments(const std::string& text, const std::string& comment, char quote);

int LineAt(const std::string& text, size_t position);  // from 1

std::string UpperCase(std::string text);

// Where `name` stands as a word of its own.
std::vector<size_t> PlacesOf(const std::string& code, const std::string& name);

inline bool IsWordCharacter(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '$'; }

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
ProgramMotion MotionTo(const std::string& command, const std::string& code, TextRange target);

// The numbers of "[1, 2, 3]" at `open`, nested brackets flattened. Empty: something in it is no number.
std::vector<TextNumber> NumbersInBracket(std::string_view code, size_t open);

}  // namespace sagitta
