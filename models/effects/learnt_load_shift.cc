// A load whose centre of gravity goes with the direction of gravity in the flange: contents that slide, cables and
// hoses that hang. As load_com.cc, by functions of that direction (pose_functions.h).
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

// The moment of +F at a point further along the axis and of -F at the load's.
void ShiftLoad(const EffectContext& context, ShotTerms* terms) {
  const EffectSpec& spec = *context.spec;
  if (context.shot->load != spec.target) return;
  const Vector3<double> down(spec.NumberSetting("down_x", 0.0), spec.NumberSetting("down_y", 0.0),
                             spec.NumberSetting("down_z", -1.0));
  const Eigen::VectorXd functions =
      DirectionFunctions(DownInFlange(context.chain(), context.shot->q, down), DegreeOf(spec));
  for (const AppliedWrench& wrench : context.shot->load_wrenches) {
    int parameter = context.first_parameter;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double function : functions) {
        AppliedWrench there = wrench, back = wrench;
        there.moment.setZero();
        back.moment.setZero();
        there.point += Vector3<double>::Unit(axis);
        there.force = function * wrench.force;
        back.force = -there.force;
        terms->wrenches.push_back({parameter++, {there, back}});
      }
    }
  }
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
    return Empirical(std::move(effect));
  }();
  return definition;
}

}  // namespace sagitta
