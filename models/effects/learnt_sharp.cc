// Deviations that have no name and no width: a wave over another joint's angle or in time, a jump at a place, a loose
// marker that falls to the side that is down. As learnt_deviation.cc, but a sum of smooth functions would follow none
// of them between its knots or where no pose was measured.
#include <algorithm>
#include <cmath>

#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"
#include "models/effects/pose_functions.h"

namespace sagitta {
namespace {

using Kind = SettingDefinition::Kind;

std::string DriverOf(const EffectContext& context) { return context.spec->TextSetting("driver", ""); }

double ValueOf(const EffectContext& context) { return context.shot->q[context.chain().FindJoint(DriverOf(context))]; }

std::vector<EffectParameter> WaveWeights(const Robot& robot, const EffectSpec& spec) {
  return {WeightOfJoint(robot, spec, "cos"), WeightOfJoint(robot, spec, "sin")};
}

// Encoder side: cos cos(n q_driver) + sin sin(n q_driver).
void DeviateByWave(const EffectContext& context, ShotTerms* terms) {
  const double phase = context.spec->IntegerSetting("order", 1) * ValueOf(context);
  const double sign = context.joint_sign();
  terms->slots.push_back({context.joint_slot(), context.first_parameter, sign * std::cos(phase)});
  terms->slots.push_back({context.joint_slot(), context.first_parameter + 1, sign * std::sin(phase)});
}

std::vector<EffectParameter> JumpWeight(const Robot& robot, const EffectSpec& spec) {
  return {WeightOfJoint(robot, spec, "jump")};
}

// 0 before `from`, 1 beyond `to`, evenly more between them, where the jump lies somewhere.
double ShareBeyond(const EffectSpec& spec, double unit, double at) {
  const double from = unit * spec.NumberSetting("from", 0.0), to = unit * spec.NumberSetting("to", 1.0);
  return std::clamp((at - from) / (to - from), 0.0, 1.0);
}

// Encoder side.
void DeviateByJump(const EffectContext& context, ShotTerms* terms) {
  const double share = ShareBeyond(*context.spec, UnitOfJoint(*context.robot, DriverOf(context)), ValueOf(context));
  terms->slots.push_back({context.joint_slot(), context.first_parameter, share * context.joint_sign()});
}

std::vector<EffectParameter> SeatWeights(const Robot&, const EffectSpec&) {
  return {{"x", Quantity::kShift, kTypicalMovement},
          {"y", Quantity::kShift, kTypicalMovement},
          {"z", Quantity::kShift, kTypicalMovement}};
}

Vector3<double> DirectionOf(const EffectSpec& spec, const char* name) {
  const auto of = [&](const char* axis) { return spec.NumberSetting(std::string(name) + axis, 0.0); };
  return Vector3<double>(of("_x"), of("_y"), of("_z")).normalized();
}

// The marker is off its seat where gravity's component along a direction of the nominal flange is beyond `to`, on it
// before `from`, evenly between them.
void MoveToSeat(const EffectContext& context, ShotTerms* terms) {
  const EffectSpec& spec = *context.spec;
  const Vector3<double> down = DownInFlange(context.chain(), context.shot->q, DirectionOf(spec, "down"));
  const double share = ShareBeyond(spec, 1.0, DirectionOf(spec, "along").dot(down));
  for (size_t m = 0; m < context.markers->size(); ++m) {
    if ((*context.markers)[m] != spec.target) continue;
    for (int axis = 0; axis < 3; ++axis) {
      terms->markers.push_back(
          {static_cast<int>(m), context.first_parameter + axis, share * Vector3<double>::Unit(axis)});
    }
  }
}

// Where a jump lies.
std::vector<SettingDefinition> Between() {
  SettingDefinition to{"to", Kind::kNumber, "", {}};
  to.greater_than = "from";
  return {{"from", Kind::kNumber, "", {}}, to};
}

std::vector<EffectParameter> StationWaveWeights(const Robot&, const EffectSpec&) {
  std::vector<EffectParameter> weights;
  for (const char* name : {"x_cos", "x_sin", "y_cos", "y_sin", "z_cos", "z_sin"}) {
    weights.push_back({name, Quantity::kShift, kTypicalMovement});
  }
  return weights;
}

// Measured points of the station move along its axes by waves of one period, from the campaign's first row on.
void MoveStationByWave(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  const double phase = 2.0 * kPi * context.shot->time / context.spec->NumberSetting("period_s", 1.0);
  int parameter = context.first_parameter;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double wave : {std::cos(phase), std::sin(phase)}) {
      terms->station.push_back({parameter++, Matrix3<double>::Zero(), wave * Vector3<double>::Unit(axis)});
    }
  }
}

EffectDefinition OfJoint(EffectDefinition effect, const std::vector<SettingDefinition>& settings) {
  effect.settings = {{"driver", Kind::kJoint, "", {}}};
  effect.settings.insert(effect.settings.end(), settings.begin(), settings.end());
  effect.on_slide = OnSlide::kDiagnosed;
  return Empirical(std::move(effect));
}

}  // namespace

const EffectDefinition& LearntWaveDeviation() {
  static const EffectDefinition definition =
      OfJoint({"learnt_wave_deviation", "learnt wave of a joint", "wave over a joint's angle", EffectTarget::kJoint,
               WaveWeights, DeviateByWave},
              {{"order", Kind::kInteger, "", {}}});
  return definition;
}

const EffectDefinition& LearntJumpDeviation() {
  static const EffectDefinition definition =
      OfJoint({"learnt_jump_deviation", "learnt jump of a joint", "jump between two places of a joint",
               EffectTarget::kJoint, JumpWeight, DeviateByJump},
              Between());
  return definition;
}

const EffectDefinition& LearntMarkerSeat() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_marker_seat",
                            "learnt second seat of a marker",
                            "jump as gravity turns",
                            EffectTarget::kMarker,
                            SeatWeights,
                            MoveToSeat};
    for (const char* name : {"along_x", "along_y", "along_z", "down_x", "down_y", "down_z"}) {
      effect.settings.push_back({name, Kind::kNumber, "", {}});
    }
    for (const SettingDefinition& setting : Between()) effect.settings.push_back(setting);
    return Empirical(std::move(effect));
  }();
  return definition;
}

const EffectDefinition& LearntStationWave() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_station_wave",  "learnt wave of a station", "wave in time",
                            EffectTarget::kStation, StationWaveWeights,         MoveStationByWave};
    effect.settings = {{"period_s", Kind::kNumber, "", {}}};
    effect.settings[0].above = 0.0;
    effect.driven_by = EffectDriver::kTime;
    return Empirical(std::move(effect));
  }();
  return definition;
}

}  // namespace sagitta
