// Deviations that have no name, as smooth functions of what drives them (bump.h): of a joint, of a station's readings,
// of a marker, of the lengths of the links; and of a joint by two angles together. The diagnosis fits them to what no
// effect of the catalogue explains. They describe what was measured, and say nothing beyond the driver's range: there
// they fade to zero.
#include "models/effects/learnt_deviation.h"

#include <cmath>

#include "models/effects/bump.h"
#include "models/effects/catalogue.h"

namespace sagitta {

std::vector<std::vector<int>> LengthsByLink(const Chain& chain) {
  std::vector<std::vector<int>> links(1);
  for (int e = 0; e < chain.num_transforms(); ++e) {
    const ElementaryTransform& transform = chain.transforms[e];
    if (transform.has_joint()) links.emplace_back();
    if (!transform.is_rotation() && !transform.has_joint() && transform.nominal != 0.0) links.back().push_back(e);
  }
  return links;
}

namespace {

constexpr char kSeparateByKnowing[] = "nothing: it is whatever has no name; a cause that is known takes its place";
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

void AppendWeights(const EffectSpec& spec, const std::string& prefix, Quantity quantity, double typical,
                   std::vector<EffectParameter>* weights) {
  for (int k = 1; k <= KnotCount(spec); ++k) weights->push_back({prefix + std::to_string(k), quantity, typical});
}

std::vector<EffectParameter> JointWeights(const Robot& robot, const EffectSpec& spec) {
  const int joint = robot.chain.FindJoint(spec.target);
  const bool slides = joint >= 0 && robot.chain.joints[joint].type == JointType::kPrismatic;
  std::vector<EffectParameter> weights;
  AppendWeights(spec, "w", slides ? Quantity::kShift : Quantity::kSmallAngle, slides ? kTypicalTravel : kTypicalTurn,
                &weights);
  return weights;
}

std::vector<EffectParameter> PointWeights(const Robot&, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (const char* axis : {"x", "y", "z"}) AppendWeights(spec, axis, Quantity::kShift, kTypicalMovement, &weights);
  return weights;
}

std::vector<EffectParameter> StationWeights(const Robot& robot, const EffectSpec& spec) {
  std::vector<EffectParameter> weights = PointWeights(robot, spec);
  for (const char* axis : {"rx", "ry", "rz"}) {
    AppendWeights(spec, axis, Quantity::kSmallAngle, kTypicalStationTurn, &weights);
  }
  return weights;
}

// g<link>_<knot>, of links that have a length.
std::vector<EffectParameter> GrowthWeights(const Robot& robot, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  const std::vector<std::vector<int>> links = LengthsByLink(robot.chain);
  for (size_t link = 0; link < links.size(); ++link) {
    if (links[link].empty()) continue;
    AppendWeights(spec, "g" + std::to_string(link) + "_", Quantity::kRatio, kTypicalGrowth, &weights);
  }
  return weights;
}

std::vector<EffectParameter> PairWeights(const Robot&, const EffectSpec&) {
  std::vector<EffectParameter> weights;
  for (const char* name : {"cos_sum", "sin_sum", "cos_difference", "sin_difference"}) {
    weights.push_back({name, Quantity::kSmallAngle, kTypicalTurn});
  }
  return weights;
}

void DeviateJoint(const EffectContext& context, ShotTerms* terms) {
  const Knots knots = KnotsOf(*context.robot, *context.spec);
  const double sign = context.joint_sign();
  for (int k = 0; k < knots.count; ++k) {
    const int parameter = context.first_parameter + k;
    if (IsBy(*context.spec, "torque_Nm")) {
      terms->elastic.push_back({context.joint_slot(), parameter, sign, ElasticLaw::kBump, knots.Apart(), knots.At(k)});
    } else {
      terms->slots.push_back({context.joint_slot(), parameter, sign * knots.Value(k, DriverValue(context))});
    }
  }
}

// Encoder side: cos_sum cos(q_a + q_b) + sin_sum sin(q_a + q_b) + the same of q_a - q_b.
void DeviateByPair(const EffectContext& context, ShotTerms* terms) {
  const auto angle = [&](const char* joint) {
    return context.shot->q[context.chain().FindJoint(context.spec->TextSetting(joint, ""))];
  };
  const double a = angle("driver"), b = angle("with"), sign = context.joint_sign();
  int parameter = context.first_parameter;
  for (const double phase : {a + b, a - b}) {
    terms->slots.push_back({context.joint_slot(), parameter++, sign * std::cos(phase)});
    terms->slots.push_back({context.joint_slot(), parameter++, sign * std::sin(phase)});
  }
}

// Calls with each weight's parameter, axis and bump.
template <typename Use>
void ForEachAxis(const EffectContext& context, int axes, const Use& use) {
  const Knots knots = KnotsOf(*context.robot, *context.spec);
  for (int axis = 0; axis < axes; ++axis) {
    for (int k = 0; k < knots.count; ++k) {
      use(context.first_parameter + axis * knots.count + k, axis, knots.Value(k, DriverValue(context)));
    }
  }
}

void MoveStation(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  ForEachAxis(context, 6, [&](int parameter, int axis, double bump) {
    const Vector3<double> along = bump * Vector3<double>::Unit(axis % 3);
    if (axis < 3) {
      terms->station.push_back({parameter, Matrix3<double>::Zero(), along});
    } else {
      terms->station.push_back({parameter, Skew(along), Vector3<double>::Zero()});
    }
  });
}

void MoveMarker(const EffectContext& context, ShotTerms* terms) {
  for (size_t m = 0; m < context.markers->size(); ++m) {
    if ((*context.markers)[m] != context.spec->target) continue;
    ForEachAxis(context, 3, [&](int parameter, int axis, double bump) {
      terms->markers.push_back({static_cast<int>(m), parameter, bump * Vector3<double>::Unit(axis)});
    });
  }
}

void GrowLinks(const EffectContext& context, ShotTerms* terms) {
  const Knots knots = KnotsOf(*context.robot, *context.spec);
  int parameter = context.first_parameter;
  for (const std::vector<int>& lengths : LengthsByLink(context.chain())) {
    if (lengths.empty()) continue;
    for (int k = 0; k < knots.count; ++k, ++parameter) {
      const double bump = knots.Value(k, DriverValue(context));
      for (const int e : lengths) {
        terms->slots.push_back({e, parameter, bump * context.chain().transforms[e].nominal});
      }
    }
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
  effect.settings = {{"by", Kind::kChoice, "", drivers}, driver, {"from", Kind::kNumber, "", {}}, to, knots};
  effect.missing = Missing;
  effect.is_learnt = true;
  effect.note = kDescribes;
  effect.separate_by = kSeparateByKnowing;
  effect.sizes = "as a periodic joint error, and as what moves a station or a marker";
  return effect;
}

}  // namespace

const EffectDefinition& LearntDeviation() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_deviation",
                            "learnt deviation of a joint",
                            "smooth function of its driver",
                            EffectTarget::kJoint,
                            JointWeights,
                            DeviateJoint};
    effect.on_prismatic = true;
    return Learnt(effect, {"q", "torque_Nm", "time_s", "temperature_K"});
  }();
  return definition;
}

const EffectDefinition& LearntPairDeviation() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_pair_deviation",
                            "learnt deviation of a joint by two",
                            "waves of two angles together",
                            EffectTarget::kJoint,
                            PairWeights,
                            DeviateByPair};
    effect.settings = {{"driver", SettingDefinition::Kind::kJoint, "", {}},
                       {"with", SettingDefinition::Kind::kJoint, "", {}}};
    effect.is_learnt = true;
    effect.note = kDescribes;
    effect.separate_by = kSeparateByKnowing;
    effect.sizes = "as a periodic joint error";
    return effect;
  }();
  return definition;
}

const EffectDefinition& LearntGrowth() {
  static const EffectDefinition definition =
      Learnt({"learnt_growth", "learnt growth of the links", "smooth function of its driver", EffectTarget::kRobot,
              GrowthWeights, GrowLinks},
             {"time_s", "temperature_K"});
  return definition;
}

const EffectDefinition& LearntStationMotion() {
  static const EffectDefinition definition =
      Learnt({"learnt_station_motion", "learnt motion of a station", "smooth function of its driver",
              EffectTarget::kStation, StationWeights, MoveStation},
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
