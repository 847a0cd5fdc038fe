#include "problems/io/pattern.h"

namespace sagitta {

std::regex MakePattern(const std::string& expression, bool ignores_case) {
  return std::regex(expression, ignores_case ? std::regex::ECMAScript | std::regex::icase : std::regex::ECMAScript);
}

bool SearchPattern(const std::string& text, const std::regex& pattern) { return std::regex_search(text, pattern); }

bool SearchPattern(const std::string& text, std::smatch* match, const std::regex& pattern) {
  return std::regex_search(text, *match, pattern);
}

bool SearchPattern(std::string::const_iterator begin, std::string::const_iterator end, std::smatch* match,
                   const std::regex& pattern) {
  return std::regex_search(begin, end, *match, pattern);
}

bool MatchPattern(const std::string& text, const std::regex& pattern) { return std::regex_match(text, pattern); }

bool MatchPattern(const std::string& text, std::smatch* match, const std::regex& pattern) {
  return std::regex_match(text, *match, pattern);
}

std::string ReplacePattern(const std::string& text, const std::regex& pattern, const std::string& format) {
  return std::regex_replace(text, pattern, format);
}

std::vector<std::smatch> AllMatches(std::string::const_iterator begin, std::string::const_iterator end,
                                    const std::regex& pattern) {
  return {std::sregex_iterator(begin, end, pattern), std::sregex_iterator()};
}

}  // namespace sagitta
