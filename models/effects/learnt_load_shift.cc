// A load whose centre of gravity goes with the direction of gravity in the flange: contents that slide, cables and
// hoses that hang. As load_com.cc, by functions of that direction (pose_functions.h).
#include "models/effects/bump.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"
#include "models/effects/pose_functions.h"

namespace sagitta {
namespace {

int DegreeOf(const EffectSpec& spec) { return spec.IntegerSetting("degree", 1); }

std::vector<EffectParameter> ShiftWeights(const Robot&, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (const char* axis : {"x", "y", "z"}) {
    for (int k = 1; k <= NumDirectionFunctions(DegreeOf(spec)); ++k) {
      weights.push_back({axis + std::to_string(k), Quantity::kLength, kTypicalLoadShift});
    }
  }
  return weights;
}

Vector3<double> DownAt(const EffectContext& context) {
  return DownInFlange(context.chain(), context.shot->q, DownOf(*context.spec));
}

// The moment of +F at a point further along the axis and of -F at the load's.
void ShiftAlong(const EffectContext& context, int axis, const Eigen::VectorXd& functions, int first_parameter,
                ShotTerms* terms) {
  for (const AppliedWrench& wrench : context.shot->load_wrenches) {
    for (long k = 0; k < functions.size(); ++k) {
      AppliedWrench there = wrench, back = wrench;
      there.moment.setZero();
      back.moment.setZero();
      there.point += Vector3<double>::Unit(axis);
      there.force = functions[k] * wrench.force;
      back.force = -there.force;
      terms->wrenches.push_back({first_parameter + static_cast<int>(k), {there, back}});
    }
  }
}

void ShiftLoad(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->load != context.spec->target) return;
  const Eigen::VectorXd functions = DirectionFunctions(DownAt(context), DegreeOf(*context.spec));
  for (int axis = 0; axis < 3; ++axis) {
    ShiftAlong(context, axis, functions, context.first_parameter + axis * static_cast<int>(functions.size()), terms);
  }
}

std::vector<EffectParameter> SlideWeights(const Robot&, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (int k = 1; k <= spec.IntegerSetting("knots", 2); ++k) {
    weights.push_back({"w" + std::to_string(k), Quantity::kLength, kTypicalLoadShift});
  }
  return weights;
}

void SlideLoad(const EffectContext& context, ShotTerms* terms) {
  const EffectSpec& spec = *context.spec;
  if (context.shot->load != spec.target) return;
  const int axis = spec.TextSetting("along", "x")[0] - 'x';
  const Knots knots{spec.NumberSetting("from", -1.0), spec.NumberSetting("to", 1.0), spec.IntegerSetting("knots", 2)};
  const double down = DownAt(context)[axis];
  Eigen::VectorXd functions(knots.count);
  for (int k = 0; k < knots.count; ++k) functions[k] = knots.Value(k, down);
  ShiftAlong(context, axis, functions, context.first_parameter, terms);
}

}  // namespace

const EffectDefinition& LearntLoadShift() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_load_shift",
                            "learnt shift of a load",
                            "function of the direction of gravity",
                            EffectTarget::kLoad,
                            ShiftWeights,
                            ShiftLoad};
    effect.needs = EffectNeeds::kLoads;
    for (const char* name : {"down_x", "down_y", "down_z"}) {
      effect.settings.push_back({name, SettingDefinition::Kind::kNumber, "", {}});
    }
    effect.settings.push_back({"degree", SettingDefinition::Kind::kInteger, "", {}});
    effect.settings.back().most = kHighestDirectionDegree;
    return Empirical(std::move(effect));
  }();
  return definition;
}

const EffectDefinition& LearntLoadSlide() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_load_slide",
                            "learnt slide of a load",
                            "function of gravity along an axis",
                            EffectTarget::kLoad,
                            SlideWeights,
                            SlideLoad};
    effect.needs = EffectNeeds::kLoads;
    effect.settings.push_back({"along", SettingDefinition::Kind::kChoice, "", {"x", "y", "z"}});
    for (const char* name : {"down_x", "down_y", "down_z", "from", "to"}) {
      effect.settings.push_back({name, SettingDefinition::Kind::kNumber, "", {}});
    }
    effect.settings.back().greater_than = "from";
    effect.settings.push_back({"knots", SettingDefinition::Kind::kInteger, "", {}});
    effect.settings.back().least = 2;
    return Empirical(std::move(effect));
  }();
  return definition;
}

}  // namespace sagitta
