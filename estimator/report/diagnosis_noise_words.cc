#include "estimator/report/diagnosis_noise_words.h"

#include <cmath>
#include <vector>

#include "estimator/report/explanations_words.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kMostNamed = 6;

std::string NamesOf(const std::vector<WrongArrival>& arrivals) {
  std::vector<std::string> names;
  for (const WrongArrival& arrival : arrivals) names.push_back(arrival.configuration);
  return (names.size() == 1 ? "configuration " : "configurations ") + Enumerate(names, kMostNamed);
}

std::string ArrivalsInWords(const std::vector<WrongArrival>& arrivals) {
  std::vector<std::string> sizes;
  for (const WrongArrival& arrival : arrivals)
    sizes.push_back(arrival.configuration + " (" + InMillimetres(arrival.off) + ")");
  return "All readings of a shot are off together in " + Enumerate(sizes, kMostNamed) +
         ", by far more than in any other, and were left out: check the joint values and the rows there. ";
}

// "13.8 urad (95 %: 12 to 15.5) of the joints that turn"; of_kind: where joints of the other kind deviate, too.
std::string SizeInWords(const FoundRepeatability& found, const char* micro, const std::string& of_kind) {
  const std::string interval = found.HasInterval() ? " (95 %: " + Significant(1e6 * found.low, 3) + " to " +
                                                         Significant(1e6 * found.high, 3) + ")"
                                                   : "";
  return Significant(1e6 * found.sigma, 3) + " " + micro + interval + of_kind;
}

// stated: else what is found.
std::string SizesInWords(const NoiseFinding& noise, bool stated) {
  const bool has_both = noise.turn.sigma > 0.0 && noise.travel.sigma > 0.0;
  std::vector<std::string> sizes;
  const auto add = [&](const FoundRepeatability& found, const char* micro, const char* of_kind) {
    if (!((stated ? found.stated : found.sigma) > 0.0)) return;
    sizes.push_back(stated ? Significant(1e6 * found.stated, 3) + " " + micro
                           : SizeInWords(found, micro, has_both ? of_kind : ""));
  };
  add(noise.turn, "urad", " of the joints that turn");
  add(noise.travel, "um", " of those that slide");
  return Enumerate(sizes);
}

std::string RepeatabilityInWords(const NoiseFinding& noise) {
  return "Joint repeatability of about " + SizesInWords(noise, false) + ", assumed to be that of every joint," +
         (noise.asks_repeatability            ? " is found, as asked. "
          : noise.repeatability_is_overstated ? " is found; more is stated. "
          : !noise.is_distinguished_from_pose
              ? " would explain what is left, and so would any error that follows the pose: no "
                "pose was visited again. "
                "Visit ten poses a second time to distinguish them. "
          : noise.is_bound ? " would explain what is left; it was not declared, and what has no name may be the cause. "
          : noise.IsRepeatabilityStated() ? " is found; " + SizesInWords(noise, true) + " are stated. "
                                          : " was not declared. ");
}

// "The noise of the readings of station S2 is 3 times what is stated (95 %: 2.8 to 3.2). "
std::string GroupsInWords(const NoiseFinding& noise) {
  std::string words;
  for (const GroupFinding& group : noise.groups) {
    words += "The noise of " + GroupInWords(group.kind, group.name) + " is " + Significant(group.factor, 3) +
             (noise.is_stated ? " times what is stated (95 %: " : " times that of the others (95 %: ") +
             Significant(group.low, 3) + " to " + Significant(group.high, 3) + "). ";
  }
  return words;
}

}  // namespace

std::string WrongNoiseInWords(const NoiseFinding& noise) {
  std::vector<std::string> wrong;
  if (noise.scale_differs || noise.repeatability_is_overstated) {
    wrong.push_back("the stated noise is wrong");
  } else {
    for (const GroupFinding& group : noise.groups) {
      if (group.is_finding)
        wrong.push_back("the stated noise of " + GroupInWords(group.kind, group.name) + " is wrong");
    }
  }
  if (noise.HasUndeclaredRepeatability() && !noise.repeatability_is_overstated) {
    wrong.push_back(noise.IsRepeatabilityStated() ? "the joints deviate more than is stated"
                                                  : "joint repeatability was not declared");
  }
  if (!noise.arrivals.empty()) wrong.push_back("all readings of a shot are off in " + NamesOf(noise.arrivals));
  if (noise.SingleOutliers() > 0) wrong.push_back("readings are outliers");
  return Enumerate(wrong);
}

std::string NoiseInWords(const NoiseFinding& noise) {
  std::string words;
  if (noise.scale_differs) {
    words += std::string(noise.groups.empty() ? "The instrument's noise" : "The noise of the other readings") +
             (noise.is_bound ? " is at most " : " is ") + Significant(noise.scale, 3) +
             " times what is stated (95 %: " + Significant(noise.low, 3) + " to " + Significant(noise.high, 3) +
             (noise.is_bound ? "): what has no name may be a part of it. " : "). ");
  }
  words += GroupsInWords(noise);
  if (noise.HasRepeatability()) {
    words += RepeatabilityInWords(noise);
  }
  if (!noise.arrivals.empty()) words += ArrivalsInWords(noise.arrivals);
  if (!noise.outliers.empty()) {
    words +=
        std::to_string(noise.outliers.size()) + (noise.outliers.size() == 1 ? " outlier" : " outliers") + " left out";
    if (noise.outliers_of_arrivals > 0) words += ", " + std::to_string(noise.outliers_of_arrivals) + " of them there";
    if (noise.outliers_held_out > 0) words += ", " + std::to_string(noise.outliers_held_out) + " of them held out";
    words += ". ";
  }
  if (!words.empty()) return words.substr(0, words.size() - 1);  // without the blank before another sentence
  if (!noise.is_stated) return "None is stated: it is the scatter about the extended model.";
  if (std::isnan(noise.high)) return "The noise is assumed to be as stated: nothing is left over to estimate it from.";
  return noise.is_bound ? "The noise is assumed to be as stated." : "The noise is as stated.";
}

}  // namespace sagitta
