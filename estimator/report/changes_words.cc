#include "estimator/report/changes_words.h"

#include "problems/text.h"

namespace sagitta {

std::string ChangeInWords(const Change& change) {
  const std::string size = Significant(change.value, 3) + " " + change.unit +
                           " (95 %: " + Significant(change.ci95[0], 3) + " to " + Significant(change.ci95[1], 3) + ")";
  switch (change.kind) {
    case ChangeKind::kJointZero:
      return "the zero of " + change.target + " moved by " + size;
    case ChangeKind::kTool:
      return "the tool with all its markers moved on the flange by " + size;
    case ChangeKind::kMarker:
      return "marker " + change.target + " was reseated: " + size;
    case ChangeKind::kBase:
      return "the base, or the instrument of station " + change.target + ", moved by " + size;
    default:
      return WordOf(change.kind) + " " + change.target + " changed by " + size;
  }
}

std::string TurnedInWords(double angle_mrad) { return ", turned by " + Significant(angle_mrad, 3) + " mrad"; }

std::string ChangesInWords(const Changes& changes) {
  if (changes.changes.empty()) {
    return "Nothing changed beyond what both estimates leave open (probability " + Significant(changes.nothing, 3) +
           ").";
  }
  std::vector<std::string> sentences;
  for (const Change& change : changes.changes) {
    sentences.push_back(change.words + " (probability " + Significant(change.probability, 3) + ")");
  }
  return "What changed: " + Enumerate(sentences) + ".";
}

std::string ChangesOpen(const std::string& file, const std::vector<std::string>& parameters) {
  return "estimated in " + file +
         ", assumed in the other, so no change of it is determined: " + Enumerate(parameters, 8);
}

}  // namespace sagitta
