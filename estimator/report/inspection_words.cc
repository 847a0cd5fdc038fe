#include "estimator/report/inspection_words.h"

#include <cmath>

#include "models/constants.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr char kForceOnTool[] = "(the force on the tool, in the measurement frame unless loads: says otherwise)";

std::string UnitAfterValue(const Joint& joint) { return joint.type == JointType::kRevolute ? " deg" : " mm"; }
std::string ValueOf(const Joint& joint, double q) {
  return Fixed(q / (joint.type == JointType::kRevolute ? kDegree : 1e-3), 1);
}

std::string RangeInWords(const Joint& joint, double least, double most) {
  return ValueOf(joint, least) + " to " + ValueOf(joint, most) + UnitAfterValue(joint);
}

// At least one of them is stated.
std::string LimitsInWords(const Joint& joint) {
  if (joint.min && joint.max) return RangeInWords(joint, *joint.min, *joint.max);
  return (joint.min ? "from " + ValueOf(joint, *joint.min) : "up to " + ValueOf(joint, *joint.max)) +
         UnitAfterValue(joint);
}

std::string NumberOf(size_t number, const std::string& one, const std::string& more) {
  return std::to_string(number) + " " + (number == 1 ? one : more);
}

std::string OfStations(const std::string& stations) { return stations.empty() ? "" : " (station " + stations + ")"; }

}  // namespace

Advice JointNeverMoved(const Joint& joint, double least, double most) {
  return {"joint " + joint.name + " never moved (" + RangeInWords(joint, least, most) +
              "): its axis is not seen, and the errors around it cannot be separated",
          "add configurations that move " + joint.name};
}

std::string JointStands(const Joint& joint, double least, double most) {
  return "joint " + joint.name + " stands still in all rows (" + RangeInWords(joint, least, most) +
         "): was it recorded?";
}

Advice JointBeyondLimits(const Joint& joint, double least, double most) {
  return {"joint " + joint.name + " was at " + RangeInWords(joint, least, most) + ", beyond its limits (" +
              LimitsInWords(joint) + ")",
          "check sign, zero position and unit of its column, and the limits"};
}

Advice JointCoversLittle(const Joint& joint, double least, double most, double share) {
  std::string words = "joint " + joint.name + " covers " + RangeInWords(joint, least, most) + " only";
  if (share > 0.0) words += ", " + Fixed(100.0 * share, 0) + " % of its limits";
  return {words + ": beyond it the model extrapolates", "spread " + joint.name + " over the range that is used later"};
}

Advice OrientationIsConstant(const std::string& stations) {
  return {"the flange has the same orientation in all configurations" + OfStations(stations) +
              ": where the marker sits on the flange cannot be distinguished from where the base stands; both could be "
              "shifted against each other by any amount without a trace",
          "add configurations with the flange turned about at least two axes by 30 degrees and more where the arm can "
          "turn it so, or state the markers' points"};
}

Advice OrientationAboutOneAxis(const Vector3<double>& axis, const std::string& stations) {
  return {"the flange turns about one axis only, (" + Fixed(axis.x(), 2) + ", " + Fixed(axis.y(), 2) + ", " +
              Fixed(axis.z(), 2) + ") in its own frame" + OfStations(stations) +
              ": the marker's place along it cannot be distinguished from the base's",
          "add configurations with the flange tilted about another axis where the arm can tilt it, or state a marker's "
          "point and hold it "
          "(--fixed=NAME)"};
}

Advice FewConfigurations(int configurations, int equations, int unknowns) {
  return {std::to_string(configurations) + " configurations (" + std::to_string(equations) + " equations) for " +
              std::to_string(unknowns) + " unknowns: little is left to check the fit with",
          "measure more configurations, or free less (estimate.geometry, --fixed)"};
}

Advice PosesAreRepeated(size_t configurations) {
  return {NumberOf(configurations, "configuration has the joint values of another one: it adds",
                   "configurations have the joint values of another one: they add") +
              " repeats, no new poses",
          "give repeated arrivals the same config and another visit"};
}

Advice PointsAreCopied(size_t rows) {
  return {
      NumberOf(rows, "row has", "rows have") + " the point of an earlier row to the last digit, at other joint values",
      rows == 1 ? "measure this row again or leave it out" : "measure these rows again or leave them out"};
}

Advice LoadedWithoutUnloaded(size_t shots) {
  return {NumberOf(shots, "loaded shot has", "loaded shots have") + " no unloaded counterpart",
          std::string(shots == 1 ? "measure it" : "measure them") +
              " unloaded at the same visit too: what the joints do alike in both then cancels"};
}

Advice MissingFromData(Missing what) {
  switch (what) {
    case Missing::kSigma:
      return {
          "no standard deviation is stated: one for all coordinates is estimated, and nothing can distinguish a "
          "wrong model from noise",
          "add sigma_x_mm, sigma_y_mm, sigma_z_mm, state noise: {sigma_mm: …}, or give --sigma_mm"};
    case Missing::kApproach:
      return {"no column says from which side the joints arrived: backlash cannot be determined",
              "add approach1 … approachN (-1, 0, +1) and reach some configurations from both sides"};
    case Missing::kVisits:
      return {
          "no configuration was visited twice: the robot's repeatability cannot be distinguished from the "
          "instrument's noise by repeats",
          "reach some configurations again, with the same config and another visit"};
    case Missing::kTime:
      return {"no column time_s: drift and slips cannot be determined", "add time_s"};
    case Missing::kTemperature:
      return {"no column temperature_degC: thermal growth cannot be determined", "add temperature_degC"};
    case Missing::kMarkers:
      return {
          "fewer than three markers: the flange's orientation is not measured, and the instrument's noise "
          "cannot be checked against the markers' rigid arrangement",
          "measure three markers off one line in each shot"};
  }
  return {};
}

Advice LoadUnitIsOff(const std::string& load, double size, double flexibility, bool is_too_soft) {
  return {"load '" + load + "': " + Significant(size / flexibility, 3) + " N move the markers by " +
              Significant(1e3 * size, 3) + " mm (median), a stiffness of " + Significant(1e-3 / flexibility, 3) +
              " N/mm: no arm is that " + (is_too_soft ? "soft" : "stiff"),
          "check the unit of the force columns (N, not kN, kg or mN), or mass_kg"};
}

Advice LoadSignIsOff(const std::string& load) {
  return {"load '" + load + "': the markers move against its force",
          "check the signs of fx_N, fy_N, fz_N " + std::string(kForceOnTool) + ", and which rows are loaded"};
}

namespace {

std::string DirectionInWords(const Vector3<double>& direction) {
  std::string words;
  for (int a = 0; a < 3; ++a) {
    const double value = std::abs(direction[a]) < 5e-4 ? 0.0 : direction[a];  // no -0.000
    words += (a == 0 ? "" : ", ") + Fixed(value, 3);
  }
  return words;
}

}  // namespace

std::string WeightsPullAcross(double angle) {
  return "loaded points move as if the weights pulled " + Fixed(angle / kDegree, 0) +
         " degrees away from the stated gravity";
}

Advice LoadsPullAcross(double angle, const Vector3<double>& fitted, const Vector3<double>& stated,
                       const Vector3<double>& in_frame, bool is_base, bool in_columns, double left_stated,
                       double left) {
  const std::string frame = is_base ? "base" : "measurement";
  return {WeightsPullAcross(angle) + ": along (" + DirectionInWords(fitted) + ") of the base frame, stated is (" +
              DirectionInWords(stated) + "); any compliances of the joints miss the deflections by " +
              InMillimetres(left) + " RMS there, by " + InMillimetres(left_stated) + " as stated",
          in_columns ? "check signs and axes of fx_N, fy_N, fz_N " + std::string(kForceOnTool)
                     : "state gravity: {direction: [" + DirectionInWords(in_frame) + "], frame: " + frame +
                           "} in the experiment file" + (is_base ? "" : " (the " + frame + " frame is not levelled)")};
}

std::string MisfitOfReading(double misfit, double as_read, const std::string& name,
                            const std::vector<std::string>& alike, bool limits_decide) {
  std::string words = "the aligned nominal robot misses by " + InMillimetres(misfit) + " (RMS) as stated, by " +
                      InMillimetres(as_read) + " with " + name;
  if (!alike.empty()) words += ", and just as well with " + Enumerate(alike);
  return limits_decide ? words + "; what else fits goes beyond the limits of the joints" : words;
}

Advice MisfitUnexplained(double misfit, bool is_one_station) {
  return {"the aligned nominal robot misses by " + InMillimetres(misfit) +
              " (RMS), more than a calibration can be asked to explain, and no other sign, zero position, "
              "joint order, unit or DH convention alone explains it",
          "check that robot file and measurements belong together: is it this robot? joint order, signs, zero "
          "positions, link lengths" +
              std::string(is_one_station ? "; or did the instrument stand in several places, which are one station in "
                                           "these rows? Name each place in the column station"
                                         : "")};
}

std::string ErrorsThatWouldExplain(double by, bool is_length, const std::string& largest) {
  return "; as this robot it would have to be off by " + Significant(std::abs(by) / (is_length ? 1e-3 : kDegree), 3) +
         (is_length ? " mm" : " deg") + " in " + largest + ", among others";
}

Advice RowsAreWild(size_t far, size_t all, double median, double near_rms, const std::string& first) {
  const auto percent = std::lround(100.0 * static_cast<double>(far) / static_cast<double>(all));
  return {std::to_string(far) + " of " + std::to_string(all) + " rows (" + std::to_string(percent) +
              " %) are far off, half of them by more than " + InMillimetres(median) +
              ", while the others fit the nominal robot within " + InMillimetres(near_rms) +
              " (RMS): too many for a robust loss",
          "it is these rows, not the robot: find what they share (instrument, marker, time), or leave them "
          "out; the first: " +
              first};
}

Advice RowsAreOff(size_t rows, double least, double most, double median) {
  return {std::to_string(rows) + (rows == 1 ? " row is" : " rows are") + " off by " + InMillimetres(least) +
              (rows == 1 ? "" : " to " + InMillimetres(most)) + ", more than " +
              std::to_string(static_cast<int>(least / median)) + " times the median of all (" + InMillimetres(median) +
              ")",
          "measure these rows again or leave them out"};
}

Advice MarkersAreExchanged(size_t shots, size_t pairs, const std::string& first_pair) {
  return {std::to_string(shots) + (shots == 1 ? " shot fits" : " shots fit") + " with two markers exchanged (" +
              first_pair + (pairs > 1 ? ", …" : "") + ")",
          "exchange the marker names of these rows"};
}

Advice RestsOnOneConfiguration(const std::string& names) {
  return {"some combination of the unknowns rests on one configuration alone (" + names +
              "): an error there would go unseen",
          "measure more configurations like these"};
}

Advice ArmFolds(const std::string& folded) {
  return {(folded.empty() ? "a load" : folded) + " folds the arm at the nominal compliances",
          "check the units of loads, load points and compliances"};
}

std::string TorquesInWords(bool measured_count, const TorqueGroups& joints) {
  std::string words = measured_count ? "The measured joint torques drive the joints' deflections."
                                     : "The modelled joint torques drive the joints' deflections.";
  if (!joints.agree.empty()) words += " Measured and modelled torques agree on " + Enumerate(joints.agree) + ".";
  if (!joints.scaled.empty()) words += " They differ by a factor on " + Enumerate(joints.scaled) + ".";
  if (!joints.opposite.empty()) {
    words +=
        " They have opposite signs on " + Enumerate(joints.opposite) +
        ": the columns tau<i> are read as the torque of the loads on the joint, about its positive direction; what the "
        "drive delivers against it has the other sign.";
  }
  if (!joints.differ.empty()) {
    words += " They have little in common on " + Enumerate(joints.differ) +
             ": the model knows the stated loads and the tool, a sensor feels the links and friction as well.";
  }
  if (!joints.untold.empty()) {
    words +=
        " What the model knows of does not vary the torque on " + Enumerate(joints.untold) + ": nothing to compare.";
  }
  return words;
}

std::string NotReadInWords(const std::vector<std::string>& columns) {
  constexpr size_t kMost = 20;
  return columns.empty() ? "" : "Columns not read: " + Enumerate(columns, kMost) + ".";
}

std::string ReadingOtherwise() { return "reading robot and rows in other ways"; }

std::string LinearizingAtNominal() { return "linearizing at the aligned nominal robot"; }

}  // namespace sagitta
