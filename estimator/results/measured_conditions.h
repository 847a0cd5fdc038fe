// The times, temperatures and loads that an estimate was measured at, and rows beyond them: nothing has checked it
// there.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "estimator/results/estimate_json.h"
#include "problems/io/json_reader.h"

namespace sagitta {

// Of the calibration rows, as estimate.json has it: {time_s: [first, last], temperature_degC: [least, most],
// load_force_N: largest, moments: [{after_s, between_s: [last reading before it, first one after it]}]}; null: no row
// states it, or none bears a load.
nlohmann::ordered_json MeasuredConditionsToJson(const CalibrationProblem& problem);
MeasuredConditions MeasuredConditionsFrom(const JsonValue& json);

// A sentence each on shots beyond the loads, beyond the times and temperatures that an effect of the robot goes with,
// and between the readings between which something happened. `problem`: a PredictionProblem of `known`.
std::vector<std::string> BeyondMeasuredInWords(const KnownRobot& known, const CalibrationProblem& problem);

}  // namespace sagitta
