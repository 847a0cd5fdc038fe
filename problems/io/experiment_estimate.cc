// Noise, priors, what is estimated and what is held out in an experiment file.
#include <cmath>

#include "problems/io/experiment_parts.h"
#include "problems/io/files.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

// The word, or a list; `words` as the method understands them.
Selection ReadSelection(const YamlValue& value, const std::vector<std::string>& words) {
  if (value.IsList()) return {Selection::Kind::kList, value.Texts()};
  const std::string word = value.OneOf(words);
  if (word == "all") return {Selection::Kind::kAll, {}};
  return {word == "none" ? Selection::Kind::kNone : Selection::Kind::kDefault, {}};
}

void CheckNames(const YamlValue& value, const std::vector<std::string>& names) {
  if (!value.IsList()) return;
  for (const YamlValue& item : value.Items()) item.OneOf(names);
}

double ReadUnitInterval(const YamlValue& value) {
  const double number = value.Number();
  if (number <= 0.0 || number >= 1.0) value.Fail("a number between 0 and 1 is expected");
  return number;
}

double NotNegative(const std::optional<double>& number, const YamlValue& map) {
  if (number && *number < 0.0) map.Fail("an instrument's standard deviations are not below 0");
  if (number && *number > 0.0) CheckDeviation(map, *number);
  return number.value_or(0.0);
}

void ReadInstrument(const YamlValue& value, NoiseSpec* noise) {
  YamlMap map(value);
  noise->from = NoiseSpec::From::kInstrument;
  noise->range = NotNegative(map.Find("range", Dimension::kSmallLength), value);
  noise->angle = NotNegative(map.Find("angle", Dimension::kSmallLength), value);
  const auto per_metre = [&](const std::string& key) {
    const auto entry = map.Find(key);
    return entry ? NotNegative(entry->NumberIn(UnitNamed("um")), *entry) : 0.0;
  };
  noise->range_per_m = per_metre("range_um_per_m");
  noise->angle_per_m = per_metre("angle_um_per_m");
  map.Finish();
  if (noise->range + noise->angle + noise->range_per_m + noise->angle_per_m == 0.0) {
    value.Fail("the instrument has no noise at all", "range_um, range_um_per_m, angle_um, angle_um_per_m");
  }
}

std::optional<double> ReadSigma(YamlMap* map, const std::string& stem) {
  const auto sigma = map->FindQuantity(stem, Dimension::kLength);
  if (!sigma) return std::nullopt;
  const double si = sigma->unit.ToSi(sigma->value.PositiveNumber());
  CheckDeviation(sigma->value, si);
  return si;
}

NoiseSpec::From ReadNoiseSource(const YamlValue& value) {
  const std::string from = value.OneOf({"rows", "repeats", "residuals", "variance-components"});
  if (from == "rows") return NoiseSpec::From::kRows;
  if (from == "repeats") return NoiseSpec::From::kRepeats;
  return from == "residuals" ? NoiseSpec::From::kResiduals : NoiseSpec::From::kVarianceComponents;
}

// Settings of {from: residuals}, refused elsewhere as unknown keys.
void ReadResidualSettings(YamlMap* map, NoiseSpec* noise) {
  if (const auto lambda = map->Find("lambda")) noise->lambda = lambda->PositiveNumber();
  noise->sigma0 = ReadSigma(map, "sigma0").value_or(noise->sigma0);
  if (const auto group = map->Find("group")) ReadChoice(*group, &noise->group);
  if (const auto iterations = map->Find("iterations")) {
    const unsigned long long count = iterations->Count();
    if (count == 0 || count > 10000) iterations->Fail("a whole number from 1 to 10000 is expected");
    noise->iterations = static_cast<int>(count);
  }
}

// One joint's or everybody's standard deviation, 0 or more.
double ReadDeviation(const YamlValue& value, const Unit& unit) {
  const double deviation = value.NumberIn(unit);
  if (deviation < 0.0) value.Fail("a standard deviation is not below 0");
  if (deviation > 0.0) CheckDeviation(value, deviation);
  return deviation;
}

void ReadRepeatabilityValue(const YamlMap::Quantity& quantity, RepeatabilitySpec::OfKind* kind) {
  const YamlValue& value = quantity.value;
  if (!value.IsMap()) {
    if (kind->common || kind->estimate) value.Fail("this is given twice, in two units");
    kind->estimate = value.Is("estimate");
    if (!kind->estimate) kind->common = ReadDeviation(value, quantity.unit);
    return;
  }
  for (const auto& [joint, entry] : value.Entries()) {
    if (kind->per_joint.count(joint) > 0) entry.Fail("joint '" + joint + "' is given twice");
    kind->per_joint[joint] = ReadDeviation(entry, quantity.unit);
  }
}

}  // namespace

void CheckDeviation(const YamlValue& value, double si) {
  if (si >= limits::kLeastSigma && si <= limits::kLargestSigma) return;
  value.Fail("this is no standard deviation of a measurement", "1 nm to 10 m, 1 nrad to 10 rad");
}

NoiseSpec ReadNoise(const YamlValue& value) {
  YamlMap map(value);
  NoiseSpec noise;
  noise.sigma = ReadSigma(&map, "sigma");
  const auto from = map.Find("from");
  const auto instrument = map.Find("instrument");
  if (noise.sigma) noise.from = NoiseSpec::From::kSigma;
  if (from) noise.from = ReadNoiseSource(*from);
  if (noise.from == NoiseSpec::From::kResiduals) ReadResidualSettings(&map, &noise);
  if (instrument) ReadInstrument(*instrument, &noise);
  map.Finish();
  if (from && instrument) value.Fail("the noise has two sources", "keep one of: from, instrument");
  if (noise.sigma && instrument) value.Fail("the noise has two sources", "keep one of: sigma_mm, instrument");
  if (!from && !instrument && !noise.sigma) value.Fail("the noise is not stated", "one of: sigma_mm, from, instrument");
  return noise;
}

RepeatabilitySpec ReadRepeatability(YamlMap* file) {
  RepeatabilitySpec repeatability;
  const auto read = [&](const char* unit, RepeatabilitySpec::OfKind* kind) {
    const auto value = file->Find(std::string("repeatability_") + unit);
    if (value) ReadRepeatabilityValue({*value, UnitNamed(unit)}, kind);
  };
  // The first of a kind is the unit to suggest.
  for (const char* unit : {"urad", "mrad", "rad", "deg"}) read(unit, &repeatability.angle);
  for (const char* unit : {"um", "mm", "m"}) read(unit, &repeatability.length);
  if (const auto plain = file->Find("repeatability")) {
    if (!plain->Is("estimate")) plain->Fail("the key has to name its unit", "repeatability_urad or repeatability_um");
    for (auto* kind : {&repeatability.angle, &repeatability.length}) kind->estimate = !kind->common;
  }
  return repeatability;
}

EstimateSpec ReadEstimate(const YamlValue& value) {
  YamlMap map(value);
  EstimateSpec estimate;
  if (const auto base = map.Find("base")) estimate.base = base->Flag();
  if (const auto markers = map.Find("markers")) estimate.markers = markers->Flag();
  if (const auto geometry = map.Find("geometry")) {
    estimate.geometry = ReadSelection(*geometry, {"default", "all", "none"});
  }
  if (const auto compliance = map.Find("compliance")) {
    estimate.compliance = ReadSelection(*compliance, {"all", "none", "default"});
  }
  if (const auto compensator = map.Find("gravity_compensator")) {
    estimate.gravity_compensator = ReadSelection(*compensator, {"all", "none", "default"});
    CheckNames(*compensator, {"L", "a_x", "a_y", "s0", "Kc"});
  }
  if (const auto effects = map.Find("effects")) {
    if (effects->IsList())
      effects->Fail("all or none is expected", "single parameters: estimate: {free: […], fixed: […]}");
    estimate.effects = ReadSelection(*effects, {"all", "none", "default"});
  }
  if (const auto fixed = map.Find("fixed")) estimate.fixed = fixed->Texts();
  if (const auto free = map.Find("free")) estimate.free = free->Texts();
  map.Finish();
  return estimate;
}

std::map<std::string, Prior> ReadPriors(const YamlValue& value) {
  std::map<std::string, Prior> priors;
  for (const auto& [name, entry] : value.Entries()) {
    YamlMap map(entry);
    Prior prior;
    prior.value = map.Get("value").Number();
    const YamlValue sigma = map.Get("sigma");
    prior.sigma = sigma.PositiveNumber();
    if (prior.sigma < limits::kLeastPriorSigma || prior.sigma > limits::kLargestPriorSigma) {
      sigma.Fail("this is no standard deviation of something that is known",
                 "between " + FormatNumber(limits::kLeastPriorSigma) + " and " +
                     FormatNumber(limits::kLargestPriorSigma) + "; without a prior leave the entry out");
    }
    map.Finish();
    priors[name] = prior;
  }
  return priors;
}

ValidationSpec ReadValidation(const YamlValue& value) {
  ValidationSpec validation;
  if (value.Is("none")) {
    validation.kind = ValidationSpec::Kind::kNone;
    return validation;
  }
  if (!value.IsMap()) value.Fail("{column: ...}, {fraction: ...} or none is expected");
  YamlMap map(value);
  const auto column = map.Find("column");
  const auto fraction = map.Find("fraction");
  const auto values = map.Find("values");
  const auto seed = map.Find("seed");
  const auto by = map.Find("by");
  map.Finish();
  if (column.has_value() == fraction.has_value()) value.Fail("the split is not clear", "one of: column, fraction");
  if (column) {
    if (seed || by) value.Fail("seed and by belong to a fraction");
    validation.column = column->Text();
    if (!values && validation.column == "set") return validation;
    if (!values) value.Fail("which values are validation?", "values: [...]");
    validation.kind = ValidationSpec::Kind::kColumn;
    validation.values = values->Texts();
    if (validation.values.empty()) values->Fail("the list is empty");
    return validation;
  }
  if (values) values->Fail("values belong to a column");
  validation.kind = ValidationSpec::Kind::kFraction;
  validation.fraction = ReadUnitInterval(*fraction);
  if (seed) validation.seed = seed->Count();
  if (by) validation.by_time = by->OneOf({"config", "time"}) == "time";
  return validation;
}

BootstrapSpec ReadBootstrap(const YamlValue& value) {
  YamlMap map(value);
  BootstrapSpec bootstrap;
  if (const auto kind = map.Find("kind")) ReadChoice(*kind, &bootstrap.kind);
  if (const auto replicates = map.Find("replicates")) {
    const unsigned long long count = replicates->Count();
    if (count < 99 || count > 1000000) replicates->Fail("a whole number from 99 to 1000000 is expected");
    bootstrap.replicates = static_cast<int>(count);
  }
  if (const auto seed = map.Find("seed")) bootstrap.seed = seed->Count();
  map.Finish();
  return bootstrap;
}

double ReadSignificance(const YamlValue& value) { return ReadUnitInterval(value); }

}  // namespace sagitta
