#include "estimator/report/validation_words.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "models/constants.h"
#include "problems/text.h"

namespace sagitta {
namespace {

std::string AxisName(int axis) { return std::string(1, "xyz"[axis]); }

std::string NotMeasured(size_t directions) {
  static const char* kNumbers[] = {"no", "one", "two", "three", "four", "five", "six"};
  if (directions == 0) return "";
  const std::string number = directions < std::size(kNumbers) ? kNumbers[directions] : std::to_string(directions);
  return "; " + number + (directions == 1 ? " direction was" : " directions were") + " not measured";
}

// Against the nominal robot; where it is worse that is a reason not to trust it.
std::string GainInWords(const Trust& trust) {
  if (trust.nominal.points == 0 || trust.gain.compared == Compared::kWorse) return "";
  const std::string nominal = InMillimetres(trust.nominal.distance_rms);
  if (trust.gain.compared == Compared::kBetter)
    return ", " + Significant(trust.gain.ratio, 2) + " times better than nominal";
  if (trust.gain.compared == Compared::kAsGood) return "; the robot file was as good already (" + nominal + ")";
  return "; within what is uncertain the robot file was as good already (" + nominal + ")";
}

// What of the RMS is no error of the robot.
std::string NoiseShareInWords(const NoiseShare& share, double rms) {
  if (!(share.noise > 0.0)) return "";
  const std::string rest = (share.rest_is_bound ? "at most " : "") + InMillimetres(share.rest) + ".";
  const std::string known = " Of this RMS, known to ± " + Significant(100.0 * share.rms_known_to, 2) + " %, ";
  if (share.of_residuals && share.noise > rms) {
    return " This RMS, known to ± " + Significant(100.0 * share.rms_known_to, 2) +
           " %, is no more than what the residuals scatter by, as of instrument and arm and of what the model lacks "
           "alike: " +
           InMillimetres(share.noise) +
           " where the fitted parameters are counted (degrees of freedom in place of rows); " +
           "what uncertain parameters add is " + rest;
  }
  if (share.of_residuals) {
    return known + "the scatter of the residuals, of instrument and arm and of what the model lacks alike, is " +
           InMillimetres(share.noise) + ", and what uncertain parameters add " + rest;
  }
  return known + "the noise of the readings is " + InMillimetres(share.noise) + ", and what is left for the robot " +
         rest;
}

// How good the robot is on poses that it has not seen.
std::string AccuracyInWords(const Trust& trust, double significance, double better) {
  const UnseenPoints& quoted = trust.Quoted();
  if (quoted.points == 0) return "No points were set aside to say how good this robot is on poses it has not seen.";
  std::string words = "On poses it has not seen this robot is now within " + InMillimetres(quoted.distance_rms) +
                      " (RMS; 95 % of points within " + InMillimetres(quoted.distance_p95) + ", worst " +
                      InMillimetres(quoted.distance_max) + " at config " + quoted.worst.front().configuration + ")";
  words += GainInWords(trust);
  if (quoted.predicted_rms > 0.0) {
    const double excess = quoted.Excess();
    const bool is_small = quoted.p_value < significance;
    const bool is_large = 1.0 - quoted.p_value < significance && excess < 1.0 - better;
    words += is_small   ? "; the prediction was " + Significant(excess, 2) + " times smaller"
             : is_large ? "; the prediction was " + Significant(1.0 / excess, 2) + " times larger"
                        : "; the prediction agrees";
  }
  return words + "." + NoiseShareInWords(trust.noise, quoted.distance_rms);
}

}  // namespace

std::string ModelErrorInWords(double median, double largest, const std::string& name, const std::string& between,
                              ExcessOf excess) {
  std::string reason;
  if (excess == ExcessOf::kHoldout) reason = "errors on the points held out are larger than predicted";
  if (excess == ExcessOf::kCrossValidation) reason = "errors in the cross-validation are larger than predicted";
  if (between.empty()) reason += "; 'sagitta diagnose' may find why";  // else it says what may help
  if (!between.empty()) reason += (reason.empty() ? "" : ", and ") + between;
  const bool is_typical = median >= 1.05;  // "1 times" says nothing
  std::string words = std::string(is_typical ? "the intervals are " : "single intervals are up to ") +
                      Significant(is_typical ? median : largest, 2) + " times as wide as noise alone would make them";
  if (!is_typical) words += " (" + name + ")";
  if (is_typical && largest > 1.05 * median)
    words += " (median; at most " + Significant(largest, 2) + " times, " + name + ")";
  return words + ": " + reason;
}

std::string NothingChecksIt() { return "nothing checks it: too few configurations to set any aside"; }

std::string NothingChecksTheMethod() {
  return "nothing checks it: there is no cross-validation of this method, whose folds would be fitted by another one "
         "(hold configurations out: --holdout=0.3)";
}

std::string NothingIsPredictable() {
  return "nothing checks it: every point is of a station or marker that its own poses alone determine, so that no "
         "other "
         "poses predict it";
}

std::string PredictionIsOff(bool is_holdout, double excess, double p_value) {
  return std::string("the errors ") + (is_holdout ? "on the points held out" : "in the cross-validation") + " are " +
         Significant(excess, 2) + " times what the estimate predicted for them (" + PValueInWords(p_value) + ")";
}

std::string WorseThanNominal(double nominal_rms) {
  return "on points that it has not seen it is worse than the robot file was already (" + InMillimetres(nominal_rms) +
         ")";
}

std::string PosesAreTooFew(double nominal_rms, double rms) {
  return "on points that it has not seen it is off by " + InMillimetres(rms) + ", the robot file by " +
         InMillimetres(nominal_rms) + ", and more of that is what so few poses leave unknown than noise: measure more";
}

std::string NoRedundancy() { return "there are as many unknowns as readings: the data cannot check themselves"; }

std::string BelowAnyInstrument(double rms) {
  return "residuals of " + Significant(1e6 * rms, 2) +
         " um are below any instrument's noise, as of points that are commanded or simulated and not measured";
}

std::string RowsAreSuspect(size_t rows, const std::string& first) {
  return std::to_string(rows) + (rows == 1 ? " row is" : " rows are") + " suspect (" + first + (rows > 1 ? ", …" : "") +
         ")";
}

std::string HeldOutIsFitted(int seen, int held_out) {
  return std::to_string(seen) + " of the " + std::to_string(held_out) +
         " configurations held out have the joint values of fitted ones (within 0.06 deg): these have been seen";
}

std::string ComesOutNegative(const std::string& name, double sigmas, bool by_sensor) {
  return name + " comes out negative, " + Significant(sigmas, 2) + " standard deviations below 0: check the sign and " +
         (by_sensor
              ? "the unit of the columns tau<i>, the torque of the loads on the joint, about its positive direction"
              : "the unit of the loads and the load point");
}

std::string TorquesAreOthers(const std::string& joint, double slope, size_t joints) {
  const std::string more = joints > 1 ? " (and of " + std::to_string(joints - 1) + " more)" : "";
  return "the torques that were measured on " + joint + more + " are " + Significant(slope, 2) +
         " times those that the model knows of, and what bends under them is wrong by as much: state torques: "
         "measured, or "
         "the weights that the model lacks (links, tool, load)";
}

std::string WeightsAreWrong(double worse) {
  return "with equal weights and without priors the same points fit " + Significant(worse, 2) +
         " times better: the stated standard deviations contradict each other or a prior is wrong";
}

std::string RowsContradictPrior(const ParameterSet& parameters, const PriorConflict& worst, size_t all) {
  const Coordinate& coordinate = parameters.coordinates()[worst.coordinate];
  const QuantityTraits& traits = TraitsOf(coordinate.quantity);
  const auto value = [&](double si) { return Significant(si / traits.si_per_unit, 3); };
  return fmt::format(
      "the rows contradict the prior of {}: it is stated as {} +- {} {}, they say {} +- {}, {} standard "
      "deviations apart{}: check its value{} and its unit, or leave it out",
      coordinate.name, value(coordinate.prior_value), value(worst.prior_sigma), traits.unit, value(worst.rows),
      value(worst.rows_sigma), Significant(worst.sigmas, 2), all > 1 ? fmt::format(" (and {} more)", all - 1) : "",
      coordinate.kind == CoordinateKind::kGeometry ? " (of the correction, not of the whole length or angle)" : "");
}

std::string SomethingMoved(const CalibrationProblem& problem, const Break& found) {
  const Measurements& data = problem.data();
  const auto row = [&](int i) { return data.SourceOf(data.observations[i]); };
  std::string what, cure;
  switch (found.of) {
    case BreakOf::kStation:
      what = "station " + data.stations[found.index] + " or the robot's foot moved";
      cure = "give the rows after it a station of their own";
      break;
    case BreakOf::kMarker:
      what = "marker " + data.markers[found.index] + " moved";
      cure = "give it another name in the rows after it";
      break;
    case BreakOf::kTool:
      what = "the tool with all markers moved on the flange, or was exchanged";
      cure = "give the markers other names in the rows after it";
      break;
    case BreakOf::kJoint:
      what = "the zero of joint " + problem.robot().chain.joints[found.index].name + " jumped";
      cure = "calibrate the rows before and after it apart";
      break;
  }
  return "between " + row(found.last) + " and " + row(found.first) + " " + what + ", points after it by " +
         InMillimetres(found.moved) + " (that explains " + Fixed(100.0 * found.share, 0) +
         " % of the squared residuals): " + cure;
}

std::string RobotStillMisses(double distance_rms, bool has_suspects) {
  const std::string misses = "the calibrated robot still misses by " + InMillimetres(distance_rms) + " (RMS)";
  if (has_suspects) return "with them " + misses + ": correct these rows or leave them out, and calibrate again";
  return misses + ": robot file and measurements do not belong together";
}

std::string JointWasNotMeasured(const Joint& joint, double least, double most) {
  const bool turns = joint.type == JointType::kRevolute;
  const std::string at = Fixed(turns ? 0.5 * (least + most) / kDegree : 500.0 * (least + most), 1);
  return "Joint " + joint.name + " stands at " + at + (turns ? " deg" : " mm") +
         " in all rows: what it does was not measured, and these figures hold there only; if it did move, its column "
         "is wrong.";
}

std::string CorrectionIsLarge(const std::string& name, double correction, bool is_length) {
  return name + " comes out " + Significant(std::abs(correction) / (is_length ? 1e-3 : kDegree), 2) +
         (is_length ? " mm" : " deg") +
         " from the robot file, more than arms are made or mastered off (5 mm, 1 deg): compare the file with the "
         "maker's table.";
}

std::string ResidualsRefuteNoise(double times, bool by_repeats) {
  if (by_repeats)
    return "The residuals are " + Significant(times, 3) +
           " times what the scatter of the repeats predicts: the arm does something from one arrival to the next that "
           "the model does not have ('sagitta diagnose' finds what, or its repeatability); the prediction was judged "
           "with the scatter of the residuals.";
  return "The residuals are " + Significant(times, 3) +
         " times what the stated standard deviations predict: either these are too small, or the arm does something "
         "that the model does not have ('sagitta diagnose' distinguishes); the prediction was judged with the "
         "scatter of the residuals, not with the stated noise.";
}

std::string StatedNoiseIsTooLarge(double times, double rms) {
  // 1000 times: the unit next to it, where the residuals are larger than the noise by less than a factor of three.
  const bool is_unit = times > 300.0 && times < 3000.0;
  return "The stated standard deviations are about " + Significant(times, 2) +
         " times too large: the points fit within " + InMillimetres(rms) + " per coordinate (RMS)" +
         (is_unit ? "; were micrometres written as millimetres?" : ".");
}

std::string VerdictInWords(const Trust& trust, double significance, double better, size_t not_measured) {
  std::string words =
      AccuracyInWords(trust, significance, better) +
      (trust.verdict.trusted ? " Trust it inside the measured joint ranges" + NotMeasured(not_measured) + "."
                             : " Do not trust it yet: " + Enumerate(trust.verdict.reasons) + ".");
  for (const std::string& limit : trust.limits) words += " " + limit;
  return words;
}

std::string LeftOutInWords(const Unpredictable& left_out) {
  if (left_out.points == 0) return "";
  std::vector<std::string> causes;
  for (const std::string& station : left_out.stations) causes.push_back("station " + station);
  for (const std::string& marker : left_out.markers) causes.push_back("marker " + marker);
  const bool is_one = left_out.points == 1;
  return std::to_string(left_out.points) + (is_one ? " point is" : " points are") +
         " left out of the cross-validation: without " + (is_one ? "its" : "their") +
         " own poses nothing determines where " + Enumerate(causes) + (causes.size() == 1 ? " is" : " are") +
         ", so that nothing can be predicted for " + (is_one ? "it" : "them") + ".";
}

std::string FitsTurned(int axis) { return "fits with " + AxisName(axis) + " of the other sign"; }

std::string FitsExchanged(int axis, int other) {
  return "fits with " + AxisName(axis) + " and " + AxisName(other) + " exchanged";
}

std::string FitsShifted(int axis, bool to_the_right) {
  return "fits with the decimal point of " + AxisName(axis) + " one digit " +
         (to_the_right ? "to the right" : "to the left");
}

std::string FitsInMetres() { return "fits when its numbers are read in m"; }

std::string FitsInThousandths() { return "fits when its numbers are read in a unit 1000 times smaller"; }

std::string FitsInInches() { return "fits when its numbers are read in inches"; }

std::string OutlierIsOff(double size) { return "off by " + InMillimetres(size); }

std::string FitsAsMarker(const std::string& marker, const std::string& row) {
  return "fits as marker " + marker + " of the same shot: marker names exchanged (" + row + ")";
}

std::string FitsConfiguration(const std::string& configuration, const std::string& row) {
  return "fits the joint values of configuration " + configuration + " (" + row + ")";
}

std::string FitsStation(const std::string& station) { return "fits as read from station " + station; }

std::string RowIsOff(double distance, double times) {
  return OutlierIsOff(distance) + ", " + Significant(times, 2) + " times the median";
}

std::string MeasureAgain() { return "measure it again or leave it out"; }

std::string ReadingIsLost() { return "x, y and z are one number, as of a lost reading: leave the three cells empty"; }

std::string RepeatabilityIsLimited(const PoseRepeatability& repeatability) {
  // n arrivals are nearer to their own mean than to the true one by sqrt(1 - 1 / n), 5 % of ten.
  constexpr int kFew = 10;
  if (repeatability.most < 2) return "no pose was visited again";
  if (repeatability.poses == 0) {
    return "no pose was visited more than twice; two arrivals are equally far from their mean, so that their distances "
           "have no scatter and RP would come out far too small";
  }
  if (repeatability.fewest < kFew) return "so few arrivals make RP too small on average";
  return "";
}

}  // namespace sagitta
