#include "estimator/report/intervals_words.h"

namespace sagitta {

std::string BootstrapInWords(const IntervalReport& report, int configurations) {
  const std::string how =
      std::to_string(report.replicates) + " refits, seed " + std::to_string(report.seed) + ", studentised intervals";
  if (report.kind == BootstrapKind::kConfigurations) {
    return "bootstrap of whole configurations (" + std::to_string(configurations) + "), " + how;
  }
  return "parametric bootstrap at the estimate with the noise as stated or estimated, " + how;
}

std::string BootstrapRefused(int failed, int replicates) {
  return "bootstrap refused: " + std::to_string(failed) + " of " + std::to_string(replicates) +
         " refits did not converge; the model's intervals stand";
}

std::string ProfileInWords(int open_ends) {
  std::string words = "profile likelihood of every parameter";
  if (open_ends > 0)
    words +=
        "; " + std::to_string(open_ends) + (open_ends == 1 ? " end does" : " ends do") + " not close (marked open)";
  return words;
}

std::string ProfileRefused() {
  return "profile refused: the refit at the estimate does not converge; the model's intervals stand";
}

std::string ProfileFindsBetterFit() {
  return "the profile of a parameter finds a better fit than the estimate: the optimum reported is a local one";
}

}  // namespace sagitta
