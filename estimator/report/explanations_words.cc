#include "estimator/report/explanations_words.h"

#include <cmath>

#include "problems/text.h"

namespace sagitta {

std::string DeviatesWith(const std::string& joint, const std::string& driver) {
  return "a deviation of " + joint + " that depends on " + driver;
}

std::string DeviatesWithBoth(const std::string& joint, const std::string& one, const std::string& other) {
  return "a deviation of " + joint + " that depends on " + one + " and " + other + " together";
}

std::string DeviatesOver(const std::string& joint, const std::string& one, const std::string& other) {
  return "a deviation of " + joint + " that goes over " + one + " and " + other;
}

std::string RepeatsPerTurn(const std::string& joint, int times) {
  return "a deviation of " + joint + " that repeats " + std::to_string(times) + " times per turn";
}

std::string JointsFollowPose() { return "a deviation of the joints that follows the pose"; }

std::string PartlyLike(const std::string& effect, const std::string& target) {
  return "in part like " + effect + " on " + target;
}

std::string EachJointDeviatesWithTime() { return "each joint deviates with time"; }

std::string FollowsLate(const std::string& joint, const std::string& what) {
  return "a deviation of " + joint + " that follows " + what + " late";
}

std::string EachJointFollowsLate(const std::string& what) { return "each joint follows " + what + " late"; }

std::string TorqueOnIt() { return "the torque on it"; }

std::string HeatOfItsMotion() { return "the heat of its motion"; }

std::string ForcePulls() { return "a force pulls at the flange"; }

std::string StationMoves(const std::string& station) { return "station " + station + " moves with time"; }

std::string StationMovesWithTemperature(const std::string& station) {
  return "the base moves and turns in station " + station + " with temperature";
}

std::string StationMovesAsABody(const std::string& station) {
  return "station " + station + " moves and turns at once";
}

std::string BaseTurnsInStation(const std::string& station) {
  return "the base turns in station " + station + " with time";
}

std::string BaseTurnsWith(const std::string& station, const std::string& driver) {
  return "the base turns in station " + station + " with " + driver;
}

std::string StationGrows(const std::string& station) {
  return "the scale of station " + station + " changes with time";
}

std::string StationMovesAlong(const std::string& station, char axis) {
  return "station " + station + " moves along " + axis + " with time";
}

std::string StationIsDistorted(const std::string& station) {
  return "the readings of station " + station + " are distorted over its field";
}

std::string ReadsWrongOver(const std::string& station, const std::string& reading, const std::string& over) {
  return "station " + station + " reads a wrong " + reading + (reading == over ? "" : " over the " + over);
}

std::string RangeRepeats(const std::string& station, const std::string& period) {
  return "station " + station + " reads a range that is wrong by a wave of " + period + " mm of it";
}

std::string MarkerMovesWith(const std::string& marker, const std::string& driver) {
  return "marker " + marker + " moves with " + driver;
}

std::string MovesWithGravity(const std::string& what) { return what + " moves with the direction of gravity"; }

std::string PlateGivesWay() { return "what carries the markers gives way to the load"; }

std::string FallsIntoAnotherSeat(const std::string& what) { return what + " falls into another seat as gravity turns"; }

std::string LoadShiftsWithGravity(const std::string& load) {
  return "the centre of gravity of " + load + " moves with the direction of gravity";
}

std::string LoadSlides(const std::string& load, const std::string& along) {
  return "the centre of gravity of " + load + " moves along " + along + " with gravity along it";
}

std::string ChangesItsSeat(const std::string& what) { return what + " changes its seat between visits"; }

std::string ToolMoves() { return "what carries the markers moves with time"; }

std::string ToolMovesAlong(const std::string& axis) {
  return "what carries the markers moves along " + axis + " of the flange with time";
}

std::string ToolTurnsAbout(const std::string& axis) {
  return "what carries the markers turns about " + axis + " of the flange with time";
}

std::string WaveInWords(const std::string& size, int per_turn, const std::string& driver) {
  return "a wave of " + size + " that repeats " + (per_turn == 1 ? "once" : std::to_string(per_turn) + " times") +
         " per turn of " + driver;
}

std::string ExponentialInWords(const std::string& size, const std::string& fades_with) {
  return "exponential in time: " + size + " that fade with " + fades_with;
}

std::string DeadbandInWords(const std::string& width, const std::string& driver, const std::string& slope) {
  return "a deadband of " + width + " about 0 of " + driver + ", beyond it " + slope;
}

std::string RowsAboveTheNoise() { return "rows in which it would stand out of the noise"; }

std::string CompliancesOfZero() { return "joint compliances of 0 (with others the weight of a link is link_gravity)"; }

std::string ComplianceAboveZero() { return "the joint's compliance above 0 (loaded rows)"; }

std::string GravityIsUnknown(const std::string& station) {
  return "the direction of gravity in the base frame: station " + station + " is not levelled";
}

std::string SearchingWithRepeatability(double sigma_rad) {
  return "once more with joints that deviate by " + std::to_string(std::lround(1e6 * sigma_rad)) + " urad";
}

std::string GroupInWords(ReadingGroup::Kind kind, const std::string& name) {
  switch (kind) {
    case ReadingGroup::Kind::kStation:
    case ReadingGroup::Kind::kMarker:
      break;
    case ReadingGroup::Kind::kRotations:
      return "the rotations";
    case ReadingGroup::Kind::kAxis:
      return "the readings along " + name;
    case ReadingGroup::Kind::kSight:
      return "the readings along the line of sight";
  }
  return "the readings of " + WordOf(kind) + " " + name;
}

std::string SearchingWithSigmaAlone(double factor) {
  return "once more with sigma " + Significant(factor, 2) + " times what is stated and joints that deviate as stated";
}

std::string SearchingWithGroups(const std::vector<ScaledGroup>& groups, const Measurements& data) {
  std::vector<std::string> all;
  for (const ScaledGroup& scaled : groups) {
    all.push_back(GroupInWords(scaled.group.kind, NameOf(scaled.group, data)) + " " + Significant(scaled.factor, 2) +
                  " times");
  }
  return "once more with noise other than stated: " + Enumerate(all);
}

std::string WeighingAboutWhatWasFound() { return "weighing once more about what was found"; }

}  // namespace sagitta
