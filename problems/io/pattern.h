// Regular expressions that are compiled and searched in one source (pattern.cc): what <regex> makes of a search costs
// the compiler two seconds wherever it stands.
#pragma once

#include <regex>
#include <string>
#include <vector>

namespace sagitta {

// ECMAScript grammar.
std::regex MakePattern(const std::string& expression, bool ignores_case = false);

// Whether a part of the text fits, and what; as std::regex_search. `match` points into the text.
bool SearchPattern(const std::string& text, const std::regex& pattern);
bool SearchPattern(const std::string& text, std::smatch* match, const std::regex& pattern);
bool SearchPattern(std::string&& text, std::smatch* match, const std::regex& pattern) = delete;
bool SearchPattern(std::string::const_iterator begin, std::string::const_iterator end, std::smatch* match,
                   const std::regex& pattern);

// Whether the whole text fits.
bool MatchPattern(const std::string& text, const std::regex& pattern);
bool MatchPattern(const std::string& text, std::smatch* match, const std::regex& pattern);
bool MatchPattern(std::string&& text, std::smatch* match, const std::regex& pattern) = delete;

// Every part that fits replaced.
std::string ReplacePattern(const std::string& text, const std::regex& pattern, const std::string& format);

// One after the other; positions count from `begin`.
std::vector<std::smatch> AllMatches(std::string::const_iterator begin, std::string::const_iterator end,
                                    const std::regex& pattern);

}  // namespace sagitta
