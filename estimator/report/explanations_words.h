// What may be missing, in words: what moves, with what, and by how much; and what the data lack to show it.
#pragma once

#include <string>
#include <vector>

#include "problems/reading_group.h"

namespace sagitta {

// `driver` is a joint, "time", "temperature" or "the torque on it".
std::string DeviatesWith(const std::string& joint, const std::string& driver);
std::string DeviatesWithBoth(const std::string& joint, const std::string& one, const std::string& other);
std::string DeviatesOver(const std::string& joint, const std::string& one, const std::string& other);
std::string RepeatsPerTurn(const std::string& joint, int times);
std::string JointsFollowPose();
// A cause without a name that in part does what this effect does.
std::string PartlyLike(const std::string& effect, const std::string& target);
std::string EachJointDeviatesWithTime();
// `what` is one of the next two.
std::string FollowsLate(const std::string& joint, const std::string& what);
std::string EachJointFollowsLate(const std::string& what);
std::string TorqueOnIt();
std::string HeatOfItsMotion();
std::string ForcePulls();
std::string StationMoves(const std::string& station);
std::string StationMovesWithTemperature(const std::string& station);
std::string StationMovesAsABody(const std::string& station);
std::string BaseTurnsInStation(const std::string& station);
std::string BaseTurnsWith(const std::string& station, const std::string& driver);
std::string StationGrows(const std::string& station);
std::string StationMovesAlong(const std::string& station, char axis);
std::string StationIsDistorted(const std::string& station);
// `reading` and `over`: azimuth or elevation. The period comes as text, in mm.
std::string ReadsWrongOver(const std::string& station, const std::string& reading, const std::string& over);
std::string RangeRepeats(const std::string& station, const std::string& period);
std::string MarkerMovesWith(const std::string& marker, const std::string& driver);
// `what` sits loose.
std::string MovesWithGravity(const std::string& what);
std::string PlateGivesWay();
std::string FallsIntoAnotherSeat(const std::string& what);
std::string LoadShiftsWithGravity(const std::string& load);
// `along`: x, y, z or each axis.
std::string LoadSlides(const std::string& load, const std::string& along);
std::string ChangesItsSeat(const std::string& what);
std::string ToolMoves();
// `axis`: x, y or z of the flange.
std::string ToolMovesAlong(const std::string& axis);
std::string ToolTurnsAbout(const std::string& axis);

// Shapes of a learnt function; sizes come as text with their units.
std::string WaveInWords(const std::string& size, int per_turn, const std::string& driver);
std::string ExponentialInWords(const std::string& size, const std::string& fades_with);
std::string DeadbandInWords(const std::string& width, const std::string& driver, const std::string& slope);

// What is missing to see an effect that no row shows.
std::string RowsAboveTheNoise();
// A spring needs a joint that gives.
std::string ComplianceAboveZero();
std::string CompliancesOfZero();
// Of an effect of weights, where the station is not levelled.
std::string GravityIsUnknown(const std::string& station);

// Progress: the search among sets is repeated with this repeatability.
std::string SearchingWithRepeatability(double sigma_rad);
// "the readings of station S2".
std::string GroupInWords(ReadingGroup::Kind kind, const std::string& name);
std::string SearchingWithSigmaAlone(double factor);
std::string SearchingWithGroups(const std::vector<ScaledGroup>& groups, const Measurements& data);
// All is weighed once more, from an estimate that holds what was found.
std::string WeighingAboutWhatWasFound();

}  // namespace sagitta
