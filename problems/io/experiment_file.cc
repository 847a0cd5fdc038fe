#include "problems/io/experiment_file.h"

#include <filesystem>

#include "problems/io/diagnosis_prior.h"
#include "problems/io/experiment_parts.h"
#include "problems/io/files.h"

namespace sagitta {
namespace {

// Paths in a file are relative to the file.
std::string PathNextTo(const std::string& file, const YamlValue& value) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  return (folder / value.Text()).lexically_normal().string();
}

std::vector<std::string> ReadMeasurementPaths(const std::string& file, const YamlValue& value) {
  std::vector<std::string> paths;
  if (!value.IsList()) return {PathNextTo(file, value)};
  for (const YamlValue& item : value.Items()) paths.push_back(PathNextTo(file, item));
  if (paths.empty()) value.Fail("the list is empty", "measurements: [measurements.csv]");
  return paths;
}

void ReadScene(YamlMap* map, Experiment* experiment) {
  experiment->load_point = map->FindTriple("load_point", Dimension::kLength);
  if (const auto loads = map->Find("loads")) experiment->loads = ReadLoads(*loads);
  if (const auto tool = map->Find("tool")) ReadTool(*tool, experiment);
  if (const auto gravity = map->Find("gravity")) ReadGravity(*gravity, experiment);
  if (const auto markers = map->Find("markers")) experiment->markers = ReadMarkers(*markers);
  if (const auto stations = map->Find("stations")) experiment->stations = ReadStations(*stations);
}

void ReadMethod(YamlMap* map, Experiment* experiment) {
  const auto choice = [map](const std::string& key, auto* target) {
    if (const auto value = map->Find(key)) ReadChoice(*value, target);
  };
  if (const auto noise = map->Find("noise")) experiment->noise = ReadNoise(*noise);
  experiment->repeatability = ReadRepeatability(map);
  choice("weights", &experiment->method.weights);
  choice("covariance", &experiment->method.covariance);
  if (const auto bootstrap = map->Find("bootstrap")) experiment->method.bootstrap = ReadBootstrap(*bootstrap);
  if (const auto torques = map->Find("torques")) {
    experiment->torques_measured = torques->OneOf({"model", "measured"}) == "measured";
  }
  choice("loss", &experiment->method.loss);
  if (const auto estimate = map->Find("estimate")) experiment->estimate = ReadEstimate(*estimate);
  if (const auto priors = map->Find("priors")) experiment->priors = ReadPriors(*priors);
  if (const auto validation = map->Find("validation")) experiment->validation = ReadValidation(*validation);
  if (const auto prior = map->Find("prior")) ReadPriorMasses(*prior);  // checked; the diagnosis reads it
  if (const auto significance = map->Find("significance"))
    experiment->significance = ReadIn(allowed::kLevel, *significance);
}

}  // namespace

Experiment ReadExperimentFile(const std::string& path) { return ReadExperimentText(ReadTextFile(path), path); }

Experiment ReadExperimentText(const std::string& text, const std::string& path) {
  const YamlValue root = ParseYaml(text, path);
  YamlMap map(root);
  map.ExpectSchema("sagitta/experiment/1");
  Experiment experiment;
  experiment.file = path;
  experiment.sha256 = Sha256(text);
  ReadScene(&map, &experiment);
  ReadMethod(&map, &experiment);
  // Last, so that a misspelt key is named and not the missing one.
  experiment.robot_file = PathNextTo(path, map.Get("robot"));
  experiment.measurement_files = ReadMeasurementPaths(path, map.Get("measurements"));
  map.Finish();
  ListLines(root, &experiment.lines);
  return experiment;
}

Experiment ReadExperimentSettings(const std::string& text, const std::string& file_in_messages) {
  const YamlValue root = ParseYaml(text, file_in_messages);
  YamlMap map(root);
  Experiment experiment;
  ReadScene(&map, &experiment);
  ReadMethod(&map, &experiment);
  map.Finish();
  ListLines(root, &experiment.lines);
  return experiment;
}

}  // namespace sagitta
