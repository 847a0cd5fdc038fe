// What is said where the robot of an estimate cannot have made the readings that it is compared with.
#pragma once

#include <string>
#include <vector>

#include "estimator/report/inspection_words.h"

namespace sagitta {

// What to do about an instrument or a robot that stands elsewhere.
std::string CalibrateNewPlace();
// A station of another name is mostly another place; known: names that the estimate has.
std::string StationIsNew(const std::string& known);

// median: distance of the robot as it stands, m; fitted: RMS with base poses and markers fitted to the rows, m.
Advice StandsElsewhere(double median, double fitted);
Advice NotThisRobot(double median, double fitted);
// Of rows that are too few for such a fit.
Advice NotTheseReadings(double median);
// why: what a reading of the rows says that explains them.
std::string MissesAndWhy(double median, const std::string& why);
// The rows of one marker from one station are off, others are not.
Advice LabelStandsElsewhere(const std::string& marker, const std::string& station, double median);

// reason: one of those above.
std::string RobotDidNotMakeThese(const std::string& reason);

// Some rows are far off, the others are not. beyond: m, from where on they count; by: distance of the first, m.
std::string RowsAreFarOff(size_t far, size_t all, double beyond, const std::string& first, double by);
// Of poses at which held parameters leave points open by `held_rms` (m, RMS distance); held: their names.
std::string CalibrationLeftOpen(double held_rms, const std::vector<std::string>& held);
// Of effects with a memory: what rows that are given without those before them are predicted from.
std::string BeginAtTheFirstRow(const std::vector<std::string>& effects);
// rms: over coordinates, m; excess: of what was predicted; known_rest: RMS distance beyond noise that the calibration
// left on unseen points, m, where these rows are off no more than that, else 0; remembering: effects that go with what
// was done before.
std::string RowsRefuteTheEstimate(double rms, double excess, double p_value, double known_rest,
                                  const std::vector<std::string>& remembering);
// rms: over coordinates, m; excess: of what is predicted of them.
std::string ReadingsContradict(double rms, double excess);
// RMS distances, m.
std::string WorseThanNominalOnThese(double calibrated, double nominal);

}  // namespace sagitta
