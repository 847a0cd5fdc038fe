// Errors of an instrument's readings that have no name: a reading is off by a smooth function of a reading, or the
// range by a wave over itself. As learnt_deviation.cc, by where the instrument sees a point (sight.h): each marker of a
// shot by its own readings.
#include "models/effects/bump.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"

namespace sagitta {
namespace {

using Kind = SettingDefinition::Kind;

Sensed ReadingOf(const std::string& text) {
  if (text.rfind("range", 0) == 0) return Sensed::kRange;
  return text.rfind("azimuth", 0) == 0 ? Sensed::kAzimuth : Sensed::kElevation;
}

Sensed ReadsWrong(const EffectSpec& spec) { return ReadingOf(spec.TextSetting("reads", "range")); }

EffectParameter Weight(const EffectSpec& spec, const std::string& name) {
  if (ReadsWrong(spec) == Sensed::kRange) return {name, Quantity::kShift, kTypicalMovement};
  return {name, Quantity::kSmallAngle, kTypicalStationTurn};
}

std::vector<EffectParameter> BumpWeights(const Robot&, const EffectSpec& spec) {
  std::vector<EffectParameter> weights;
  for (int k = 1; k <= spec.IntegerSetting("knots", 2); ++k) weights.push_back(Weight(spec, "w" + std::to_string(k)));
  return weights;
}

void ReadWithBumps(const EffectContext& context, ShotTerms* terms) {
  const EffectSpec& spec = *context.spec;
  if (context.shot->station != spec.target) return;
  SightTerm term{context.first_parameter, ReadsWrong(spec), SightLaw::kBump, context.shot->instrument};
  term.over = ReadingOf(spec.TextSetting("by", "range_mm"));
  const double unit = term.over == Sensed::kRange ? 1e-3 : kDegree;
  const Knots knots{unit * spec.NumberSetting("from", 0.0), unit * spec.NumberSetting("to", 1.0),
                    spec.IntegerSetting("knots", 2)};
  term.width = knots.Apart();
  for (int k = 0; k < knots.count; ++k) {
    term.centre = knots.At(k);
    terms->sights.push_back(term);
    ++term.parameter;
  }
}

std::vector<EffectParameter> WaveWeights(const Robot&, const EffectSpec& spec) {
  return {Weight(spec, "cos"), Weight(spec, "sin")};
}

void ReadWithWave(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  SightTerm term{context.first_parameter, Sensed::kRange, SightLaw::kCosWave, context.shot->instrument};
  term.width = 1e-3 * context.spec->NumberSetting("period_mm", 1e3);
  terms->sights.push_back(term);
  ++term.parameter;
  term.law = SightLaw::kSinWave;
  terms->sights.push_back(term);
}

}  // namespace

const EffectDefinition& LearntReading() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_reading",
                            "learnt error of a reading",
                            "smooth function of a reading",
                            EffectTarget::kStation,
                            BumpWeights,
                            ReadWithBumps};
    SettingDefinition to{"to", Kind::kNumber, "", {}}, knots{"knots", Kind::kInteger, "", {}};
    to.greater_than = "from";
    knots.least = 2;
    effect.settings = {{"reads", Kind::kChoice, "", {"range", "azimuth", "elevation"}},
                       {"by", Kind::kChoice, "", {"range_mm", "azimuth_deg", "elevation_deg"}},
                       {"from", Kind::kNumber, "", {}},
                       to,
                       knots};
    return Empirical(std::move(effect));
  }();
  return definition;
}

const EffectDefinition& LearntRangeWave() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_range_wave",   "learnt wave of the range",
                            "wave over the range", EffectTarget::kStation,
                            WaveWeights,           ReadWithWave};
    effect.settings = {{"period_mm", Kind::kNumber, "", {}}};
    effect.settings[0].above = 0.0;
    return Empirical(std::move(effect));
  }();
  return definition;
}

}  // namespace sagitta
