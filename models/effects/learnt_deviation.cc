// Deviations that have no name, as smooth functions of what drives them (bump.h): of a joint, of a station's readings, of
// a marker. The diagnosis fits them to what no effect of the catalogue explains. They describe what was measured, and
// say nothing beyond the driver's range: there they fade to zero.
#include "models/effects/bump.h"
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

constexpr double kTypicalTurn = 75e-6, kTypicalTravel = 50e-6, kTypicalMovement = 30e-6;  // rad, m, m: `sizes`

constexpr char kDescribes[] = "It describes what was measured and is no cause; beyond its range it is zero.";

// Number of weights along one axis; what a file states is checked to be 2 or more.
int KnotCount(const EffectSpec& spec) { return spec.IntegerSetting("knots", 2); }

bool IsBy(const EffectSpec& spec, const char* driver) { return spec.TextSetting("by", "time_s") == driver; }

bool DrivesByLength(const Robot& robot, const EffectSpec& spec) {
  const int joint = robot.chain.FindJoint(spec.TextSetting("driver", ""));
  return joint >= 0 && robot.chain.joints[joint].type == JointType::kPrismatic;
}

// In SI: what files state in deg or mm, N m or N, s, K.
Knots KnotsOf(const Robot& robot, const EffectSpec& spec) {
  const double unit = !IsBy(spec, "q") ? 1.0 : DrivesByLength(robot, spec) ? 1e-3 : kDegree;
  return {unit * spec.NumberSetting("from", 0.0), unit * spec.NumberSetting("to", 1.0), KnotCount(spec)};
}

double DriverValue(const EffectContext& context) {
  if (IsBy(*context.spec, "q")) {
    return context.shot->q[context.chain().FindJoint(context.spec->TextSetting("driver", ""))];
  }
  return IsBy(*context.spec, "temperature_K") ? context.shot->temperature : context.shot->time;
}

std::string Missing(const EffectContext& context) {
  if (IsBy(*context.spec, "time_s") && !context.shot->has_time) return "time_s";
  if (IsBy(*context.spec, "temperature_K") && !context.shot->has_temperature) return "temperature_degC";
  return "";
}

std::vector<EffectParameter> Weights(const EffectSpec& spec, const std::string& prefix, Quantity quantity,
                                     double typical) {
  std::vector<EffectParameter> weights;
  for (int k = 1; k <= KnotCount(spec); ++k) weights.push_back({prefix + std::to_string(k), quantity, typical});
  return weights;
}

std::vector<EffectParameter> JointWeights(const Robot& robot, const EffectSpec& spec) {
  const int joint = robot.chain.FindJoint(spec.target);
  const bool slides = joint >= 0 && robot.chain.joints[joint].type == JointType::kPrismatic;
  return slides ? Weights(spec, "w", Quantity::kShift, kTypicalTravel)
                : Weights(spec, "w", Quantity::kSmallAngle, kTypicalTurn);
}

std::vector<EffectParameter> PointWeights(const Robot&, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (const char* axis : {"x", "y", "z"}) {
    for (const EffectParameter& weight : Weights(spec, axis, Quantity::kShift, kTypicalMovement)) {
      weights.push_back(weight);
    }
  }
  return weights;
}

void DeviateJoint(const EffectContext& context, ShotTerms* terms) {
  const Knots knots = KnotsOf(*context.robot, *context.spec);
  const double sign = context.joint_sign();
  for (int k = 0; k < knots.count; ++k) {
    const int parameter = context.first_parameter + k;
    if (IsBy(*context.spec, "torque_Nm")) {
      terms->elastic.push_back(
          {context.joint_slot(), parameter, sign, ElasticLaw::kBump, knots.Apart(), knots.At(k)});
    } else {
      terms->slots.push_back({context.joint_slot(), parameter, sign * knots.Value(k, DriverValue(context))});
    }
  }
}

// Calls with each weight's parameter, axis and bump.
template <typename Use>
void ForEachAxis(const EffectContext& context, const Use& use) {
  const Knots knots = KnotsOf(*context.robot, *context.spec);
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < knots.count; ++k) {
      use(context.first_parameter + axis * knots.count + k, Vector3<double>::Unit(axis),
          knots.Value(k, DriverValue(context)));
    }
  }
}

void MoveStation(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  ForEachAxis(context, [&](int parameter, const Vector3<double>& axis, double bump) {
    terms->station.push_back({parameter, Matrix3<double>::Zero(), bump * axis});
  });
}

void MoveMarker(const EffectContext& context, ShotTerms* terms) {
  for (size_t m = 0; m < context.markers->size(); ++m) {
    if ((*context.markers)[m] != context.spec->target) continue;
    ForEachAxis(context, [&](int parameter, const Vector3<double>& axis, double bump) {
      terms->markers.push_back({static_cast<int>(m), parameter, bump * axis});
    });
  }
}

// `drivers`: the first is the usual one.
EffectDefinition Learnt(EffectDefinition effect, const std::vector<std::string>& drivers) {
  using Kind = SettingDefinition::Kind;
  SettingDefinition driver{"driver", Kind::kJoint, "", {}};
  driver.only_with = "by=q";
  SettingDefinition knots{"knots", Kind::kInteger, "", {}};
  knots.least = 2;
  SettingDefinition to{"to", Kind::kNumber, "", {}};
  to.greater_than = "from";
  effect.settings = {{"by", Kind::kChoice, "", drivers},
                     driver,
                     {"from", Kind::kNumber, "", {}},
                     to,
                     knots};
  effect.missing = Missing;
  effect.is_learnt = true;
  effect.note = kDescribes;
  effect.sizes = "as a periodic joint error, and as what moves a station or a marker";
  return effect;
}

}  // namespace

const EffectDefinition& LearntDeviation() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_deviation",   "learnt deviation of a joint", "smooth function of its driver",
                            EffectTarget::kJoint, JointWeights,                  DeviateJoint};
    effect.on_prismatic = true;
    return Learnt(effect, {"q", "torque_Nm", "time_s", "temperature_K"});
  }();
  return definition;
}

const EffectDefinition& LearntStationMotion() {
  static const EffectDefinition definition =
      Learnt({"learnt_station_motion", "learnt motion of a station", "smooth function of its driver",
              EffectTarget::kStation, PointWeights, MoveStation},
             {"time_s", "temperature_K"});
  return definition;
}

const EffectDefinition& LearntMarkerMotion() {
  static const EffectDefinition definition =
      Learnt({"learnt_marker_motion", "learnt motion of a marker", "smooth function of its driver",
              EffectTarget::kMarker, PointWeights, MoveMarker},
             {"time_s", "q", "temperature_K"});
  return definition;
}

}  // namespace sagitta
