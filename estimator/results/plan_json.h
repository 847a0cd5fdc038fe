// plan.json (sagitta/plan/1) and plan.csv: what a plan says, and the poses as a measurement file without readings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "estimator/planning/plan.h"
#include "estimator/report/planning_words.h"
#include "models/chain.h"

namespace sagitta {

nlohmann::ordered_json PlanToJson(const Plan& plan);

// config, marker, station, joint values (deg, mm): what every row of a plan has.
std::string PlanColumns(const Chain& chain);
// A row of these for each reading, and visit, repeat, approach, load, wrench, sigma columns where a row has some; time
// and temperature, as they are assumed, where effects go with them.
std::string PlanToCsv(const Chain& chain, const Plan& plan);

// What an estimate.json says of its model's error: model_error.factor, and by how much the points of its
// cross-validation are off beyond what the stated noise predicts. Throws InputError for a text without the former.
void ReadModelError(const std::string& estimate_json, const std::string& file_in_messages, PlanRequest* request);

// Half the 95 % interval that is expected of a parameter, with model error, SI.
double HalfWidth95(const Plan& plan, const PlannedParameter& parameter);

}  // namespace sagitta
