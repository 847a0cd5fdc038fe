// What estimate.json says of intervals beyond sigma and ci95: how they came
// about, and what held parameters leave open.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estimator/estimate/estimate.h"
#include "estimator/intervals/prediction.h"
#include "problems/io/json_reader.h"

namespace sagitta {

// {"method", "words", "clusters", "kind", "replicates", "failed", "seed"}.
nlohmann::ordered_json IntervalsToJson(const IntervalReport& intervals);

// [low, high] in units of so many SI units; null where an end is open.
nlohmann::ordered_json PairOf(const Interval& interval, double unit, bool open_low = false, bool open_high = false);

// Adds ci95, interval, dof, open and unconditional to a parameter's entry.
void AddIntervalTo(const ParameterEstimate& row, const Estimate& estimate, nlohmann::ordered_json* json);

// {"names", "sigma", "unit", "correlation", "estimated", "slopes"}: the held
// parameters, how far each may be off, and by how much the estimated ones move
// with them (rows as in `correlation.names`), in units of results.
nlohmann::ordered_json HeldToJson(const Estimate& estimate);

// The inverse of HeldToJson. `uncertainty`: its estimated names are there. Throws InputError on a wrong shape.
void ReadHeld(const JsonValue& json, ParameterUncertainty* uncertainty);

}  // namespace sagitta
