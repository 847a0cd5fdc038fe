#include "problems/io/diagnosis_prior.h"

#include "problems/io/files.h"

namespace sagitta {

PriorMasses ReadPriorMasses(const YamlValue& value) {
  for (const auto& [key, entry] : value.Entries()) {
    const bool is_parameter = key.find('/') != std::string::npos;
    if (is_parameter) entry.Fail("'prior' has the masses of the diagnosis", "values of parameters stand in 'priors'");
  }
  YamlMap map(value);
  PriorMasses prior;
  const auto read = [&](const char* key, double* mass) {
    const auto entry = map.Find(key);
    if (!entry) return;
    *mass = entry->Number();
    CheckIn(allowed::kProbability, *mass, *entry);
  };
  read("nothing", &prior.nothing);
  read("catalogue", &prior.catalogue);
  read("unnamed", &prior.unnamed);
  read("further", &prior.further);
  map.Finish();
  if (!prior.SumToOne()) value.Fail(kMassesDoNotSum, "nothing: 0.5, catalogue: 0.38, unnamed: 0.12");
  return prior;
}

PriorMasses ReadDiagnosisPrior(const std::string& experiment_file) {
  if (experiment_file.empty()) return {};
  return ReadDiagnosisPriorText(ReadTextFile(experiment_file), experiment_file);
}

PriorMasses ReadDiagnosisPriorText(const std::string& text, const std::string& file_in_messages) {
  YamlMap map(ParseYaml(text, file_in_messages));
  const auto prior = map.Find("prior");
  return prior ? ReadPriorMasses(*prior) : PriorMasses();
}

}  // namespace sagitta
