// What changed between two estimates, in words.
#pragma once

#include <string>
#include <vector>

#include "estimator/changes/changes.h"

namespace sagitta {

std::string ChangeInWords(const Change& change);

// What the rotation of a motion adds, mrad.
std::string TurnedInWords(double angle_mrad);

// All changes in one sentence, with their probabilities.
std::string ChangesInWords(const Changes& changes);

// Parameters that one file estimates and the other assumes.
std::string ChangesOpen(const std::string& file, const std::vector<std::string>& parameters);

// What happened within the old, the new campaign, by title.
std::string ComparedAtItsEnd(const std::string& old_file, const std::vector<std::string>& happened);
std::string ComparedAtItsBeginning(const std::string& new_file, const std::vector<std::string>& happened);

// Stations, markers of two campaigns that have no name in common.
std::string StationsAreOwn(const std::string& old_file, const std::string& new_file);
std::string MarkersAreOwn(const std::string& old_file, const std::string& new_file);

// Joints whose slip would look like what each campaign has of its own, or like these motions of bases and tool.
std::string ZerosAreHidden(const std::vector<std::string>& joints);
std::string ZerosAreHidden(const std::vector<std::string>& joints, const std::vector<ChangeKind>& motions);

// No set of changes leads from one estimate to the other.
std::string TooFarApart(const std::string& old_file, const std::string& new_file);

// Of an estimate whose parts disagree by more than noise allows; factor: by so much on intervals.
std::string LacksSomething(const std::string& file, double factor);
// factor: by which its configurations err beyond noise, as random halves and points of one shot show.
std::string ConfigurationsErr(const std::string& file, double factor);
// The joint with the smallest share of its wider range in both campaigns; model_error: m.
std::string RegionsDiffer(const std::string& joint, double share, double model_error);
// Of several compliances at once: the shares of what they were.
std::string OneLoadDoesThatToo(double least, double most);
// More is left than both estimates leave open; rms in m.
std::string MoreIsLeft(double rms);

}  // namespace sagitta
