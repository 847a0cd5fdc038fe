// Two campaigns on one robot: what both measured, and in which configurations their estimates are compared.
//
// Where an instrument stands and what hangs on the flange are of a campaign, not of the robot. Names that both use are
// compared. Where no station (no marker on the flange) has a name that both use, one of each is put in its place, and
// what it is for is left open: its coordinates differ by any amount, and nothing is said of them.
#pragma once

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

}  // namespace sagitta
