#include "estimator/report/inspection_known_words.h"

#include "problems/text.h"

namespace sagitta {
namespace {

std::string Misses(double median) { return "it misses them by " + InMillimetres(median) + " (median)"; }

std::string MissesFitted(double median, double fitted) {
  return Misses(median) + ", and by " + InMillimetres(fitted) + " (RMS) with base poses and markers fitted to them";
}

const char* const kCheckBoth =
    "check that estimate and measurements belong together: is it this robot? and the order, signs and zeros of the "
    "joint "
    "columns";

}  // namespace

std::string CalibrateNewPlace() {
  return "calibrate the new place with the calibrated robot: 'sagitta calibrate robot.calibrated.yaml' with these rows";
}

std::string StationIsNew(const std::string& known) {
  return known + "; where the instrument stands as it stood give these rows its name, else " + CalibrateNewPlace();
}

Advice StandsElsewhere(double median, double fitted) {
  return {MissesFitted(median, fitted) +
              ": the robot, the instrument or a marker stands elsewhere than when it was "
              "calibrated, or these are the readings of another place",
          CalibrateNewPlace()};
}

Advice NotThisRobot(double median, double fitted) {
  return {MissesFitted(median, fitted) + ": this is not the robot of the estimate, or these are not its readings",
          kCheckBoth};
}

Advice NotTheseReadings(double median) {
  return {
      Misses(median) + ": this is not the robot of the estimate, it stands elsewhere, or these are not its readings",
      kCheckBoth};
}

std::string MissesAndWhy(double median, const std::string& why) { return Misses(median) + "; " + why; }

Advice LabelStandsElsewhere(const std::string& marker, const std::string& station, double median) {
  return {"the rows of marker '" + marker + "' from station '" + station + "' are off by " + InMillimetres(median) +
              " (median), others are not: the marker or the station stands elsewhere than when it was calibrated, or "
              "these rows are another's",
          "leave these rows out, or calibrate with rows from there under a name of their own"};
}

std::string RobotDidNotMakeThese(const std::string& reason) {
  return "the robot of this estimate cannot have made these readings: " + reason;
}

std::string RowsAreFarOff(size_t far, size_t all, double beyond, const std::string& first, double by) {
  return std::to_string(far) + " of " + std::to_string(all) + (far == 1 ? " rows is" : " rows are") +
         " off by more than " + InMillimetres(beyond) + ", farther than arms are (" + first + " by " +
         InMillimetres(by) + (far > 1 ? ", …" : "") + "): the figures are mostly theirs";
}

std::string CalibrationLeftOpen(double held_rms, const std::vector<std::string>& held) {
  return "these poses depend on what the calibration did not measure (" + Enumerate(held, 4) +
         "): that alone leaves their points open by " + InMillimetres(held_rms) +
         " (RMS), and how far they are off says little of the robot; calibrate with poses like these among the others";
}

std::string BeginAtTheFirstRow(const std::vector<std::string>& effects) {
  return Enumerate(effects) + (effects.size() == 1 ? " depends" : " depend") +
         " on what was done before each row: give all rows of a campaign, in their order and with their times. What "
         "was done between the calibration and the first one given is not known, and no standard deviation allows for "
         "it";
}

std::string RowsRefuteTheEstimate(double rms, double excess, double p_value, double known_rest,
                                  const std::vector<std::string>& remembering) {
  const std::string before_them =
      remembering.empty() ? ""
                          : ", or something was done before these rows that " + Enumerate(remembering) + " goes with";
  const std::string words = "these rows refute the estimate: their coordinates are off by " + InMillimetres(rms) +
                            " (RMS), " + Significant(excess, 2) +
                            " times what noise and parameter uncertainty predict (" + PValueInWords(p_value) + "): ";
  if (known_rest > 0.0) {
    return words +
           "the model lacks something. The calibration said so, and left as much on points that it did not fit (" +
           InMillimetres(known_rest) +
           " RMS distance beyond the noise): nothing need have changed since, and predictions and targets carry it";
  }
  return words +
         "since the calibration something has changed, or the readings are noisier than stated, or the model lacks "
         "something" +
         before_them + "; calibrate these rows by themselves, and 'sagitta changed' says what changed";
}

std::string ReadingsContradict(double rms, double excess) {
  return "the readings of these rows are off what is predicted by " + InMillimetres(rms) + " (RMS over coordinates), " +
         Significant(excess, 2) +
         " times what noise and parameters let expect: 'sagitta validate' judges the estimate by them";
}

std::string WorseThanNominalOnThese(double calibrated, double nominal) {
  return "the calibrated robot misses these points by more than the nominal one (" + InMillimetres(calibrated) +
         " against " + InMillimetres(nominal) + "): it is not this robot, or it has changed since it was calibrated";
}

}  // namespace sagitta
