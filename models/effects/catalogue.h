// The catalogue of effects: one list, in the order of FORMATS section 5 (equals go
// to the earlier). The gravity compensator, whose torque is not linear in its
// parameters, has its home in the robot (gravity_compensator.h).
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "models/effects/effect.h"

namespace sagitta {

const EffectDefinition& FrozenGeometry();
const EffectDefinition& JointComplianceEffect();
const EffectDefinition& ComplianceHardening();
const EffectDefinition& TransverseCompliance();
const EffectDefinition& LinkGravity();
const EffectDefinition& SelfWeightSag();
const EffectDefinition& BaseCompliance();
const EffectDefinition& Payload();
const EffectDefinition& JointHarmonic();
const EffectDefinition& AxisWobble();
const EffectDefinition& EncoderGain();
const EffectDefinition& JointCoupling();
const EffectDefinition& Backlash();
const EffectDefinition& JointSlip();
const EffectDefinition& ThermalGrowth();
const EffectDefinition& StationDrift();
const EffectDefinition& StationScale();
const EffectDefinition& MarkerShift();
const EffectDefinition& WarmUp();
const EffectDefinition& StationEccentricity();
const EffectDefinition& StationRangeOffset();
const EffectDefinition& LoadCom();
const EffectDefinition& Hysteresis();
const EffectDefinition& MarkerAcceptance();
const EffectDefinition& StationRefraction();
// What has no name (learnt_deviation.cc, learnt_by_two.cc).
const EffectDefinition& LearntDeviation();
const EffectDefinition& LearntWaveDeviation();
const EffectDefinition& LearntJumpDeviation();
const EffectDefinition& LearntPairDeviation();
const EffectDefinition& LearntProductDeviation();
const EffectDefinition& LearntSurfaceDeviation();
const EffectDefinition& LearntGrowth();
const EffectDefinition& LearntStationMotion();
const EffectDefinition& LearntStationWave();
const EffectDefinition& LearntMarkerMotion();
const EffectDefinition& LearntMarkerSeat();
const EffectDefinition& LearntStationField();
const EffectDefinition& LearntLoadShift();
const EffectDefinition& LearntLoadSlide();
const EffectDefinition& LearntToolMotion();
const EffectDefinition& LearntPull();
const EffectDefinition& LearntLag();
const EffectDefinition& LearntReading();
const EffectDefinition& LearntRangeWave();

// EffectDefinition::separate_by of several effects.
constexpr char kSeparateByRange[] =
    "poses with {target} evenly over its whole range, the other joints independent of it";
constexpr char kSeparateByWeight[] =
    "poses with {target} over its whole range, loaded and unloaded, and with the links beyond it folded and stretched";
constexpr char kSeparateByLoads[] = "loads in other directions: sideways pulls and other load points";
constexpr char kSeparateByReturn[] = "the first poses repeated at the end";

// "" or the column that this shot lacks for the effect: what drives it, or another that it asks for.
std::string MissingColumn(const EffectDefinition& definition, const EffectContext& context);

const std::vector<const EffectDefinition*>& EffectCatalogue();

// Null: no effect of that name.
const EffectDefinition* FindEffect(const std::string& name);
std::vector<std::string> EffectNames();

// The same for a robot: the catalogue, then the user's own definitions that it
// carries (Robot::own_effects). Whatever has a robot asks here.
std::vector<const EffectDefinition*> EffectsOf(const Robot& robot);
const EffectDefinition* FindEffect(const Robot& robot, const std::string& name);
std::vector<std::string> EffectNames(const Robot& robot);

// The effect of the catalogue that a name of its parameter (effect/payload/L1/dmass) or of its use begins with; null:
// it is of none.
const EffectDefinition* EffectOfName(const std::string& name);
// Whether it is a use of that effect of the catalogue.
inline bool IsUseOf(const EffectDefinition& definition, const EffectSpec& spec) {
  return spec.effect == definition.name;
}

// Whether times of the campaign's clock drive this use.
bool GoesWithTime(const Robot& robot, const EffectSpec& spec);
// Whether a shot has it as the shots before left it (EffectDefinition::remember): heat follows a thermometer at once
// where no lag is stated.
bool CarriesOn(const EffectDefinition& definition, const EffectSpec& spec);
// Name of its setting that is a moment, "" where there is none (of the compensator too).
std::string MomentOf(const Robot& robot, const EffectSpec& spec);

}  // namespace sagitta
