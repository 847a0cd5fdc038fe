#include "estimator/report/diagnosis_next_words.h"

#include <algorithm>
#include <vector>

#include "estimator/report/diagnosis_words.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kRivalsInWords = 2;  // all are in diagnosis.json

// "A (51 %), B with C (5 %) and 2 others (4 %)": what all of them hold is not repeated.
std::string RivalsInWords(const Robot& robot, const std::vector<NamedSet>& rivals) {
  std::vector<std::vector<std::string>> names;
  for (const NamedSet& rival : rivals) names.push_back(NamesOf(robot, rival));
  const auto all_hold = [&](const std::string& name) {
    return std::all_of(names.begin(), names.end(), [&](const std::vector<std::string>& own) {
      return std::find(own.begin(), own.end(), name) != own.end();
    });
  };
  const size_t said = rivals.size() == kRivalsInWords + 1 ? rivals.size() : std::min(rivals.size(), kRivalsInWords);
  std::vector<std::string> words;
  bool is_shared = false;
  double others = 0.0;
  for (size_t k = 0; k < rivals.size(); ++k) {
    others += k < said ? 0.0 : rivals[k].probability;
    std::vector<std::string> own;
    for (const std::string& name : names[k]) {
      if (!all_hold(name)) own.push_back(name);
    }
    is_shared = is_shared || own.size() < names[k].size();
    const std::string nothing = names[k].empty() ? "no effect" : "nothing more";
    const std::string alone = names[k].size() == 1 && own.size() == 1 ? " alone" : "";
    if (k < said)
      words.push_back((own.empty() ? nothing : WithOneAnother(own) + alone) + " (" + Percent(rivals[k].probability) +
                      ")");
  }
  if (said < rivals.size()) {
    words.push_back(std::to_string(rivals.size() - said) + " others (" + Percent(others) + ")");
  }
  return Enumerate(words) + (is_shared ? ", given what all of them hold" : "");
}

// Why these probabilities are not those of the sets of diagnosis.json.
std::string PiecesInWords(const NextPoses& next) {
  return next.counts_pieces ? " An effect that may be a piece of what has no name counts here as an effect of its own, "
                              "for no pose distinguishes the two: 'sets' of diagnosis.json has both readings."
                            : "";
}

std::string NeededInWords(const NextPoses& next) {
  const std::string wanted = WholePercent(kWanted);
  if (next.needed == 0) {
    return " Even " + std::to_string(kMostNeeded) + " poses chosen like these would not reach " + wanted + ": " +
           (next.again ? "more markers, more readings of each or an instrument of less noise are needed."
            : next.depends_on_when
                ? "the same poses on another day, or with the arm some kelvin warmer, are more informative."
                : "a heavier load, another marker or another station is more informative.");
  }
  if (next.needed <= static_cast<int>(next.poses.size())) return "";
  return " About " + std::to_string(next.needed) + " poses chosen like these would reach " + wanted + ".";
}

// Poses that are visited again.
std::string AgainInWords(const Measurements& data, const NextPoses& next) {
  std::vector<std::string> names;
  for (const ProposedPose& pose : next.poses) names.push_back(data.configurations[pose.like].id);
  return "Visit these poses again: " + Enumerate(names, names.size()) + " (" + kNextFile +
         ", to be filled in and added to the measurements). Of joints that deviate at every visit and an error that "
         "follows the pose, the right one is expected to have " +
         Percent(next.decides) + " then, if both are as probable now." + NeededInWords(next);
}

}  // namespace

std::vector<std::string> NamesOf(const Robot& robot, const NamedSet& set) {
  std::vector<std::string> names;
  for (const EffectSpec& spec : set.specs) names.push_back(Title(robot, spec));
  names.insert(names.end(), set.unnamed.begin(), set.unnamed.end());
  return names;
}

std::string WithOneAnother(const std::vector<std::string>& names) {
  if (names.size() < 2) return Enumerate(names);
  return names[0] + " with " + Enumerate({names.begin() + 1, names.end()});
}

std::string NextInWords(const CalibrationProblem& problem, const NextPoses& next, bool is_consistent) {
  if (next.again) return AgainInWords(problem.data(), next);
  const std::string poses = std::to_string(next.poses.size()) + (next.poses.size() == 1 ? " pose" : " poses");
  return (is_consistent ? "Nothing has to be measured for this verdict. To exclude what is possible all the same, "
                          "measure the "
                        : "Measure the ") +
         poses + " of " + kNextFile + ": fill in that file and add it to the measurements. To decide between " +
         RivalsInWords(problem.robot(), next.rivals) + ": whichever of these is right is expected to have " +
         Percent(next.decides) + " of what they have together (" + Percent(next.of_probability) + ") then; now " +
         Percent(next.decided) + "." + PiecesInWords(next) + NeededInWords(next);
}

}  // namespace sagitta
