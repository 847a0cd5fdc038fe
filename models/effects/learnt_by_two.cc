// Deviations of a joint that have no name and follow two joints together: waves of the sum and of the difference of
// their angles, or a smooth surface over both, products of bumps (bump.h). As learnt_deviation.cc.
#include <algorithm>
#include <cmath>

#include "models/effects/bump.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"

namespace sagitta {
namespace {

using Kind = SettingDefinition::Kind;

double ValueOf(const EffectContext& context, const char* joint) {
  return context.shot->q[context.chain().FindJoint(context.spec->TextSetting(joint, ""))];
}

std::vector<EffectParameter> PairWeights(const Robot& robot, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (const char* name : {"cos_sum", "sin_sum", "cos_difference", "sin_difference"}) {
    weights.push_back(WeightOfJoint(robot, spec, name));
  }
  return weights;
}

// Encoder side: cos_sum cos(q_a + q_b) + sin_sum sin(q_a + q_b) + the same of q_a - q_b.
void DeviateByPair(const EffectContext& context, ShotTerms* terms) {
  const double a = ValueOf(context, "driver"), b = ValueOf(context, "with"), sign = context.joint_sign();
  int parameter = context.first_parameter;
  for (const double phase : {a + b, a - b}) {
    terms->slots.push_back({context.joint_slot(), parameter++, sign * std::cos(phase)});
    terms->slots.push_back({context.joint_slot(), parameter++, sign * std::sin(phase)});
  }
}

std::vector<EffectParameter> ProductWeights(const Robot& robot, const EffectSpec& spec) {
  return {WeightOfJoint(robot, spec, "u"), WeightOfJoint(robot, spec, "v"), WeightOfJoint(robot, spec, "uv")};
}

int KnotCount(const EffectSpec& spec) { return spec.IntegerSetting("knots", 2); }

// w<i>_<k>: of the i-th knot of the driver and the k-th of the other.
std::vector<EffectParameter> SurfaceWeights(const Robot& robot, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (int i = 1; i <= KnotCount(spec); ++i) {
    for (int k = 1; k <= KnotCount(spec); ++k) {
      weights.push_back(WeightOfJoint(robot, spec, "w" + std::to_string(i) + "_" + std::to_string(k)));
    }
  }
  return weights;
}

// In SI: what files state in deg or mm.
Knots KnotsOf(const EffectContext& context, const char* joint, const char* from, const char* to) {
  const EffectSpec& spec = *context.spec;
  const double unit = UnitOfJoint(*context.robot, spec.TextSetting(joint, ""));
  return {unit * spec.NumberSetting(from, 0.0), unit * spec.NumberSetting(to, 1.0), KnotCount(spec)};
}

// Encoder side: u w_u + v w_v + u v w_uv, u and v from -1 to 1 over the joints' ranges, and no more beyond.
void DeviateByProduct(const EffectContext& context, ShotTerms* terms) {
  const auto over_range = [&](const char* joint, const char* from, const char* to) {
    const Knots ends = KnotsOf(context, joint, from, to);
    const double at = std::clamp(ValueOf(context, joint), ends.low, ends.high);
    return (2.0 * at - ends.low - ends.high) / (ends.high - ends.low);
  };
  const double u = over_range("driver", "from", "to"), v = over_range("with", "from_with", "to_with");
  int parameter = context.first_parameter;
  for (const double function : {u, v, u * v}) {
    terms->slots.push_back({context.joint_slot(), parameter++, context.joint_sign() * function});
  }
}

void DeviateBySurface(const EffectContext& context, ShotTerms* terms) {
  const Knots one = KnotsOf(context, "driver", "from", "to");
  const Knots other = KnotsOf(context, "with", "from_with", "to_with");
  const double a = ValueOf(context, "driver"), b = ValueOf(context, "with"), sign = context.joint_sign();
  int parameter = context.first_parameter;
  for (int i = 0; i < one.count; ++i) {
    for (int k = 0; k < other.count; ++k) {
      terms->slots.push_back({context.joint_slot(), parameter++, sign * one.Value(i, a) * other.Value(k, b)});
    }
  }
}

// Two joints and the range of each.
EffectDefinition OverRanges(EffectDefinition effect) {
  SettingDefinition to{"to", Kind::kNumber, "", {}}, to_with{"to_with", Kind::kNumber, "", {}};
  to.greater_than = "from";
  to_with.greater_than = "from_with";
  effect.settings = {{"driver", Kind::kJoint, "", {}},     {"with", Kind::kJoint, "", {}},
                     {"from", Kind::kNumber, "", {}},      to,
                     {"from_with", Kind::kNumber, "", {}}, to_with};
  effect.on_slide = OnSlide::kDiagnosed;
  return Empirical(std::move(effect));
}

}  // namespace

const EffectDefinition& LearntPairDeviation() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_pair_deviation",
                            "learnt deviation of a joint by two",
                            "waves of two angles together",
                            EffectTarget::kJoint,
                            PairWeights,
                            DeviateByPair};
    effect.settings = {{"driver", Kind::kJoint, "", {}}, {"with", Kind::kJoint, "", {}}};
    effect.on_slide = OnSlide::kDiagnosed;
    return Empirical(std::move(effect));
  }();
  return definition;
}

const EffectDefinition& LearntProductDeviation() {
  static const EffectDefinition definition =
      OverRanges({"learnt_product_deviation", "learnt deviation of a joint with two", "bilinear function of two joints",
                  EffectTarget::kJoint, ProductWeights, DeviateByProduct});
  return definition;
}

const EffectDefinition& LearntSurfaceDeviation() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect =
        OverRanges({"learnt_surface_deviation", "learnt deviation of a joint over two",
                    "smooth function of two joints together", EffectTarget::kJoint, SurfaceWeights, DeviateBySurface});
    SettingDefinition knots{"knots", Kind::kInteger, "", {}};
    knots.least = 2;
    knots.most = 30;  // of either joint: 900 weights
    effect.settings.push_back(knots);
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
