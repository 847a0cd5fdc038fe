// Arm and tool grow about the base origin with temperature - its mean; what stands on the floor or the foot does not.
// With a lag the arm's temperature follows the thermometer's late (first_order_lag.h), one arm for the whole campaign.
#include "models/effects/catalogue.h"
#include "models/effects/first_order_lag.h"

namespace sagitta {
namespace thermal_growth {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {NotNegative({"growth", Quantity::kGrowth, 10e-6})};
}

double Lag(const EffectSpec& spec) { return spec.NumberSetting("lag_s", 0.0); }

// The arm's temperature.
std::vector<double> Remember(const Robot&, const EffectSpec& spec, const std::vector<const ShotConditions*>& campaign) {
  std::vector<double> time, temperature;
  for (const ShotConditions* shot : campaign) {
    time.push_back(shot->time);
    temperature.push_back(shot->temperature);
  }
  return Lag(spec) > 0.0 ? LaggedBehind(time, temperature, Lag(spec)) : temperature;
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  terms->base.push_back({context.first_parameter, context.memory});
}

std::string Missing(const EffectContext& context) {
  return Lag(*context.spec) > 0.0 && !context.shot->has_time ? "time_s" : "";
}

}  // namespace thermal_growth

const EffectDefinition& ThermalGrowth() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"thermal_growth",     "thermal growth of the arm", "linear expansion",
                            EffectTarget::kRobot, thermal_growth::Parameters,  thermal_growth::Apply};
    effect.driven_by = EffectDriver::kTemperature;
    effect.separate_by = "the same poses at other temperatures, in an order that is not that of time";
    effect.note = "Links that lag behind the thermometer bias the value.";
    effect.sizes = "expansion of steel 11.5 ppm/K, of aluminium 23 ppm/K, of cast iron 10 ppm/K (handbooks)";
    effect.settings = {{"lag_s", SettingDefinition::Kind::kNumber, "0", {"300", "600", "1200", "2400", "4800"}}};
    effect.settings[0].silent = true;
    effect.settings[0].above = 0.0;
    effect.missing = thermal_growth::Missing;
    effect.remember = thermal_growth::Remember;
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
