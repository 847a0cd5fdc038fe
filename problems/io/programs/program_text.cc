#include "problems/io/programs/program_text.h"

#include <algorithm>

#include "problems/io/units.h"

namespace sagitta {

std::string WithoutComments(const std::string& text, const std::string& comment, char quote) {
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

int LineAt(const std::string& text, size_t position) {
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(position), '\n'));
}

std::string UpperCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
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
  const auto is_blank = [&](size_t i) { return std::isspace(static_cast<unsigned char>(code[i])) != 0; };
  while (begin < end && is_blank(begin)) ++begin;
  while (end > begin && is_blank(end - 1)) --end;
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
    const bool is_blank = std::isspace(static_cast<unsigned char>(code[i])) != 0;
    if (!is_blank || (!text.empty() && text.back() != ' ')) text += is_blank ? ' ' : code[i];
  }
  return text.size() > kLongest ? text.substr(0, kLongest) + "…" : text;
}

std::string ExternalAxisInWords(const std::string& axis, std::string_view code, const TextNumber& value) {
  return "external axis " + axis + " stands at " + std::string(code.substr(value.begin, value.end - value.begin)) +
         ": where the arm's base is then, the file does not say";
}

ProgramMotion MotionTo(const std::string& command, const std::string& code, TextRange target) {
  ProgramMotion motion;
  motion.name = command + " " + Quoted(code, target);
  motion.line = LineAt(code, target.first);
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
