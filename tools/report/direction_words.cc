#include "tools/report/direction_words.h"

#include <algorithm>
#include <map>

namespace sagitta {

std::vector<std::string> DirectionsInWords(const std::vector<Direction>& directions, size_t shown) {
  std::vector<std::string> remedies;  // in the order in which they appear
  std::map<std::string, std::vector<std::string>> of_remedy;
  for (const Direction& direction : directions) {
    if (of_remedy.count(direction.remedy) == 0) remedies.push_back(direction.remedy);
    of_remedy[direction.remedy].push_back(direction.words);
  }
  std::vector<std::string> lines;
  size_t left = directions.size();
  for (size_t r = 0; r < std::min(shown, remedies.size()); ++r) {
    const std::vector<std::string>& words = of_remedy[remedies[r]];
    std::string line = "- ";
    for (size_t i = 0; i < std::min(shown, words.size()); ++i) line += (i == 0 ? "" : "; ") + words[i];
    if (words.size() > shown) line += "; and " + std::to_string(words.size() - shown) + " more like these";
    lines.push_back(line + ". Remedy: " + remedies[r] + ".");
    left -= words.size();
  }
  if (left > 0) lines.push_back("- and " + std::to_string(left) + " more, in estimate.json under identifiability");
  return lines;
}

}  // namespace sagitta
