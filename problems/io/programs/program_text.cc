#include "problems/io/programs/program_text.h"

#include <algorithm>

#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/pattern.h"
#include "problems/io/units.h"

namespace sagitta {

namespace {

bool IsBlank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

// Comments and quoted strings blanked out, byte for byte in place; a line that ends with a carriage return alone ends
// with \n. quotes: the strings, and where they stood.
std::string WithoutComments(const std::string& text, const std::string& comment, char quote,
                            std::vector<ProgramCode::Quote>* quotes) {
  std::string code = text;
  for (size_t i = 0; i < code.size(); ++i) {
    if (code[i] == '\r' && (i + 1 == code.size() || code[i + 1] != '\n')) code[i] = '\n';
  }
  for (size_t i = 0; i < code.size();) {
    size_t end = i;
    if (code.compare(i, comment.size(), comment) == 0) {
      end = std::min(code.find('\n', i), code.size());
    } else if (code[i] == quote) {
      end = std::min(code.find_first_of(std::string("\n") + quote, i + 1), code.size());
      quotes->push_back({i, code.substr(i + 1, end - i - 1)});
      end += end < code.size() && code[end] == quote;
    }
    if (end == i) {
      ++i;
      continue;
    }
    for (; i < end; ++i) {
      if (code[i] != '\r') code[i] = ' ';
    }
  }
  return code;
}

std::string Utf8OfLatin1(char c) {
  const auto byte = static_cast<unsigned char>(c);
  if (byte < 0x80) return std::string(1, c);
  return {static_cast<char>(0xC0 | (byte >> 6)), static_cast<char>(0x80 | (byte & 0x3F))};
}

}  // namespace

std::string InUtf8(const std::string& text) {
  if (LineOfInvalidUtf8(text) == 0) return text;
  std::string utf8;
  for (const char c : text) utf8 += Utf8OfLatin1(c);
  return utf8;
}

std::regex MakeCodePattern(const std::string& expression) {
  const std::string letters = "\\w\\x80-\\xff";
  std::string wide;
  bool in_class = false;
  for (size_t i = 0; i < expression.size(); ++i) {
    const size_t length = expression[i] == '\\' ? 2 : 1;
    const std::string part = expression.substr(i, length);
    if (part == "[" || part == "]") in_class = part == "[";
    wide += part != "\\w" ? part : in_class ? letters : "[" + letters + "]";
    i += length - 1;
  }
  return MakePattern(wide);
}

ProgramCode::ProgramCode(const RobotProgram& program, const std::string& comment, char quote, size_t longest_line) {
  const std::string code = WithoutComments(program.text, comment, quote, &quotes_);
  const bool is_utf8 = LineOfInvalidUtf8(program.text) == 0;
  lines_ = {0};
  bool was_blank = false;
  for (size_t i = 0; i < code.size(); ++i) {
    if (code[i] == '\n') lines_.push_back(i + 1);
    const bool is_blank = IsBlank(code[i]);
    if (!is_blank || !was_blank) {
      text_ += is_blank ? " " : is_utf8 ? std::string(1, code[i]) : Utf8OfLatin1(code[i]);
      place_.resize(text_.size(), i);
    }
    if (code[i] == '\n') text_.back() = '\n';
    was_blank = is_blank;
  }
  for (Quote& one : quotes_) {
    const auto after = std::upper_bound(place_.begin(), place_.end(), one.at);
    one.at = static_cast<size_t>(after - place_.begin()) - 1;
  }
  place_.push_back(code.size());
  CheckLengths(program.path, longest_line);
}

void ProgramCode::CheckLengths(const std::string& path, size_t longest_line) const {
  constexpr size_t kLongestWord = 2000;  // bytes: std::regex, which searches them, ends its stack at 32 kB (limits.h)
  size_t word = 0, line = 0;
  for (size_t i = 0; i < text_.size(); ++i) {
    if (std::string_view(" \n,;()[]{}").find(text_[i]) != std::string_view::npos) word = i + 1;
    if (text_[i] == '\n') line = i + 1;
    const bool is_line = i + 1 - line > longest_line;
    if (i + 1 - word <= kLongestWord && !is_line) continue;
    throw InputError({path, LineAt(i), ""}, is_line ? "no controller has lines as long as this one"
                                                    : "no program has words as long as this one");
  }
}

ProgramCode ProgramCode::InCapitals() const {
  ProgramCode code = *this;
  code.text_ = UpperCase(text_);
  return code;
}

int ProgramCode::LineAt(size_t position) const {
  const size_t place = place_[std::min(position, place_.size() - 1)];
  return static_cast<int>(std::upper_bound(lines_.begin(), lines_.end(), place) - lines_.begin());
}

void ProgramCode::PlaceInFile(RobotProgram* program) const {
  for (ProgramPoint& point : program->points) {
    for (TextNumber& number : point.numbers) {
      number.end = place_[number.end - 1] + 1;
      number.begin = place_[number.begin];
    }
  }
}

std::string UpperCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string Unspaced(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), IsBlank), text.end());
  return text;
}

std::vector<size_t> PlacesOf(const std::string& code, const std::string& name) {
  std::vector<size_t> places;
  for (size_t at = code.find(name); at != std::string::npos; at = code.find(name, at + 1)) {
    const size_t end = at + name.size();
    if (at > 0 && IsWordCharacter(code[at - 1])) continue;
    if (end < code.size() && IsWordCharacter(code[end])) continue;
    places.push_back(at);
  }
  return places;
}

bool NameStandsIn(const RobotProgram& program, const std::string& name) {
  const bool has_case = program.traits().names_have_case;
  const std::string whole = InUtf8(program.text), text = has_case ? whole : UpperCase(whole),
                    folded = has_case ? name : UpperCase(name);
  if (!PlacesOf(text, folded).empty()) return true;
  const size_t data = folded.find("_DATA["), end = folded.find(']');
  if (data == std::string::npos || end == std::string::npos) return false;
  const std::string kind = folded.substr(0, data), number = folded.substr(data + 6, end - data - 6);
  const std::string unspaced = Unspaced(text);
  for (const std::string& written : {folded, "#" + kind + "," + number + ")", kind + "_NO" + number + ","}) {
    if (unspaced.find(written) != std::string::npos) return true;
  }
  return false;
}

Assigned AssignedBefore(const std::string& code, size_t sign) {
  size_t end = sign, begin = sign;
  const auto skip_blanks = [&] {
    while (end > 0 && IsBlank(code[end - 1])) --end;
  };
  // The word that ends at `end`, an index in brackets left out.
  const auto find_word = [&] {
    skip_blanks();
    int depth = 0;
    while (end > 0 && (depth > 0 || code[end - 1] == ']' || code[end - 1] == '}')) {
      --end;
      depth += (code[end] == ']' || code[end] == '}') - (code[end] == '[' || code[end] == '{');
    }
    skip_blanks();
    begin = end;
    while (begin > 0 && IsWordCharacter(code[begin - 1])) --begin;
  };
  Assigned assigned;
  find_word();
  const auto parts_end = static_cast<std::ptrdiff_t>(sign);
  size_t name_begin = begin, name_end = end;
  for (;;) {
    end = begin;
    skip_blanks();
    if (end == 0 || code[end - 1] != '.') break;
    --end;
    find_word();
    name_begin = begin, name_end = end;
  }
  assigned.at = name_begin;
  assigned.name = code.substr(name_begin, name_end - name_begin);
  assigned.parts = std::string(code.begin() + static_cast<std::ptrdiff_t>(name_end), code.begin() + parts_end);
  begin = end;
  while (begin > 0 && IsWordCharacter(code[begin - 1])) --begin;
  assigned.word = code.substr(begin, end - begin);
  return assigned;
}

size_t EndOfBracket(std::string_view code, size_t open) {
  int depth = 0;
  for (size_t i = open; i < code.size(); ++i) {
    depth += std::string_view("[{(").find(code[i]) != std::string_view::npos;
    depth -= std::string_view("]})").find(code[i]) != std::string_view::npos;
    if (depth == 0) return i + 1;
  }
  return std::string_view::npos;
}

namespace {

TextRange Trimmed(std::string_view code, size_t begin, size_t end) {
  while (begin < end && IsBlank(code[begin])) ++begin;
  while (end > begin && IsBlank(code[end - 1])) --end;
  return {begin, end};
}

}  // namespace

std::vector<TextRange> PartsOf(std::string_view code, size_t begin, size_t end) {
  std::vector<TextRange> parts;
  int depth = 0;
  size_t from = begin;
  for (size_t i = begin; i < end; ++i) {
    depth += std::string_view("[{(").find(code[i]) != std::string_view::npos;
    depth -= std::string_view("]})").find(code[i]) != std::string_view::npos;
    if (code[i] != ',' || depth != 0) continue;
    parts.push_back(Trimmed(code, from, i));
    from = i + 1;
  }
  parts.push_back(Trimmed(code, from, end));
  return parts;
}

bool NumberAt(std::string_view code, TextRange range, TextNumber* number) {
  std::string_view digits = code.substr(range.first, range.second - range.first);
  if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
  const std::optional<double> value = ParseNumber(digits);
  if (!value) return false;
  *number = {range.first, range.second, *value};
  return true;
}

std::string Quoted(std::string_view code, TextRange range) {
  constexpr size_t kLongest = 40;
  std::string text;
  for (size_t i = range.first; i < range.second; ++i) {
    const bool is_blank = IsBlank(code[i]);
    if (!is_blank || (!text.empty() && text.back() != ' ')) text += is_blank ? ' ' : code[i];
  }
  if (text.size() <= kLongest) return text;
  size_t end = kLongest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // inside a letter
  return text.substr(0, end) + "…";
}

std::string ExternalAxisInWords(const std::string& axis, std::string_view code, const TextNumber& value) {
  return "external axis " + axis + " stands at " + std::string(code.substr(value.begin, value.end - value.begin)) +
         ": where the arm's base is then, the file does not say";
}

ProgramMotion MotionTo(const std::string& command, const ProgramCode& code, TextRange target) {
  ProgramMotion motion;
  motion.name = command + " " + Quoted(code.text(), target);
  motion.line = code.LineAt(target.first);
  return motion;
}

std::vector<TextNumber> NumbersInBracket(std::string_view code, size_t open) {
  const size_t end = EndOfBracket(code, open);
  std::vector<TextNumber> numbers;
  if (end == std::string_view::npos) return numbers;
  for (const TextRange& part : PartsOf(code, open + 1, end - 1)) {
    TextNumber number;
    if (part.first < part.second && code[part.first] == '[') {
      const std::vector<TextNumber> inner = NumbersInBracket(code, part.first);
      if (inner.empty()) return {};
      numbers.insert(numbers.end(), inner.begin(), inner.end());
    } else if (NumberAt(code, part, &number)) {
      numbers.push_back(number);
    } else {
      return {};
    }
  }
  return numbers;
}

}  // namespace sagitta
