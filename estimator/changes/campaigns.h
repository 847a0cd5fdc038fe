// Two campaigns on one robot: what both measured, and in which configurations and as of when they are compared.
//
// Where an instrument stands and what hangs on the flange are of a campaign, not of the robot. Names that both use are
// compared. Where no station (no marker on the flange) has a name that both use, one of each is put in its place, and
// what it is for is left open: its coordinates differ by any amount, and nothing is said of them.
//
// Each as of one moment: the old one as it was at its end, the new one as it was at its beginning. What happened within
// a campaign (a slip, a reseated marker, a jump that was learnt) is named by its own estimate, and is no change between
// the two.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "estimator/results/estimate_json.h"

namespace sagitta {

// What is compared under one name although each campaign has its own.
struct CampaignsOwn {
  bool station = false;
  bool markers = false;
};

// Throws InputError where the robots are not of one build.
void CheckSameRobot(const KnownRobot& old_estimate, const KnownRobot& new_estimate);

// Gives a station and markers of the new campaign the names of the old one's where none is shared. Throws InputError
// where neither campaign has anything for it.
CampaignsOwn PairCampaigns(const KnownRobot& old_estimate, KnownRobot* new_estimate);

// The share of a joint's wider measured range that both campaigns have, of the joint where that is least; 1: not
// stated.
struct CommonRange {
  double share = 1.0;
  size_t joint = 0;

  // Parts of a campaign, by which it is judged what its model lacks, are halves of one joint's range.
  bool IsLessThanParts() const { return share < 0.5; }
};
CommonRange LeastCommonRange(const KnownRobot& a, const KnownRobot& b);

// Configurations over the joints' limits (a third of a turn to either side without), alternating over the stations;
// unloaded and, where a load point is known, loaded. Campaigns that have less in common than parts of one are compared
// over what they have in common: elsewhere one of them extrapolates what its model lacks.
Measurements RowsOfBoth(const KnownRobot& old_estimate, const KnownRobot& new_estimate, const CampaignsOwn& own);

// s of the campaign's clock, and by station since its first row.
struct ComparedMoment {
  double time = 0.0;
  std::map<std::string, double> station_time = {};
};

// After the last row; in files that do not state it, after all that happened at a moment.
ComparedMoment EndOf(const KnownRobot& known);

// The stations where either estimate has what goes back to nothing and begins anew each time, as warming up does: both
// are compared at the first row, in the same state.
std::vector<std::string> StationsBegunAnew(const KnownRobot& a, const KnownRobot& b);

// Whether this parameter's effect is of one campaign's course of time: an event at a moment, or a learnt function of
// time. The other campaign assumed nothing of it.
bool IsOfItsCourse(const KnownRobot& known, const std::string& coordinate);

// What happened within a campaign and is beyond two standard deviations, by title.
std::vector<std::string> HappenedWithin(const KnownRobot& known);

// All shots of a comparison at that moment; stations that it does not name at their first row.
void SetMoment(const ComparedMoment& moment, CalibrationProblem* problem);

// m, per marker in the frame it is on: where events have moved it to, from its point.
std::vector<Vector3<double>> MovedByEvents(const CalibrationProblem& problem);

}  // namespace sagitta
