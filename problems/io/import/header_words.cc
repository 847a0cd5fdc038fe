#include "problems/io/import/header_words.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "problems/io/trimmed.h"
#include "problems/text.h"
#include "problems/unit_words.h"

namespace sagitta {
namespace {

// Units that nobody uses as a name's last word by accident.
bool MayFollowAName(const std::string& word) {
  return word != "c" && word != "n" && word != "sec" && word != "s" && word != "°c";
}

std::string WithoutBars(const std::string& text) { return std::string(Trimmed(text, " \t_")); }

// {name as written, unit}; the unit "" where none is stated.
std::pair<std::string, std::string> Separated(const std::string& header) {
  const std::string text = WithoutBars(header), lower = LowerCaseOf(text);  // of equal length
  for (const auto& [open, close] : {std::pair<char, char>('[', ']'), {'(', ')'}}) {
    const size_t first = lower.rfind(open), last = lower.rfind(close);
    if (first == std::string::npos || last == std::string::npos || last < first) continue;
    const std::string unit = SpellingOfUnit(WithoutBars(lower.substr(first + 1, last - first - 1)));
    if (!unit.empty()) return {WithoutBars(text.substr(0, first) + text.substr(last + 1)), unit};
  }
  for (const char* mark : {"_", " ", "/", "."}) {
    const size_t at = lower.rfind(mark);
    if (at == std::string::npos || at == 0) continue;
    const std::string last = lower.substr(at + 1);
    const std::string unit = SpellingOfUnit(last);
    if (!unit.empty() && MayFollowAName(last)) return {WithoutBars(text.substr(0, at)), unit};
    if ((last == "s" || last == "n") && *mark == '_') return {WithoutBars(text.substr(0, at)), last == "s" ? "s" : "N"};
  }
  return {text, ""};
}

}  // namespace

std::string UnitInHeader(const std::string& header) { return Separated(header).second; }

bool IsUnit(const std::string& word) {
  const std::string lower = LowerCaseOf(WithoutBars(word));
  return !SpellingOfUnit(lower).empty() || IsUnreadUnit(lower);
}

NameWithUnreadUnit UnreadUnitIn(const std::string& header) {
  const std::string text = WithoutBars(header), lower = LowerCaseOf(text);
  if (text.empty() || !UnitInHeader(header).empty()) return {};
  for (const auto& [open, close] : {std::pair<char, char>('[', ']'), {'(', ')'}}) {
    const size_t first = text.rfind(open);
    if (text.back() != close || first == std::string::npos || first + 2 >= text.size()) continue;
    const std::string inside = text.substr(first + 1, text.size() - first - 2);
    if (inside.find_first_of("0123456789") != std::string::npos) continue;  // an index
    return {WithoutBars(text.substr(0, first)), inside};
  }
  const size_t at = lower.find_last_of("_ ");
  if (at == std::string::npos || !IsUnreadUnit(lower.substr(at + 1))) return {};
  return {WithoutBars(text.substr(0, at)), text.substr(at + 1)};
}

std::string StemOf(const std::string& header) { return Separated(header).first; }

std::string NameWithoutUnit(const std::string& header) { return LowerCaseOf(Separated(header).first); }

std::vector<std::string> WordsOf(const std::string& name) {
  std::vector<std::string> words;
  enum class Kind { kNone, kLower, kUpper, kDigit } before = Kind::kNone;
  for (const char raw : name) {
    const unsigned char c = static_cast<unsigned char>(raw);
    const Kind kind = std::isdigit(c)                ? Kind::kDigit
                      : std::isupper(c)              ? Kind::kUpper
                      : std::isalpha(c) || c >= 0x80 ? Kind::kLower
                                                     : Kind::kNone;
    const bool starts = kind != before && !(before == Kind::kUpper && kind == Kind::kLower);
    if (kind != Kind::kNone) {
      if (starts || words.empty()) words.emplace_back();
      words.back() += static_cast<char>(c < 0x80 ? std::tolower(c) : c);
    }
    before = kind;
  }
  return words;
}

bool Has(const std::vector<std::string>& words, const std::set<std::string>& set) {
  return std::any_of(words.begin(), words.end(), [&set](const std::string& word) { return set.count(word) > 0; });
}

const std::vector<std::string>& WrenchNames() {
  static const std::vector<std::string> kNames = {"fx", "fy", "fz", "mx", "my", "mz"};
  return kNames;
}

int AxisNamed(const std::string& word) {
  const size_t axis = std::string("xyz").find(word);
  return word.size() == 1 && axis != std::string::npos ? static_cast<int>(axis) : -1;
}

}  // namespace sagitta
