#include "estimator/results/provenance.h"

#include "problems/io/files.h"

namespace sagitta {

std::string RunId(const Provenance& provenance) {
  std::string text =
      SAGITTA_VERSION "\n" + provenance.command + "\n" + provenance.method + "\n" + provenance.simulation;
  for (const InputFile& input : provenance.inputs) text += "\n" + input.path + "\n" + input.sha256;
  return Sha256(text).substr(0, 16);
}

std::string RunComment(const Provenance& provenance) { return "# run: " + RunId(provenance) + "\n"; }

}  // namespace sagitta
