// What the joint estimate says of itself: why it stopped, what its intervals are, what contradicts it, which load would
// determine what is held. Numbers come in SI.
#pragma once

#include <string>
#include <vector>

#include "models/geometry.h"

namespace sagitta {

// Progress: the first phase.
std::string AligningNominal();

// Why an estimate is none, or is one.
std::string EverythingHeld();
std::string SingularAtOptimum();
std::string SingularAtEstimate();
// steps: of the remaining Gauss-Newton step, in standard deviations; `because`: of the minimiser.
std::string StoppedBefore(double steps, const std::string& because);
std::string ConvergedWithHeld(size_t held);
std::string HeldAtStatedNoise(size_t held);
std::string Converged();
// folded: the shot (FoldedShot), "" where it is not known.
std::string FoldedShotInWords(const std::string& folded);
// A load's name; "": the spring or the tool's weight.
std::string ShotThatFolds(const std::string& load, const std::string& configuration, const std::string& row);

// mass: kg, of the load with what was added to it; off: m, flange frame, from the stated point.
std::string CentreOfHeavierLoad(const std::string& load, double mass, const Vector3<double>& off);

std::string SandwichInWords(int clusters);
// A joint that follows another one by a stated coupling, and what of the other one it does not follow.
std::string FollowsTheCommandAlone(const std::string& joint, const std::string& driver);

// below: how far below its bound the data want it, in standard deviations; by_sensor: measured torques drive it.
std::string StandsOnBound(const std::string& parameter, double below, bool by_sensor);

// Loads to hang or pull with. reached: what the parameter would be known to, in its unit.
std::string ReachedInWords(const std::string& parameter, double reached, const std::string& unit);
std::string PullSideways(double newtons, const std::vector<std::string>& configurations, const std::string& reached);
std::string HangOffAxis(const Vector3<double>& point, const std::vector<std::string>& configurations,
                        const std::string& reached);
std::string NoLoadDetermines();
std::string MarkersAreOnTheAxis(const std::string& joint);
// What would determine the compensator: its markers are tied to it, or its L is what is open, or else.
enum class SpringDoubt { kTied, kLength, kOther };
std::string SpringRemedyInWords(SpringDoubt doubt);

// misfit: of the aligned nominal robot, m RMS, as the columns say and as `unit`.
std::string NumbersLookLike(const std::string& unit, double misfit, double misfit_as_unit);
// column: that could carry the unit in its name; "": none.
std::string ConvertNumbers(const std::string& column);
// One length that is corrected, m.
std::string CorrectedLength(const std::string& parameter, double length, double by);
std::string LengthsAreCorrected(const std::vector<std::string>& lengths);
std::string CalibratedRobotMisses(double distance_rms);

}  // namespace sagitta
