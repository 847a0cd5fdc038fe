#include "estimator/report/calibration_words.h"

#include "problems/text.h"

namespace sagitta {
namespace {

std::string PlacesInWords(const std::vector<std::string>& configurations) {
  return "in three configurations, e.g. " + Joined(configurations);
}

}  // namespace

std::string AligningNominal() { return "aligning the nominal robot: base poses and markers"; }

std::string EverythingHeld() {
  return "the scatter is so large that every unknown had to be held: look for rows that are far off ('sagitta inspect' "
         "names them), then check signs and zero positions of the joints, the kinematics and the units";
}

std::string SingularAtOptimum() {
  return "the identification Jacobian is singular at the optimum although nothing is held";
}

std::string SingularAtEstimate() {
  return "the identification Jacobian is singular at the estimate: a value on its bound hides others";
}

std::string StoppedBefore(double steps, const std::string& because) {
  return "stopped " + std::to_string(steps) + " standard deviations from the optimum: " + because;
}

std::string ConvergedWithHeld(size_t held) {
  return std::to_string(held) + (held == 1 ? " parameter is" : " parameters are") +
         " held: the data do not determine " + (held == 1 ? "it" : "them");
}

std::string HeldAtStatedNoise(size_t held) {
  return std::to_string(held) + (held == 1 ? " parameter is" : " parameters are") +
         " held at the stated standard deviations, which are too large for these residuals";
}

std::string Converged() { return "the remaining Gauss-Newton step is below 1e-5 standard deviations"; }

std::string FoldedShotInWords(const std::string& folded) {
  return (folded.empty() ? "a load" : folded) +
         " folds the arm: the deflections find no equilibrium at the current compliances; check the units of loads, "
         "load points and compliances";
}

std::string ShotThatFolds(const std::string& load, const std::string& configuration, const std::string& row) {
  return (load.empty() ? std::string("the spring or the tool's weight") : "load '" + load + "'") +
         " at configuration '" + configuration + "' (" + row + ")";
}

std::string CentreOfHeavierLoad(const std::string& load, double mass, const Vector3<double>& off) {
  std::string xyz;
  for (int axis = 0; axis < 3; ++axis) xyz += (axis > 0 ? ", " : "") + Significant(1e3 * off[axis], 4);
  return "load_com of '" + load + "' counts the moment of the stated mass alone: with " + Significant(mass, 4) +
         " kg its centre of gravity is (" + xyz + ") mm off the stated point";
}

std::string SandwichInWords(int clusters) {
  return "robust covariance, clustered by configuration (" + std::to_string(clusters) +
         "): whatever rows of one configuration share, and whatever differs between configurations, counts as it is "
         "seen";
}

std::string FollowsTheCommandAlone(const std::string& joint, const std::string& driver) {
  return joint + " follows the command of " + driver + " and not what " + driver +
         " deviates by. Where a linkage couples the two (a parallelogram) it follows that, too: there the compliance "
         "of " +
         driver + " comes out wrong, and effects of " + driver +
         " are not recognised. Where the controller alone couples them (FANUC J2 and J3) all is well";
}

std::string StandsOnBound(const std::string& parameter, double below, bool by_sensor) {
  const char* const of_loads = "the loads, the load point";
  const char* const of_sensor =
      "the columns tau<i> (the torque of the loads on the joint, about its positive direction)";
  return parameter + " stands on its bound, 0, but the data want it " + Significant(below, 2) +
         " standard deviations below: check the sign and the unit of " + (by_sensor ? of_sensor : of_loads) +
         " and what is held; or the model lacks an effect (sagitta diagnose)";
}

std::string ReachedInWords(const std::string& parameter, double reached, const std::string& unit) {
  return ": " + parameter + " to about " + Significant(reached, 2) + " " + unit;
}

std::string MarkersAreOnTheAxis(const std::string& joint) {
  return "every marker is on the axis of " + joint +
         ", and no turn about it is seen: measure a marker some 50 mm or more off that axis as well, or leave the "
         "error at "
         "nominal";
}

std::string PullSideways(double newtons, const std::vector<std::string>& configurations, const std::string& reached) {
  return "pull sideways with " + Fixed(newtons, 0) + " N " + PlacesInWords(configurations) + reached;
}

std::string HangOffAxis(const Vector3<double>& point, const std::vector<std::string>& configurations,
                        const std::string& reached) {
  return "no sideways pull at this load point determines it: hang the load 100 mm off the axis (e.g. at [" +
         Fixed(1e3 * point.x(), 0) + ", " + Fixed(1e3 * point.y(), 0) + ", " + Fixed(1e3 * point.z(), 0) + "] mm) " +
         PlacesInWords(configurations) + reached;
}

std::string NoLoadDetermines() {
  return "no load at this load point turns the joint enough: use a longer arm or a heavier load, or state a prior";
}

std::string SpringRemedyInWords(SpringDoubt doubt) {
  switch (doubt) {
    case SpringDoubt::kTied:
      return "load the arm more heavily with the spring's joint spread over its range, or state a prior (priors: "
             "{compensator/...})";
    case SpringDoubt::kLength:
      return "measure L with markers on the links, or hold it";
    case SpringDoubt::kOther:
      return "measure where the spring is fixed with markers on the links and state it, or state a prior "
             "(priors: {compensator/...})";
  }
  return "";
}

std::string NumbersLookLike(const std::string& unit, double misfit, double misfit_as_unit) {
  return "the numbers look like " + unit + ": the aligned nominal robot misses by " + InMillimetres(misfit) +
         " (RMS) as the columns say, by " + InMillimetres(misfit_as_unit) + " if they are " + unit;
}

std::string ConvertNumbers(const std::string& column) {
  const std::string convert = "convert the numbers";
  return column.empty() ? convert : "name the column " + column + " (and those like it), or " + convert;
}

std::string CorrectedLength(const std::string& parameter, double length, double by) {
  return parameter + " (" + Fixed(1e3 * length, 1) + " mm by " + Fixed(1e3 * by, 1) + " mm)";
}

std::string LengthsAreCorrected(const std::vector<std::string>& lengths) {
  return "lengths are corrected by more than a tenth: " + Enumerate(lengths, 5) +
         "; no robot is built so: look for wrong rows, units and signs ('sagitta inspect')";
}

std::string CalibratedRobotMisses(double distance_rms) {
  return "the calibrated robot still misses by " + InMillimetres(distance_rms) +
         " (RMS): this robot did not make these measurements as described; check signs and zero positions of the "
         "joints, the kinematics and the units ('sagitta inspect' tries them)";
}

}  // namespace sagitta
