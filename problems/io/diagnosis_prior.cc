#include "problems/io/diagnosis_prior.h"

#include <cmath>

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
    if (*mass <= 0.0 || *mass >= 1.0) entry->Fail("a number between 0 and 1 is expected");
  };
  read("nothing", &prior.nothing);
  read("catalogue", &prior.catalogue);
  read("unnamed", &prior.unnamed);
  read("further", &prior.further);
  map.Finish();
  constexpr double kAsWritten = 1e-3;  // decimals that people write
  if (std::abs(prior.nothing + prior.catalogue + prior.unnamed - 1.0) > kAsWritten) {
    value.Fail("nothing, catalogue and unnamed do not sum to 1", "nothing: 0.5, catalogue: 0.38, unnamed: 0.12");
  }
  return prior;
}

PriorMasses ReadDiagnosisPrior(const std::string& experiment_file) {
  if (experiment_file.empty()) return {};
  YamlMap map(ParseYaml(ReadTextFile(experiment_file), experiment_file));
  const auto prior = map.Find("prior");
  return prior ? ReadPriorMasses(*prior) : PriorMasses();
}

}  // namespace sagitta
