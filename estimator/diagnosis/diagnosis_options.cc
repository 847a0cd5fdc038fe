#include "estimator/diagnosis/diagnose.h"
#include "problems/input_error.h"
#include "problems/range.h"

namespace sagitta {

void CheckOptions(const DiagnosisOptions& options) {
  CheckIn(allowed::kLevel, options.significance, "DiagnosisOptions.significance");
  CheckIn(allowed::kProbability, options.prior.nothing, "DiagnosisOptions.prior.nothing");
  CheckIn(allowed::kProbability, options.prior.catalogue, "DiagnosisOptions.prior.catalogue");
  CheckIn(allowed::kProbability, options.prior.unnamed, "DiagnosisOptions.prior.unnamed");
  CheckIn(allowed::kProbability, options.prior.further, "DiagnosisOptions.prior.further");
  if (!options.prior.SumToOne()) throw InputError({"", 0, "DiagnosisOptions.prior"}, kMassesDoNotSum);
  CheckOptions(options.joint);
  CheckIn(allowed::kThreads, options.num_threads, "DiagnosisOptions.num_threads");
}

}  // namespace sagitta
