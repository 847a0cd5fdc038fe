#include "estimator/report/planning_words.h"

#include <algorithm>
#include <cmath>

#include "problems/text.h"

namespace sagitta {

std::string InWords(CriterionKind kind) {
  switch (kind) {
    case CriterionKind::kI:
      return "mean squared position error at the test poses after compensation";
    case CriterionKind::kD:
      return "volume of the confidence ellipsoid of the robot's parameters";
    case CriterionKind::kA:
      return "sum of the variances of the robot's parameters, scaled";
    case CriterionKind::kE:
      return "largest variance of any direction of the robot's parameters, scaled";
    case CriterionKind::kDiscriminate:
      return "information about which of the stated effects it is";
    case CriterionKind::kO1:
    case CriterionKind::kO2:
    case CriterionKind::kO3:
    case CriterionKind::kO4:
    case CriterionKind::kO5:
      return "observability index " + WordOf(kind) + " (Sun and Hollerbach 2008)";
  }
  return "";
}

std::string OrderIsMixed() {
  return "The order is mixed at random, so that what goes with time is not mistaken for what goes with the place. "
         "Poses with times of their own are in the order of these.";
}

std::string OrderIsShort(double share) {
  return "The order is a short way: nearest neighbours, stretches reversed and poses moved while that shortens it; " +
         WholePercent(share) + " of the way in the order in which poses were found.";
}

std::string JudgedInItsOrder(const std::vector<std::string>& effects, double searched, double written, double asked) {
  std::string words =
      "What " + Enumerate(effects) +
      " does goes with what is measured before. What is predicted holds for the order of plan.csv, and for "
      "its times where it states them: " +
      InMillimetres(written) +
      " at the test poses. Poses are chosen, and certificate and curve of the "
      "accuracy hold, for each candidate after its neighbours in their list: " +
      InMillimetres(searched) + ".";
  if (asked > 0.0 && written > asked) {
    words += " The order leaves more than the " + InMillimetres(asked) + " that were asked for: plan with more poses.";
  }
  return words;
}

namespace {

// Why the model error that was given is no part of the plan.
void AddFormerInWords(const Plan& plan, std::vector<std::string>* words) {
  if (plan.field_amplitude > 0.0) return;
  const std::string factor =
      plan.model_error > 1.0 ? "its factor alone counts." : "predicted errors hold as far as the model is true.";
  switch (plan.former.kind) {
    case FormerMisfit::Kind::kNone:
      return;
    case FormerMisfit::Kind::kMeasured:
      words->push_back(
          plan.field > 0.0
              ? "No smooth deviation of the joints leaves the error that the former estimate shows: " + factor
              : "Points that the former estimate had not fitted are off by no more than its noise explains: " + factor);
      return;
    case FormerMisfit::Kind::kWithinChance: {
      const FormerMisfit& former = plan.former;
      const std::string by = former.p_value ? " (p = " + Significant(*former.p_value, 2) + ")" : "";
      words->push_back("Points that the former estimate had not fitted are off by " + InMillimetres(former.rms) +
                       " per coordinate where it predicts " + InMillimetres(former.predicted) +
                       ": no more than noise and chance explain" + by + ". No model error is seen, and " + factor);
      return;
    }
    case FormerMisfit::Kind::kNotCompared:
      words->push_back(
          "The former estimate has no cross-validation, no noise to compare it with, or no p-value and degrees of "
          "freedom to test it by: the plan does not know by how much its model is off, and " +
          factor);
      return;
    case FormerMisfit::Kind::kInRepeatability:
      words->push_back(
          "The former estimate found the repeatability of the joints from its residuals, so that what its model lacks "
          "is "
          "part of it: the plan does not know by how much the model is off, and " +
          factor + " Calibrate the former rows with a stated repeatability, or none, for a model error.");
      return;
  }
}

}  // namespace

std::vector<std::string> AssumptionsInWords(const Plan& plan, bool candidates_are_drawn) {
  std::vector<std::string> words;
  words.push_back("Checked of each pose: " + Enumerate(plan.checked) + ". Not checked: " + Enumerate(plan.not_checked) +
                  ".");
  if (candidates_are_drawn) {
    words.push_back(
        "Candidates are poses spread evenly in the joint limits, each with every way in which the rows measure one" +
        std::string(plan.found_given_measured > 0 ? ", and better ones found from them by local search." : "."));
  }
  if (plan.moved) words.push_back("The poses chosen were moved to where they determine more.");
  words.push_back(plan.order);
  if (plan.knee > 0) {
    words.push_back("From " + std::to_string(plan.knee) + (plan.knee == 1 ? " pose" : " poses") +
                    " on, more poses only average the noise (the error falls no faster than N^-0.6).");
  }
  if (plan.field_amplitude > 0.0) {
    words.push_back(
        "The former estimate is off by " + Significant(1e3 * plan.field, 2) +
        " mm per coordinate more than it predicts at points it has not fitted. The plan assumes that to be an "
        "unknown smooth deviation of every joint over its angle (harmonics 1 to 4, " +
        Significant(1e6 * plan.field_amplitude, 2) + " urad each).");
  } else if (plan.model_error > 1.0) {
    words.push_back("With the model error of the estimate that was given, predicted errors are larger by " +
                    Significant(plan.model_error, 3) + ".");
  }
  AddFormerInWords(plan, &words);
  std::vector<std::string> not_determined;
  for (const PlannedParameter& parameter : plan.parameters) {
    if (!parameter.identifiable) not_determined.push_back(parameter.name);
  }
  if (!not_determined.empty()) words.push_back("The plan does not determine " + Enumerate(not_determined, 6) + ".");
  return words;
}

std::string RegisteredOnTests(int unknowns, int coordinates, int left) {
  const std::string begin = "Stations and markers that only the test poses see are registered on the test poses: ";
  const std::string of = std::to_string(coordinates) + " coordinates there";
  if (left == 0) {
    return begin + std::to_string(unknowns) + " unknowns leave nothing of the " + of + ", which do not count.";
  }
  return begin + "of the " + of + " " + std::to_string(left) +
         " are left. Errors there are what is left, as a mean over these.";
}

std::string PlacesFitReadings() {
  return "Base and markers are those that fit the readings best with the robot as its file states it.";
}

std::string PlacesAreStated() {
  return "Base, markers and robot are assumed to be as the files state them: no row has a reading.";
}

std::string PatternsLeftOut(int left_out, int offered) {
  return "The rows show " + std::to_string(left_out) + " more ways to measure a pose than the " +
         std::to_string(offered) + " most frequent ones that are offered.";
}

std::string FewTestPoses(size_t poses, bool are_drawn) {
  const std::string count = poses == 1 ? "one pose" : std::to_string(poses) + " poses";
  if (are_drawn) {
    return "The rows are of " + count +
           " alone: the accuracy is asked at poses drawn in the joint limits (state others: --tests=FILE).";
  }
  return "All test points are of " + count +
         ": the accuracy predicted holds there (state others: --tests=FILE, or random).";
}

std::string FewTestPosesDrawn(size_t poses) {
  return "Only " + (poses == 1 ? std::string("one test pose") : std::to_string(poses) + " test poses") +
         " could be drawn that keep to the cell: the accuracy predicted holds there (state others: --tests=FILE).";
}

std::string RowsWithoutReading(size_t rows) {
  return (rows == 1 ? std::string("One row has") : std::to_string(rows) + " rows have") + " no reading and " +
         (rows == 1 ? "does" : "do") + " not count as measured.";
}

std::string CandidatesLack(const std::vector<std::string>& what) {
  return "The candidates are measured as their own rows say, none of which has " + Enumerate(what) +
         " of the experiment: give a row for each marker, station and load to plan with them.";
}

std::string CandidatesStateNoSigma(int rows) {
  return (rows == 1 ? std::string("One row of the candidates states")
                    : std::to_string(rows) + " rows of the candidates state") +
         " no standard deviation: that of the experiment's rows counts, the root mean square per axis of the same "
         "marker from the same station.";
}

std::string SigmasOfAlikeRowsDiffer(double least, double largest) {
  return "Rows that are measured alike state standard deviations from " + InMillimetres(least) + " to " +
         InMillimetres(largest) + ": a planned pose counts with their root mean square, which plan.csv states.";
}

std::string ConditionsAreAssumed(bool time, bool temperature) {
  const std::string what = time && temperature ? "time and temperature" : time ? "the time" : "the temperature";
  return "Effects of the robot go with " + what + ". Each pose is assumed to be measured at " + what +
         " of a row that is measured like it, and plan.csv states which: put in those at which it is measured. Far "
         "from the assumed ones such effects may be several times less well known than predicted.";
}

std::string RepeatabilityIsNotCounted() {
  return "The repeatability of the joints is to be estimated, and nothing states it: the plan counts none. Joints that "
         "scatter leave larger errors than predicted; state repeatability_urad: NUMBER in the experiment file to count "
         "it.";
}

std::string BestWeightsAreAssumed(Weights weights) {
  return "The experiment states weights: " + WordOf(weights) +
         ". The plan counts the best weights, those of the noise (weights: sigma): a calibration by the others leaves "
         "larger errors than predicted, several times where standard deviations differ by much.";
}

std::string NothingIsHeldOut(const std::string& why) {
  return "No row has a reading yet, and the validation that the experiment states does not divide them (" + why +
         "): the plan holds none out.";
}

std::string BodiesAreNotStated() {
  return "collisions of the arm's body with itself and the cell (no capsules are stated)";
}

std::string BoxesAreNotStated() { return "obstacles (no keep-out boxes are stated)"; }

std::string CurveInWords(const Plan& plan) {
  std::string words = "Plans of as many poses, by a brief search among the candidates";
  const int poses = static_cast<int>(plan.rows.configurations.size());
  for (const PosesAndAccuracy& point : plan.curve) {
    if (point.poses != poses || point.position_rms <= plan.position_rms) continue;
    words += ". The plan itself was searched for longer" + std::string(plan.moved ? ", and its poses were moved" : "") +
             ": " + Significant(1e3 * plan.position_rms, 3) + " mm instead of " +
             Significant(1e3 * point.position_rms, 3) + " mm";
  }
  return words + ".";
}

std::string CertificateInWords(const Plan& plan) {
  if (!plan.criterion.HasCertificate()) {
    return "The criterion " + WordOf(plan.criterion.kind) +
           " is not convex or has no slope: how near the plan is to the best one is not known. Use I, D, A, O1 or O5 "
           "for a certificate.";
  }
  const double efficiency = plan.efficiency;
  const double times = 1.0 / std::max(efficiency, 1e-9);
  // So few poses that the bound says little: a percentage of thousands would be read as a misprint.
  const std::string near = times < 2.0 ? "Within " + Significant(100.0 * (times - 1.0), 2) + " % of"
                                       : "At most " + Significant(times, 2) + " times";
  std::string words = near + " the best possible plan of as many of these candidates" +
                      (plan.found_given_measured > 0 ? " and of poses found from them" : "") + " (" +
                      InWords(plan.criterion.kind) + "; equivalence theorem).";
  if (plan.best_rms > 0.0) {
    words += " No such plan predicts less than " + InMillimetres(plan.best_rms) +
             " at the test poses; this one predicts " + InMillimetres(std::sqrt(plan.cost)) +
             (plan.field_amplitude > 0.0 ? ", model error included." : ".");
  }
  return words;
}

std::string SeparationInWords() {
  return "the information that the readings give on which effect it is, at most ln 2, and the probability that the "
         "right one is expected to have after them, from 0.5; each effect of the size that the robot "
         "file states, else of one that moves its joint by 0.1 mm or 0.1 mrad";
}

std::string BelowItsLimit(const std::string& joint) { return "joint " + joint + " is below its limit"; }

std::string AboveItsLimit(const std::string& joint) { return "joint " + joint + " is above its limit"; }

std::string OutsideItsRange(const std::string& joint) { return "joint " + joint + " is outside its range in the cell"; }

std::string AtNoneOfItsLevels(const std::string& joint) { return "joint " + joint + " is at none of its levels"; }

std::string LeavesItsBoxes(const std::string& what) { return what + " leaves the boxes to stay in"; }

std::string OutOfRange(const std::string& marker, const std::string& station) {
  return "marker " + marker + " is out of the range of " + station;
}

std::string OutOfElevations(const std::string& marker, const std::string& station) {
  return "marker " + marker + " is out of the elevations of " + station;
}

std::string FacesAway(const std::string& reflector, const std::string& station) {
  return "reflector " + reflector + " does not face " + station;
}

std::string StandsBetween(const std::string& body, const std::string& station, const std::string& marker) {
  return body + " stands between " + station + " and marker " + marker;
}

std::string FloorIsChecked(const std::string& of_what) { return "the floor, " + of_what + "flange and markers"; }

std::string StayInIsChecked() { return "that flange and markers stay in their boxes"; }

std::string KeepOutIsChecked(const std::string& of_what) {
  return "collisions with boxes, " + of_what + "flange and markers";
}

std::string CapsulesAreChecked() { return "collisions of the capsules with one another"; }

std::string SightIsChecked(const std::string& station) {
  return "range, elevation and line of sight of station " + station;
}

std::string SightsAreOpen(const std::string& stations) { return "lines of sight of station " + stations; }

std::string WaysAreOpen() { return "the way from one pose to the next"; }

std::string HasNoEquilibrium() { return "the load folds the arm: no equilibrium"; }

}  // namespace sagitta
