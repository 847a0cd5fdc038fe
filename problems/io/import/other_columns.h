// What a foreign table has in addition to joints and points: loads, times, temperatures, names, and what is not used.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "problems/io/import/column_meaning.h"
#include "problems/io/import/import_plan.h"

namespace sagitta {

// Of a column its header, or its number where it has none.
std::string HeaderOfColumn(const TextTable& table, int column);

// Adds the columns that are none of `taken` to the plan, or to what is not used with the reason.
void AddOtherColumns(const TextTable& table, const std::vector<ColumnMeaning>& meanings, const std::set<int>& taken,
                     ImportPlan* plan);

// Adds the columns of a list of poses that were not joined to what is not used.
void AddColumnsNotJoined(const TextTable& table, ImportPlan* plan);

// Why a column without a role is not used; of an axis outside the arm also how far it moved (moved: whether it did).
std::string WhyNotUsed(const TextTable& table, int column, const ColumnMeaning& meaning, bool* moved);

// What to do where a table has azimuth, zenith angle and distance in place of x, y, z; "" where it has not.
std::string HintOfSphericalReadings(const std::vector<std::string>& headers);

// Throws InputError where the joint values of a plan are pulses of encoders: whole numbers beyond ten turns.
void RefusePulses(const TextTable& table, const ImportPlan& plan, const std::vector<Joint>& joints);

}  // namespace sagitta
