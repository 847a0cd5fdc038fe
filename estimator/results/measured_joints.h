// The joint ranges that an estimate was measured in, and poses outside of them: nothing has checked it there.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "estimator/compensation/compensate.h"
#include "estimator/results/estimate_json.h"
#include "problems/io/json_reader.h"

namespace sagitta {

// Of the calibration rows, as estimate.json has it: [{joint, min_deg, max_deg}], prismatic ones in mm.
nlohmann::ordered_json MeasuredJointsToJson(const CalibrationProblem& problem);
std::vector<MeasuredInterval> MeasuredJointsFrom(const JsonValue& list, const Chain& chain);

// By how much a value is outside of a range; 0: inside, or by no more than `least` or a tenth of the range, so that any
// next value may be.
double OutsideBy(const MeasuredInterval& range, double value, double least);

// The joints that are outside at these values, each with by how much: "j1 by 100 deg". Empty: inside, or not known.
std::vector<std::string> OutsideMeasured(const KnownRobot& known, const Eigen::VectorXd& q);

// A sentence on configurations outside; empty: there are none.
std::string OutsideMeasuredInWords(const KnownRobot& known, const std::vector<Configuration>& configurations);

// Adds it to the words of each target outside. Returns how many there are.
size_t AddOutsideMeasured(const KnownRobot& known, std::vector<CompensatedTarget>* results);

}  // namespace sagitta
