#include "estimator/report/changes_words.h"

#include <algorithm>
#include <cmath>

#include "models/steel.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Three digits, or as many as show the interval: 4281.34 mm are known to 0.02.
int DigitsOf(const Change& change) {
  const double half = 0.5 * (change.ci95[1] - change.ci95[0]);
  if (!(half > 0.0) || !(std::abs(change.value) > half)) return 3;
  return std::clamp(1 + static_cast<int>(std::ceil(std::log10(std::abs(change.value) / half))), 3, 9);
}

// ", from 0.35 (-25 %)"
std::string FromInWords(const Change& change) {
  if (!(change.before > 0.0)) return "";
  const double percent = 100.0 * change.value / change.before;
  return ", from " + Significant(change.before, 3) + " (" + (percent > 0.0 ? "+" : "") + Significant(percent, 2) +
         " %)";
}

}  // namespace

std::string ChangeInWords(const Change& change) {
  const int digits = DigitsOf(change);
  const std::string size = Significant(change.value, digits) + " " + change.unit +
                           " (95 %: " + Significant(change.ci95[0], digits) + " to " +
                           Significant(change.ci95[1], digits) + ")";
  const std::string same = change.same.empty() ? "" : " (" + Enumerate(change.same, 8) + " would do the same)";
  switch (change.kind) {
    case ChangeKind::kJointZero:
      return "the zero of " + change.target + " moved by " + size;
    case ChangeKind::kTool:
      return "the tool with all its markers moved on the flange by " + size;
    case ChangeKind::kMarker:
      return "marker " + change.target + " was reseated: " + size;
    case ChangeKind::kMarkers:
      return "all markers on the flange were mounted anew, the one that moved most by " + size;
    case ChangeKind::kBase:
      return "the base, or the instrument of station " + change.target + ", moved by " + size;
    case ChangeKind::kScale: {
      // In ppm over ppm/K.
      const double kelvin = std::abs(change.value) / (1e6 * kSteelPerKelvin);
      return "all lengths changed by one share, " + size + ": by the instrument's scale or by the arm's temperature (" +
             Significant(kelvin, 2) + " K " + (change.value > 0.0 ? "warmer" : "colder") + ", of steel)";
    }
    case ChangeKind::kGeometry:
    case ChangeKind::kCompliance:
    case ChangeKind::kCompensator:
    case ChangeKind::kEffect:
      return WordOf(change.kind) + " " + change.target + " changed by " + size + FromInWords(change) + same;
  }
  return "";
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

std::string ComparedAtItsEnd(const std::string& old_file, const std::vector<std::string>& happened) {
  return old_file +
         " is compared as the robot was at its end, after what happened within it: " + Enumerate(happened, 8);
}

std::string ComparedAtItsBeginning(const std::string& new_file, const std::vector<std::string>& happened) {
  return new_file + " is compared as the robot was at its beginning; what happened within it is none of the changes: " +
         Enumerate(happened, 8);
}

std::string StationsAreOwn(const std::string& old_file, const std::string& new_file) {
  return "no station of " + old_file + " is in " + new_file + ": nothing is said of where the instrument stands";
}

std::string MarkersAreOwn(const std::string& old_file, const std::string& new_file) {
  return "no marker of " + old_file + " is in " + new_file + ": nothing is said of the tool";
}

std::string ZerosAreHidden(const std::vector<std::string>& joints) {
  return "not seen in these points: a slip of " + Enumerate(joints, 8);
}

std::string ZerosAreHidden(const std::vector<std::string>& joints, const std::vector<ChangeKind>& motions) {
  const auto bases = std::count(motions.begin(), motions.end(), ChangeKind::kBase);
  std::vector<std::string> moved;
  if (bases > 0) moved.push_back(bases > 1 ? "the bases" : "the base");
  if (static_cast<size_t>(bases) < motions.size()) moved.push_back("the tool");
  return "a slip of " + Enumerate(joints, 8) + " would be a part of what " + Enumerate(moved) + " moved";
}

std::string TooFarApart(const std::string& old_file, const std::string& new_file) {
  return "no changes found that lead from " + old_file + " to " + new_file +
         ": joint zeros, base, tool and up to six parameters were fitted in turn and did not settle; another robot, "
         "too much of it changed, or an estimate is less certain than it says";
}

std::string LacksSomething(const std::string& file, double factor) {
  return file + " has model error (" + Significant(factor, 2) +
         " times on its intervals): its robot does what the model lacks. Where only one of the two estimates has it, "
         "as "
         "after a new gear, it can be named as a change of geometry or base: 'sagitta diagnose' on those rows says "
         "what "
         "it is";
}

std::string ConfigurationsErr(const std::string& file, double factor) {
  return "whole configurations of " + file +
         " err by more than noise (random halves of them differ, or points of one shot err alike): another campaign "
         "differs by " +
         Significant(factor, 2) +
         " times what noise makes, and its covariance is that much wider here. Where it is joints that scatter, "
         "'repeatability_urad: estimate' in both calibrations shows smaller changes";
}

std::string RegionsDiffer(const std::string& joint, double share, double model_error) {
  return "the two campaigns have only " + Significant(1e2 * share, 2) + " % of the wider range of " + joint +
         " in common and are compared there. What the model lacks, " + Significant(1e3 * model_error, 2) +
         " mm RMS as far as they show, can look like a change of any parameter in one region alone: only larger "
         "changes are named. Campaigns over the same ranges show smaller ones";
}

std::string OneLoadDoesThatToo(double least, double most) {
  return "the compliances changed by alike shares (" + Significant(1e2 * least, 2) + " to " +
         Significant(1e2 * most, 2) + " %): a load that is " + (most > 0.0 ? "heavier" : "lighter") +
         " than stated by that share does the same";
}

std::string MoreIsLeft(double rms) {
  return "more is left (" + Significant(1e3 * rms, 3) +
         " mm RMS) than both estimates leave open: something changed that is not named, or one of them claims to be "
         "surer than it is";
}

}  // namespace sagitta
