#include "tools/report/remedies.h"

#include <algorithm>
#include <map>

#include "problems/text.h"

namespace sagitta {

std::vector<std::string> GroupedByRemedy(const std::vector<WordsAndRemedy>& sentences, size_t shown) {
  std::vector<std::string> remedies;  // in the order in which they appear
  std::map<std::string, std::vector<std::string>> of_remedy;
  for (const auto& [words, remedy] : sentences) {
    if (of_remedy.count(remedy) == 0) remedies.push_back(remedy);
    of_remedy[remedy].push_back(words);
  }
  std::vector<std::string> lines;
  for (const std::string& remedy : remedies) {
    const std::vector<std::string>& words = of_remedy[remedy];
    std::string line =
        "- " + Joined({words.begin(), words.begin() + static_cast<long>(std::min(shown, words.size()))}, "; ");
    if (words.size() > shown) line += "; and " + std::to_string(words.size() - shown) + " more like these";
    lines.push_back(line + ". Remedy: " + remedy + ".");
  }
  return lines;
}

std::vector<std::string> DirectionsInWords(const std::vector<Direction>& directions, size_t shown) {
  std::vector<WordsAndRemedy> sentences;
  for (const Direction& direction : directions) sentences.emplace_back(direction.words, direction.remedy);
  return GroupedByRemedy(sentences, shown);
}

}  // namespace sagitta
