// What an inspection says of data, loads and rows: words, and what to do about it. Numbers come in SI.
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"
#include "models/geometry.h"

namespace sagitta {

// Progress.
std::string ReadingOtherwise();
std::string LinearizingAtNominal();

// What is wrong, and what to do about it.
struct Advice {
  std::string words;
  std::string remedy;
};

// A joint that stood still, or that covers `share` of its limits (0: it has none): from `least` to `most`, rad or m.
Advice JointNeverMoved(const Joint& joint, double least, double most);
std::string JointStands(const Joint& joint, double least, double most);
Advice JointBeyondLimits(const Joint& joint, double least, double most);
Advice JointCoversLittle(const Joint& joint, double least, double most, double share);

// `stations`: the ones concerned, "" for all. axis: about which the flange turns, in its own frame, unit.
Advice OrientationIsConstant(const std::string& stations);
Advice OrientationAboutOneAxis(const Vector3<double>& axis, const std::string& stations);

// Counts of the calibration rows.
Advice FewConfigurations(int configurations, int equations, int unknowns);
Advice PosesAreRepeated(size_t configurations);
Advice PointsAreCopied(size_t rows);
Advice LoadedWithoutUnloaded(size_t shots);

// What the data do not state or have, and what that leaves open.
enum class Missing { kSigma, kApproach, kVisits, kTime, kTemperature, kMarkers };
Advice MissingFromData(Missing what);

// A load that moves the markers by `size` (m, median), `flexibility` (m/N) of it; or against its force.
Advice LoadUnitIsOff(const std::string& load, double size, double flexibility, bool is_too_soft);
Advice LoadSignIsOff(const std::string& load);
// angle: rad, between the directions (base frame) that weights are stated to pull in and that the deflections fit;
// left: what they miss the deflections by, m RMS per coordinate. in_frame: the latter in the frame of the stated one.
// in_columns: rows state the forces, which no other gravity turns.
Advice LoadsPullAcross(double angle, const Vector3<double>& fitted, const Vector3<double>& stated,
                       const Vector3<double>& in_frame, bool is_base, bool in_columns, double left_stated, double left);
std::string WeightsPullAcross(double angle);

// misfit: of the aligned nominal robot as stated, m RMS; `as_read`: with the other reading `name`. alike: others that
// fit as well. limits_decide: still others do so beyond the joints' limits.
std::string MisfitOfReading(double misfit, double as_read, const std::string& name,
                            const std::vector<std::string>& alike, bool limits_decide);
// is_one_station: all rows are of one.
Advice MisfitUnexplained(double misfit, bool is_one_station);
// What would have to be off for the robot to be this one: `by` (m or rad) in the largest error, so named.
std::string ErrorsThatWouldExplain(double by, bool is_length, const std::string& largest);

// `far` of `all` rows are off, half of them by more than `median` (m), the others within `near_rms` (m).
Advice RowsAreWild(size_t far, size_t all, double median, double near_rms, const std::string& first);
// Rows off by `least` to `most` (m); the median is of all (m).
Advice RowsAreOff(size_t rows, double least, double most, double median);
Advice MarkersAreExchanged(size_t shots, size_t pairs, const std::string& first_pair);
Advice RestsOnOneConfiguration(const std::string& names);

// folded: the shot (FoldedShot), "" where it is not known.
Advice ArmFolds(const std::string& folded);

// Columns that are carried along only; "" where there are none.
std::string NotReadInWords(const std::vector<std::string>& columns);

// Joints by how measured and modelled torques compare; of `scaled` each with its factor.
struct TorqueGroups {
  std::vector<std::string> agree, opposite, scaled, differ, untold;
};
// measured_count: the estimate goes by the measured ones.
std::string TorquesInWords(bool measured_count, const TorqueGroups& joints);

}  // namespace sagitta
