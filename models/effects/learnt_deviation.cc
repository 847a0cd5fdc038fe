// Deviations that have no name, as smooth functions of what drives them (bump.h, pose_functions.h): of a joint, of a
// station's readings, of a marker, of the lengths of the links; of readings over the station's field. The diagnosis
// fits them to what no effect of the catalogue explains. They describe what was measured, and say nothing beyond the
// driver's range: there bumps fade to zero, ramps keep their end value, functions of place go on.
#include "models/effects/learnt_deviation.h"

#include <cmath>
#include <limits>

#include "models/effects/bump.h"
#include "models/effects/catalogue.h"
#include "models/effects/pose_functions.h"
#include "models/kinematics.h"

namespace sagitta {
namespace {

// m. What is shorter may be where an identified robot has an axis that its drawing has at zero: a file's weights stand
// for the same links of both. At the typical growth it is 0.35 um.
constexpr double kLength = 7e-3;

}  // namespace

std::vector<std::vector<int>> LengthsByLink(const Chain& chain) {
  std::vector<std::vector<int>> links(1);
  for (int e = 0; e < chain.num_transforms(); ++e) {
    const ElementaryTransform& transform = chain.transforms[e];
    if (transform.has_joint()) links.emplace_back();
    const bool is_length = !transform.is_rotation() && !transform.has_joint() && std::abs(transform.nominal) > kLength;
    if (is_length) links.back().push_back(e);
  }
  return links;
}

bool Slides(const Robot& robot, const std::string& joint) {
  const int index = robot.chain.FindJoint(joint);
  return index >= 0 && robot.chain.joints[index].type == JointType::kPrismatic;
}

double UnitOfJoint(const Robot& robot, const std::string& joint) { return Slides(robot, joint) ? 1e-3 : kDegree; }

EffectParameter WeightOfJoint(const Robot& robot, const EffectSpec& spec, const std::string& name) {
  if (Slides(robot, spec.target)) return {name, Quantity::kShift, kTypicalTravel};
  return {name, Quantity::kSmallAngle, kTypicalTurn};
}

Vector3<double> DownOf(const EffectSpec& spec) {
  return {spec.NumberSetting("down_x", 0.0), spec.NumberSetting("down_y", 0.0), spec.NumberSetting("down_z", -1.0)};
}

bool IsOfRamps(const EffectSpec& spec) { return spec.TextSetting("shape", "bumps") == "ramps"; }

EffectDefinition Empirical(EffectDefinition effect) {
  effect.is_learnt = true;
  effect.note = "It describes what was measured and is no cause; beyond what was measured it says nothing.";
  effect.separate_by = "nothing: it is whatever has no name; a cause that is known replaces it";
  effect.sizes = "as a periodic joint error, and as what moves a station or a marker";
  return effect;
}

namespace {

bool IsBy(const EffectSpec& spec, const char* driver) { return spec.TextSetting("by", "time_s") == driver; }

bool IsPerLoad(const EffectSpec& spec) { return spec.NumberSetting("per_N", 0.0) > 0.0; }

int NumPlaceFunctions(const EffectSpec& spec) {
  return (spec.IntegerSetting("degree", 1) > 1 ? kNumFieldFunctions : 3) + (IsPerLoad(spec) ? 1 : 0);
}

// Number of weights along one axis.
int WeightCount(const EffectSpec& spec) {
  if (IsBy(spec, "place")) return NumPlaceFunctions(spec);
  return IsBy(spec, "gravity") ? NumDirectionFunctions(spec.IntegerSetting("degree", 1))
                               : spec.IntegerSetting("knots", 2);
}

// In SI: what files state in deg or mm, N m or N, s, K.
Knots KnotsOf(const Robot& robot, const EffectSpec& spec) {
  const double unit = IsBy(spec, "q") ? UnitOfJoint(robot, spec.TextSetting("driver", "")) : 1.0;
  return {unit * spec.NumberSetting("from", 0.0), unit * spec.NumberSetting("to", 1.0), WeightCount(spec),
          IsOfRamps(spec)};
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
  for (int k = 1; k <= WeightCount(spec); ++k) weights->push_back({prefix + std::to_string(k), quantity, typical});
}

std::vector<EffectParameter> JointWeights(const Robot& robot, const EffectSpec& spec) {
  const EffectParameter weight = WeightOfJoint(robot, spec, "");
  std::vector<EffectParameter> weights;
  AppendWeights(spec, "w", weight.quantity, weight.typical, &weights);
  return weights;
}

std::vector<EffectParameter> PointWeights(const Robot&, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (const char* axis : {"x", "y", "z"}) AppendWeights(spec, axis, Quantity::kShift, kTypicalMovement, &weights);
  return weights;
}

constexpr int kScale = 6;

// What of a station moves: along x, y, z (0 to 2), about them (3 to 5), or its scale changes.
std::vector<int> StationAxes(const EffectSpec& spec) {
  const std::string moves = spec.TextSetting("moves", "all");
  if (moves == "scale") return {kScale};
  if (moves == "point") return {0, 1, 2};
  if (moves == "turn") return {3, 4, 5};
  if (moves != "all") return {moves[0] - 'x'};
  return {0, 1, 2, 3, 4, 5};
}

// Of a motion along x, y, z (axes 0 to 2) or about them (3 to 5).
void AppendMotion(const EffectSpec& spec, int axis, double typical_turn, std::vector<EffectParameter>* weights) {
  const std::string name(1, "xyz"[axis % 3]);
  if (axis < 3) {
    AppendWeights(spec, name, Quantity::kShift, kTypicalMovement, weights);
  } else {
    AppendWeights(spec, "r" + name, Quantity::kSmallAngle, typical_turn, weights);
  }
}

std::vector<EffectParameter> StationWeights(const Robot&, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (const int axis : StationAxes(spec)) {
    if (axis == kScale) {
      AppendWeights(spec, "s", Quantity::kRatio, kTypicalScale, &weights);
    } else {
      AppendMotion(spec, axis, kTypicalStationTurn, &weights);
    }
  }
  return weights;
}

// What of the tool moves: along x, y, z of the flange (0 to 2), about them (3 to 5).
std::vector<int> ToolAxes(const EffectSpec& spec) {
  const std::string moves = spec.TextSetting("moves", "all");
  if (moves == "all") return {0, 1, 2, 3, 4, 5};
  return {moves[0] == 'r' ? 3 + (moves[1] - 'x') : moves[0] - 'x'};
}

std::vector<EffectParameter> ToolWeights(const Robot&, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (const int axis : ToolAxes(spec)) AppendMotion(spec, axis, kTypicalPlateTurn, &weights);
  return weights;
}

std::vector<EffectParameter> FieldWeights(const Robot&, const EffectSpec&) {
  std::vector<EffectParameter> weights;
  for (const char* axis : {"x", "y", "z"}) {
    for (int k = 1; k <= kNumFieldFunctions; ++k) {
      weights.push_back({axis + std::to_string(k), Quantity::kShift, kTypicalMovement});
    }
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

void DeviateJoint(const EffectContext& context, ShotTerms* terms) {
  const Knots knots = KnotsOf(*context.robot, *context.spec);
  const int slot = context.joint_slot();
  const double sign = context.joint_sign(), value = DriverValue(context);
  const bool by_torque = IsBy(*context.spec, "torque_Nm");
  for (int k = 0; k < knots.count; ++k) {
    const int parameter = context.first_parameter + k;
    if (by_torque) {
      terms->elastic.push_back({slot, parameter, sign, ElasticLaw::kBump, knots.Apart(), knots.At(k)});
    } else {
      terms->slots.push_back({slot, parameter, sign * knots.Value(k, value)});
    }
  }
}

// Of the nominal flange from a middle, in units of a spread; beyond what was reached as at the end of that.
Vector3<double> PlaceOf(const EffectContext& context) {
  const EffectSpec& spec = *context.spec;
  const Vector3<double> middle(spec.NumberSetting("x_mm", 0.0), spec.NumberSetting("y_mm", 0.0),
                               spec.NumberSetting("z_mm", 0.0));
  const Vector3<double> off =
      (1e3 * FlangePlace(context.chain(), context.shot->q) - middle) / spec.NumberSetting("spread_mm", 1e3);
  return WithinReach(off, spec.NumberSetting("reach", std::numeric_limits<double>::infinity()));
}

// Linear or quadratic functions of place; of what the load does one and these, times it.
Eigen::VectorXd PlaceFunctions(const EffectContext& context) {
  const EffectSpec& spec = *context.spec;
  const Eigen::VectorXd field = FieldFunctions(PlaceOf(context));
  if (!IsPerLoad(spec)) return field.head(NumPlaceFunctions(spec));
  Eigen::VectorXd functions(NumPlaceFunctions(spec));
  functions << 1.0, field.head(functions.size() - 1);
  return SizeOfForces(context.shot->load_wrenches) / spec.NumberSetting("per_N", 1.0) * functions;
}

// Of the shot: bumps over its driver, or functions of where down is in the flange, where that is asked times the load.
Eigen::VectorXd FunctionsOf(const EffectContext& context) {
  const EffectSpec& spec = *context.spec;
  if (IsBy(spec, "place")) return PlaceFunctions(context);
  if (IsBy(spec, "gravity")) {
    const double unit = spec.NumberSetting("per_N", 0.0);
    return (unit > 0.0 ? SizeOfForces(context.shot->load_wrenches) / unit : 1.0) *
           DirectionFunctions(DownInFlange(context.chain(), context.shot->q, DownOf(spec)),
                              spec.IntegerSetting("degree", 1));
  }
  const Knots knots = KnotsOf(*context.robot, spec);
  const double value = DriverValue(context);
  Eigen::VectorXd functions(knots.count);
  for (int k = 0; k < knots.count; ++k) functions[k] = knots.Value(k, value);
  return functions;
}

// Calls with each weight's parameter, axis and function.
template <typename Use>
void ForEachAxis(const EffectContext& context, const std::vector<int>& axes, const Eigen::VectorXd& functions,
                 const Use& use) {
  int parameter = context.first_parameter;
  for (const int axis : axes) {
    for (const double function : functions) use(parameter++, axis, function);
  }
}

void MoveStation(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  const EffectSpec& spec = *context.spec;
  const Vector3<double> centre =
      1e-3 * Vector3<double>(spec.NumberSetting("about_x_mm", 0.0), spec.NumberSetting("about_y_mm", 0.0),
                             spec.NumberSetting("about_z_mm", 0.0));
  ForEachAxis(context, StationAxes(spec), FunctionsOf(context), [&](int parameter, int axis, double bump) {
    const Vector3<double> along = bump * Vector3<double>::Unit(axis % 3);
    if (axis == kScale) {
      terms->station.push_back({parameter, bump * Matrix3<double>::Identity(), Vector3<double>::Zero()});
    } else if (axis < 3) {
      terms->station.push_back({parameter, Matrix3<double>::Zero(), along});
    } else {
      terms->station.push_back({parameter, Skew(along), -along.cross(centre)});
    }
  });
}

void MoveMarker(const EffectContext& context, ShotTerms* terms) {
  for (size_t m = 0; m < context.markers->size(); ++m) {
    if ((*context.markers)[m] != context.spec->target) continue;
    ForEachAxis(context, {0, 1, 2}, FunctionsOf(context), [&](int parameter, int axis, double function) {
      terms->markers.push_back({static_cast<int>(m), parameter, function * Vector3<double>::Unit(axis)});
    });
  }
}

// Markers move as one body: along the flange's axes, or about them through its origin. A turn w is one of the frame
// after the joint, which would move the flange's origin, at p in that frame, by w x p: the markers move by as much
// less.
void MoveTool(const EffectContext& context, ShotTerms* terms) {
  const Chain& chain = context.chain();
  const std::vector<Pose<double>> frames = NominalFrames(chain, context.shot->q);
  const Pose<double>&joint = frames[chain.FrameAfterJoint(context.joint())], &flange = frames[chain.FlangeFrame()];
  const Matrix3<double> joint_from_flange = joint.rotation.transpose() * flange.rotation;
  const Vector3<double> off = flange.rotation.transpose() * (flange.translation - joint.translation);
  const auto markers = static_cast<int>(context.markers->size());
  ForEachAxis(context, ToolAxes(*context.spec), FunctionsOf(context), [&](int parameter, int axis, double function) {
    const Vector3<double> along = function * Vector3<double>::Unit(axis % 3);
    const Vector3<double> shift = axis < 3 ? along : Vector3<double>(-along.cross(off));
    for (int m = 0; m < markers; ++m) terms->markers.push_back({m, parameter, shift});
    const Vector3<double> turn = joint_from_flange * along;
    for (int k = 0; k < 3 && axis >= 3; ++k) {
      terms->slots.push_back({TiltSlot(chain, context.joint(), static_cast<Axis>(k)), parameter, turn[k]});
    }
  });
}

// By where the nominal flange is in the base frame, from a middle and in units of a spread.
void DistortField(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  const Eigen::VectorXd functions = FieldFunctions(PlaceOf(context));
  ForEachAxis(context, {0, 1, 2}, functions, [&](int parameter, int axis, double function) {
    terms->station.push_back({parameter, Matrix3<double>::Zero(), function * Vector3<double>::Unit(axis)});
  });
}

void GrowLinks(const EffectContext& context, ShotTerms* terms) {
  const Knots knots = KnotsOf(*context.robot, *context.spec);
  const double value = DriverValue(context);
  int parameter = context.first_parameter;
  for (const std::vector<int>& lengths : LengthsByLink(context.chain())) {
    if (lengths.empty()) continue;
    for (int k = 0; k < knots.count; ++k, ++parameter) {
      const double bump = knots.Value(k, value);
      for (const int e : lengths) {
        terms->slots.push_back({e, parameter, bump * context.chain().transforms[e].nominal});
      }
    }
  }
}

// `drivers`: the first is the usual one.
EffectDefinition Learnt(EffectDefinition effect, const std::vector<std::string>& drivers) {
  using Kind = SettingDefinition::Kind;
  const std::string along_a_line = "by=q|torque_Nm|time_s|temperature_K";
  SettingDefinition driver{"driver", Kind::kJoint, "", {}};
  driver.only_with = "by=q";
  SettingDefinition from{"from", Kind::kNumber, "", {}};
  from.only_with = along_a_line;
  SettingDefinition to{"to", Kind::kNumber, "", {}};
  to.greater_than = "from";
  to.only_with = along_a_line;
  SettingDefinition knots{"knots", Kind::kInteger, "", {}};
  knots.only_with = along_a_line;
  SettingDefinition shape{"shape", Kind::kChoice, "bumps", {"bumps", "ramps"}};
  shape.silent = true;
  shape.only_with = "by=time_s";
  effect.settings = {{"by", Kind::kChoice, "", drivers}, driver, from, to, knots, shape};
  effect.missing = Missing;
  return Empirical(std::move(effect));
}

// Which way is down: of the base frame, any length.
void AddGravity(EffectDefinition* effect) {
  using Kind = SettingDefinition::Kind;
  effect->settings[0].choices.push_back("gravity");
  for (const char* name : {"down_x", "down_y", "down_z"}) {
    SettingDefinition down{name, Kind::kNumber, "", {}};
    down.only_with = "by=gravity";
    effect->settings.push_back(down);
  }
  SettingDefinition degree{"degree", Kind::kInteger, "", {}};
  degree.only_with = "by=gravity";
  degree.most = kHighestDirectionDegree;
  effect->settings.push_back(degree);
  SettingDefinition per_load{"per_N", Kind::kNumber, "0", {}};
  per_load.silent = true;
  per_load.above = 0.0;
  per_load.only_with = "by=gravity";
  effect->settings.push_back(per_load);
}

// Where the nominal flange is in the base frame, and how heavy the load.
void AddPlace(EffectDefinition* effect) {
  using Kind = SettingDefinition::Kind;
  effect->settings[0].choices.push_back("place");
  for (const char* name : {"x_mm", "y_mm", "z_mm", "spread_mm"}) {
    effect->settings.push_back({name, Kind::kNumber, "", {}});
    effect->settings.back().only_with = "by=place";
  }
  effect->settings.back().above = 0.0;
  effect->settings.push_back({"reach", Kind::kNumber, "", {}});
  effect->settings.back().above = 0.0;
  effect->settings.back().only_with = "by=place";
  effect->settings.push_back({"degree", Kind::kInteger, "", {}});
  effect->settings.back().most = 2;
  effect->settings.back().only_with = "by=place";
  effect->settings.push_back({"per_N", Kind::kNumber, "0", {}});
  effect->settings.back().silent = true;
  effect->settings.back().above = 0.0;
  effect->settings.back().only_with = "by=place";
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
    effect.on_slide = OnSlide::kDiagnosed;
    return Learnt(effect, {"q", "torque_Nm", "time_s", "temperature_K"});
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
  static const EffectDefinition definition = [] {
    EffectDefinition effect =
        Learnt({"learnt_station_motion", "learnt motion of a station", "smooth function of its driver",
                EffectTarget::kStation, StationWeights, MoveStation},
               {"time_s", "temperature_K"});
    AddPlace(&effect);
    SettingDefinition moves{
        "moves", SettingDefinition::Kind::kChoice, "all", {"all", "point", "turn", "x", "y", "z", "scale"}};
    moves.silent = true;
    effect.settings.push_back(moves);
    for (const char* name : {"about_x_mm", "about_y_mm", "about_z_mm"}) {
      SettingDefinition about{name, SettingDefinition::Kind::kNumber, "0", {}};
      about.silent = true;
      about.only_with = "moves=turn";
      effect.settings.push_back(about);
    }
    return effect;
  }();
  return definition;
}

const EffectDefinition& LearntToolMotion() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect = Learnt({"learnt_tool_motion", "learnt motion of the tool",
                                      "smooth function of its driver", EffectTarget::kJoint, ToolWeights, MoveTool},
                                     {"time_s", "temperature_K"});
    SettingDefinition moves{"moves", SettingDefinition::Kind::kChoice, "all", {"all", "x", "y", "z", "rx", "ry", "rz"}};
    moves.silent = true;
    effect.settings.push_back(moves);
    effect.tilts = true;
    effect.on_slide = OnSlide::kDiagnosed;
    return effect;
  }();
  return definition;
}

const EffectDefinition& LearntStationField() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect =
        Empirical({"learnt_station_field", "learnt distortion of a station's field",
                   "function of place to second order", EffectTarget::kStation, FieldWeights, DistortField});
    for (const char* name : {"x_mm", "y_mm", "z_mm", "spread_mm"}) {
      effect.settings.push_back({name, SettingDefinition::Kind::kNumber, "", {}});
    }
    effect.settings.back().above = 0.0;
    return effect;
  }();
  return definition;
}

const EffectDefinition& LearntMarkerMotion() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect = Learnt({"learnt_marker_motion", "learnt motion of a marker",
                                      "smooth function of its driver", EffectTarget::kMarker, PointWeights, MoveMarker},
                                     {"time_s", "q", "temperature_K"});
    AddGravity(&effect);
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
