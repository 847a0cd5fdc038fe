// Sections of an experiment file, for experiment_file.cc only.
#pragma once

#include <map>
#include <string>

#include "problems/experiment.h"
#include "problems/io/yaml_reader.h"

namespace sagitta {

std::map<std::string, LoadSpec> ReadLoads(const YamlValue& value);
std::map<std::string, MarkerSpec> ReadMarkers(const YamlValue& value);
std::map<std::string, StationSpec> ReadStations(const YamlValue& value);
void ReadTool(const YamlValue& value, Experiment* experiment);
void ReadGravity(const YamlValue& value, Experiment* experiment);

// Sets the choice that the value names; Choice: an enum of problems/choices.h.
template <typename Choice>
void ReadChoice(const YamlValue& value, Choice* choice) {
  *choice = *FindChoice<Choice>(value.OneOf(WordsOf<Choice>()));
}

NoiseSpec ReadNoise(const YamlValue& value);
// Keys repeatability_urad and repeatability_um of the file.
RepeatabilitySpec ReadRepeatability(YamlMap* file);
EstimateSpec ReadEstimate(const YamlValue& value);
std::map<std::string, Prior> ReadPriors(const YamlValue& value);
ValidationSpec ReadValidation(const YamlValue& value);
BootstrapSpec ReadBootstrap(const YamlValue& value);
// A number that the range has.
double ReadIn(const Range& range, const YamlValue& value);

}  // namespace sagitta
