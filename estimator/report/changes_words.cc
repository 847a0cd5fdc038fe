#include "estimator/report/changes_words.h"

#include "problems/text.h"

namespace sagitta {

std::string ChangeInWords(const Change& change) {
  const std::string size = Significant(change.value, 3) + " " + change.unit +
                           " (95 %: " + Significant(change.ci95[0], 3) + " to " + Significant(change.ci95[1], 3) + ")";
  if (change.what == "joint_zero") return "the zero of " + change.target + " moved by " + size;
  if (change.what == "tool") return "the tool with all its markers moved on the flange by " + size;
  if (change.what == "marker") return "marker " + change.target + " was reseated: " + size;
  if (change.what == "base") {
    return "the base, or the instrument of station " + change.target + ", moved by " + size;
  }
  return change.what + " " + change.target + " changed by " + size;
}

std::string ChangesOpen(const std::string& file, const std::vector<std::string>& parameters) {
  return "estimated in " + file + ", assumed in the other, so no change of it is told: " + Enumerate(parameters, 8);
}

}  // namespace sagitta
