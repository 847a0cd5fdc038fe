#include "estimator/report/results_words.h"

#include <fmt/format.h>

#include "estimator/report/compensation_words.h"
#include "estimator/results/estimate_json.h"
#include "estimator/results/remembering_effects.h"
#include "models/constants.h"
#include "problems/io/programs/robot_program.h"
#include "problems/text.h"

namespace sagitta {
namespace {

std::string Points(int number) { return std::to_string(number) + (number == 1 ? " point" : " points"); }

// Configurations from which on 95 % regions of predicted points hold 93 % and more where the covariance is found from
// them: of simulated arms of four to six joints 81.5 [77.9, 84.7] (12), 82.5 (15), 84.7 (20), 90.0 [87.3, 92.3] (30)
// and 93.2 [90.6, 95.4] % (60).
constexpr double kManyClusters = 60.0;

std::string Named(const std::string& name) { return name.empty() ? "none" : name; }

}  // namespace

std::string WhatTheWayDoes(const KnownRobot& known) {
  const std::vector<std::string> effects = RememberingEffectsOfTheArm(known);
  return effects.empty() ? "" : TargetsAreAWay(effects);
}

std::string WhatFiguresCarry(const KnownRobot& known) {
  std::string words;
  if (known.model_error > 1.0) {
    words = "Standard deviations carry the model error that the calibration found: those of the parameters are about " +
            Significant(known.model_error, 2) + " times as large as noise alone makes them (model_error in " +
            known.file + ").";
  }
  if (known.rest > 0.0) {
    words += std::string(words.empty() ? "" : " ") +
             "No point is said to be better known than what the calibration left on points that were not fitted, " +
             InMillimetres(known.rest) + " RMS beyond what the stated noise and parameters explain.";
  }
  if (known.clusters > 0.0 && known.clusters < kManyClusters) {
    words +=
        std::string(words.empty() ? "" : " ") + "The covariance was found from " + Significant(known.clusters, 6) +
        " configurations (sandwich or bootstrap), whose own scatter no 95 % region of a point allows for: of "
        "simulated calibrations with 12 to 20 configurations such regions held 82 to 85 %, with 30 they held 90 %, "
        "with 60 they held 93 %. covariance: model has no such limit (with repeatability_urad: estimate where "
        "joints scatter).";
  }
  return words;
}

namespace {

std::string ShotsBeyond(size_t beyond, size_t shots) {
  return fmt::format("{} of {} {} {}", beyond, shots, shots == 1 ? "shot" : "shots", beyond == 1 ? "is" : "are");
}

std::string NothingHasChecked(const std::vector<std::string>& effects) {
  return ": nothing has checked " + Enumerate(effects, 4) + " there, and the standard deviations do not hold";
}

// s.
std::string Lapse(double seconds) {
  return seconds < 5400.0 ? Significant(seconds / 60.0, 2) + " min" : Significant(seconds / 3600.0, 2) + " h";
}

}  // namespace

std::string ShotsBeyondTime(size_t beyond, size_t shots, double most, const std::vector<std::string>& effects) {
  return ShotsBeyond(beyond, shots) + " before or after the calibration rows, by up to " + Lapse(most) +
         NothingHasChecked(effects);
}

std::string ShotsBeyondTemperature(size_t beyond, size_t shots, double most, const std::vector<std::string>& effects) {
  return ShotsBeyond(beyond, shots) + " colder or warmer than the calibration rows, by up to " + Significant(most, 2) +
         " K" + NothingHasChecked(effects);
}

std::string ShotsAroundMoment(size_t around, size_t shots, const std::string& effect) {
  return ShotsBeyond(around, shots) + " between the two readings between which " + effect +
         " happened: whether before or after it is not known, and no standard deviation allows for that";
}

std::string ShotsBeyondLoads(size_t beyond, size_t shots, double largest, double calibrated) {
  const std::string of_calibration =
      calibrated > 0.0 ? "the calibration's loads pull with at most " + Significant(calibrated, 3) + " N"
                       : "the calibration has no load";
  return ShotsBeyond(beyond, shots) + " under loads of up to " + Significant(largest, 3) + " N, and " + of_calibration +
         ": nothing has checked the deflections there";
}

std::string LearntFunctionsAreHeld(const std::vector<std::string>& effects) {
  return Enumerate(effects, 4) + (effects.size() == 1 ? " is" : " are") +
         " held as learnt from the rows of another run: no interval allows for what is off in it. The "
         "estimate.learnt.json "
         "of that run allows for it";
}

std::string PosesOutsideMeasured(size_t outside, size_t poses, const std::vector<std::string>& joints) {
  return std::to_string(outside) + " of " + std::to_string(poses) +
         (poses == 1 ? " configuration" : " configurations") + (outside == 1 ? " lies" : " lie") +
         " outside the measured joint ranges (at most " + Enumerate(joints, 4) +
         "): nothing has checked the estimate there";
}

std::string TargetOutsideMeasured(const std::vector<std::string>& joints) {
  return "outside the measured joint ranges: " + Enumerate(joints);
}

std::string TargetsOutsideMeasured(size_t outside) {
  return std::to_string(outside) + (outside == 1 ? " target lies" : " targets lie") +
         " outside the measured joint ranges, where nothing has checked the estimate: the column words names the "
         "joints.";
}

std::string InputOfTheEstimate(const std::string& file) {
  return file +
         " is an input of the estimate: unless its rows were held out, these are residuals of the fit, not a "
         "validation";
}

std::string PointsAreCorrected(const std::string& dialect, int corrected, size_t points, double before, double u95,
                               double u95_rotation) {
  std::string words =
      dialect + ": " + std::to_string(corrected) + " of " + std::to_string(points) + " points corrected";
  if (corrected == 0) return words;
  const std::string angle = Significant(1e3 * u95_rotation, 3);
  return words + "; the flange is off target before by at most " + InMillimetres(before) + ", after by at most " +
         InMillimetres(u95) + " and " + angle +
         " mrad (95 %, by the uncertainty of the estimate), a tool point by up to " + angle +
         " mm more for each metre that it is from the flange";
}

std::string MotionsAreCorrected(int corrected, size_t motions) {
  return "Motions: " + std::to_string(corrected) + " of " + std::to_string(motions) + " go to corrected points";
}

std::string PointStaysInWords(const std::string& point, int line) {
  return point + " stays as it is (line " + std::to_string(line) + ")";
}

std::string OffsetAdoptsInWords(int line, const std::string& motion, const std::string& point) {
  return "line " + std::to_string(line) + ", " + motion + ": it goes on from " + point + " and adopts its correction";
}

std::string CallsElsewhereInWords(const std::map<std::string, int>& calls) {
  std::vector<std::string> names;
  for (const auto& [name, line] : calls) names.push_back(name + " (line " + std::to_string(line) + ")");
  return "not in this file, and assumed to change neither tool, base nor load and to leave the arm in its "
         "configuration: " +
         Enumerate(names);
}

std::string JointTargetStaysInWords(const std::string& joint, double move, bool is_singular) {
  return std::string(is_singular ? "close to a singularity: the correction would turn "
                                 : "the correction would turn ") +
         joint + " by " + Significant(move / kDegree, 3) +
         " deg; a target that is given by its joints is not turned so far";
}

std::string JointMovesInWords(const std::string& joint, double move) {
  return joint + " by " + Significant(move / kDegree, 3) + " deg";
}

std::string JointStandsInWords(const std::string& joint, double value) {
  return joint + " at " + Significant(value / kDegree, 6) + " deg";
}

std::string PosesWithLargeMoves(double move) {
  return "Corrected, but close to a singularity a joint then stands elsewhere (more than " +
         Significant(move / kDegree, 2) + " deg from where it was)";
}

std::string PosesWithOtherTurns() {
  return "Corrected, but a joint is then just outside of what status, turn or configuration numbers state, which stay "
         "as they are (check how the controller handles that)";
}

std::string OtherConfigurationInWords(const std::vector<std::string>& joints) {
  return "the corrected pose would need other status, turn or configuration numbers than the file states" +
         (joints.empty() ? "" : " (" + Enumerate(joints) + ")");
}

std::string LoadUsedInWords(const std::string& name, const ProgramLoad& load, int points) {
  const Vector3<double> mm = 1e3 * load.centre;
  return "load at " + Points(points) + ": " + name + ", " + Significant(load.mass, 4) + " kg at (" +
         Significant(mm.x(), 4) + ", " + Significant(mm.y(), 4) + ", " + Significant(mm.z(), 4) +
         ") mm of the controller's flange; --load=NAME uses one of the estimate instead";
}

std::string LoadNotStatedInWords(const std::string& name, const std::string& why) {
  return "its load " + name +
         " is not known: " + (why.empty() ? "this file has no numbers for it that are understood" : why);
}

std::string LoadUnknownInWords(const std::string& name, int points) {
  return "the program names the load " + name + " at " + Points(points) +
         (points == 1 ? ", which stays" : ", which stay") + " as " + (points == 1 ? "it is" : "they are") +
         ": --loads_kg_mm='" + name +
         "=mass,x,y,z' (centre of mass in the controller's flange) states it, --load=NAME uses one of the estimate "
         "(none: its tool alone)";
}

std::string LoadOfTwoInWords(const std::string& one, const std::string& other) {
  return "the program moves to it with more than one load (" + Named(one) + " and " + Named(other) +
         "): --load=NAME corrects it for one of the estimate";
}

std::string ToolReplacedInWords(double tool_mass) {
  return "a load that a program states holds the tool, so the tool of the estimate (" + Significant(tool_mass, 3) +
         " kg) is not added to it";
}

}  // namespace sagitta
