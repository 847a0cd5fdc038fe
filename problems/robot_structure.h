// What a robot made in memory has to be, which the readers of files see to by themselves.
#pragma once

#include <string>
#include <vector>

#include "models/robot.h"

namespace sagitta {

// Chain, table, compliances, compensator, own effects and effects. Throws InputError that names the joint, transform,
// compliance or effect.
void CheckRobotStructure(const Robot& robot);

// Definitions of the user's own that can be called, under names that the catalogue has not. Throws InputError.
void CheckOwnEffects(const std::vector<const EffectDefinition*>& own_effects);

// Effects that there are, no more values than they have parameters. Throws InputError.
void CheckEffectsAreThere(const Robot& robot);

// The same, with the settings, targets and numbers of values that they need. Throws InputError.
void CheckEffectSpecs(const Robot& robot);
// Why an effect of joints that turn is refused on one that slides.
std::string IsForJointsThatTurn(const std::string& sliding_joint);

}  // namespace sagitta
