// What hangs on the arm in each shot: experiment and rows as wrenches.
#pragma once

#include <vector>

#include "models/forward_model.h"
#include "problems/experiment.h"
#include "problems/measurements.h"

namespace sagitta {

// True for a shot with a load other than `none`.
bool IsLoaded(const Shot& shot);

// Refuses a load on some markers of a shot only: the markers of one visit and
// repeat shared out between `none` and a load, although they are measured
// together elsewhere. Warns where nothing is measured unloaded.
void CheckLoadStates(Measurements* data);

// `loads` of the experiment against the rows: a misspelt id is refused, one that no row has is said, and so is a mass
// that weighs something else than the wrench columns say (they count).
void CheckStatedLoads(const Experiment& experiment, Measurements* data);

// Those of the experiment where it states them; a station that it does not know counts from its own earliest row.
ConditionOrigins OriginsOf(const Measurements& data, const Experiment& experiment);

// The robot's temperature counts from where its file says, unless the experiment says it.
void CountFromReference(const Robot& robot, Experiment* experiment);

// One input per shot, prepared for the model: joint values, conditions, the
// tool's weight, the shot's own load.
// A load acts at its own point or at load_point; its force is the row's or, where the columns of the force are absent
// or zero, mass times gravity, to which the row's moments are added. Throws InputError for a load without a point,
// without a force, or a wrench on load `none`.
std::vector<ShotInput> MakeShotInputs(const ForwardModel& model, const Measurements& data,
                                      const Experiment& experiment);

}  // namespace sagitta
