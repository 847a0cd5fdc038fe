// A force that no load states: a hose, a hung cable, a balancer of the tool. It pulls at the flange by a linear
// function of where the flange is in the base frame, as a spring to the surroundings does. Its size is stated as the
// mass that weighs as much.
#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"
#include "models/effects/pose_functions.h"

namespace sagitta {
namespace {

int PullFunctions(const EffectSpec& spec) { return spec.IntegerSetting("degree", 1) > 0 ? 4 : 1; }

std::vector<EffectParameter> PullWeights(const Robot&, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (const char* axis : {"x", "y", "z"}) {
    for (int k = 1; k <= PullFunctions(spec); ++k) {
      weights.push_back({axis + std::to_string(k), Quantity::kMass, kTypicalPull});
    }
  }
  return weights;
}

// F = f_1 + u_x f_2 + u_y f_3 + u_z f_4, u = (flange - middle) / spread.
void Pull(const EffectContext& context, ShotTerms* terms) {
  const EffectSpec& spec = *context.spec;
  const Vector3<double> middle(spec.NumberSetting("x_mm", 0.0), spec.NumberSetting("y_mm", 0.0),
                               spec.NumberSetting("z_mm", 0.0));
  const Vector3<double> off =
      (1e3 * FlangePlace(context.chain(), context.shot->q) - middle) / spec.NumberSetting("spread_mm", 1e3);
  const Eigen::Vector4d functions(1.0, off.x(), off.y(), off.z());
  AppliedWrench pull;
  pull.frame = context.chain().FlangeFrame();
  pull.expressed_in = WrenchFrame::kBase;
  int parameter = context.first_parameter;
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < PullFunctions(spec); ++k) {
      pull.force = kStandardGravity * functions[k] * Vector3<double>::Unit(axis);
      terms->wrenches.push_back({parameter++, {pull}});
    }
  }
}

}  // namespace

const EffectDefinition& LearntPull() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "learnt_pull", "learnt pull at the flange", "linear function of place", EffectTarget::kRobot, PullWeights,
        Pull};
    effect.needs = EffectNeeds::kCompliances;
    for (const char* name : {"x_mm", "y_mm", "z_mm", "spread_mm"}) {
      effect.settings.push_back({name, SettingDefinition::Kind::kNumber, "", {}});
    }
    effect.settings.back().above = 0.0;
    effect.settings.push_back({"degree", SettingDefinition::Kind::kInteger, "", {}});
    effect.settings.back().least = 0;
    effect.settings.back().most = 1;
    return Empirical(std::move(effect));
  }();
  return definition;
}

}  // namespace sagitta
