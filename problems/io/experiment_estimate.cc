// Noise, priors, what is estimated and what is held out in an experiment file.
#include <cmath>

#include "problems/io/experiment_parts.h"

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

int ReadCountIn(const Range& range, const YamlValue& value) {
  const unsigned long long count = value.Count();
  CheckIn(range, static_cast<double>(count), value);
  return static_cast<int>(count);
}

// 0 where nothing is stated.
double DeviationOrZero(const std::optional<double>& si, const YamlValue& value) {
  if (si) CheckIn(allowed::kSigmaOrZero, *si, value);
  return si.value_or(0.0);
}

void ReadInstrument(const YamlValue& value, NoiseSpec* noise) {
  YamlMap map(value);
  noise->from = NoiseSpec::From::kInstrument;
  noise->range = DeviationOrZero(map.Find("range", Dimension::kSmallLength), value);
  noise->angle = DeviationOrZero(map.Find("angle", Dimension::kSmallLength), value);
  const auto per_metre = [&](const std::string& key) {
    const auto entry = map.Find(key);
    return entry ? DeviationOrZero(entry->NumberIn(UnitNamed("um")), *entry) : 0.0;
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
  CheckIn(allowed::kSigma, si, sigma->value);
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
  if (const auto lambda = map->Find("lambda")) noise->lambda = ReadIn(allowed::kFactor, *lambda);
  noise->sigma0 = ReadSigma(map, "sigma0").value_or(noise->sigma0);
  if (const auto group = map->Find("group")) ReadChoice(*group, &noise->group);
  if (const auto iterations = map->Find("iterations")) {
    noise->iterations = ReadCountIn(allowed::kNoiseIterations, *iterations);
  }
}

// One joint's or everybody's standard deviation, 0 or more.
double ReadDeviation(const YamlValue& value, const Unit& unit, const Range& range) {
  const double deviation = value.NumberIn(unit);
  CheckIn(range, deviation, value);
  return deviation;
}

void ReadRepeatabilityValue(const YamlMap::Quantity& quantity, const Range& range, RepeatabilitySpec::OfKind* kind) {
  const YamlValue& value = quantity.value;
  if (!value.IsMap()) {
    if (kind->common || kind->estimate) value.Fail("this is given twice, in two units");
    kind->estimate = value.Is("estimate");
    if (!kind->estimate) kind->common = ReadDeviation(value, quantity.unit, range);
    return;
  }
  for (const auto& [joint, entry] : value.Entries()) {
    if (kind->per_joint.count(joint) > 0) entry.Fail("joint '" + joint + "' is given twice");
    kind->per_joint[joint] = ReadDeviation(entry, quantity.unit, range);
  }
}

}  // namespace

double ReadIn(const Range& range, const YamlValue& value) {
  const double number = value.Number();
  CheckIn(range, number, value);
  return number;
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
  const bool from_rows = noise.from == NoiseSpec::From::kRepeats || noise.from == NoiseSpec::From::kResiduals;
  if (noise.sigma && from_rows) value.Fail("the noise has two sources", "keep one of: sigma_mm, from");
  if (!from && !instrument && !noise.sigma) value.Fail("the noise is not stated", "one of: sigma_mm, from, instrument");
  return noise;
}

RepeatabilitySpec ReadRepeatability(YamlMap* file) {
  RepeatabilitySpec repeatability;
  const auto read = [&](const char* unit, const Range& range, RepeatabilitySpec::OfKind* kind) {
    const auto value = file->Find(std::string("repeatability_") + unit);
    if (value) ReadRepeatabilityValue({*value, UnitNamed(unit)}, range, kind);
  };
  for (const char* unit : RepeatabilitySpec::kAngleUnits) {
    read(unit, allowed::kAngleSigmaOrZero, &repeatability.angle);
  }
  for (const char* unit : RepeatabilitySpec::kLengthUnits) read(unit, allowed::kSigmaOrZero, &repeatability.length);
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
    CheckIn(allowed::kPriorSigma, prior.sigma, sigma);
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
    validation.needs_column = true;
    if (!values && validation.column == "set") return validation;
    if (!values) value.Fail("which values are validation?", "values: [...]");
    validation.kind = ValidationSpec::Kind::kColumn;
    validation.values = values->Texts();
    if (validation.values.empty()) values->Fail("the list is empty");
    return validation;
  }
  if (values) values->Fail("values belong to a column");
  validation.kind = ValidationSpec::Kind::kFraction;
  validation.fraction = ReadIn(allowed::kFraction, *fraction);
  if (seed) validation.seed = seed->Count();
  if (by) validation.by_time = by->OneOf({"config", "time"}) == "time";
  return validation;
}

BootstrapSpec ReadBootstrap(const YamlValue& value) {
  YamlMap map(value);
  BootstrapSpec bootstrap;
  if (const auto kind = map.Find("kind")) ReadChoice(*kind, &bootstrap.kind);
  if (const auto replicates = map.Find("replicates")) {
    bootstrap.replicates = ReadCountIn(allowed::kReplicates, *replicates);
  }
  if (const auto seed = map.Find("seed")) bootstrap.seed = seed->Count();
  map.Finish();
  return bootstrap;
}

}  // namespace sagitta
