#include "estimator/diagnosis/verdict.h"

namespace sagitta {

std::string WordOf(DiagnosisVerdict verdict) {
  switch (verdict) {
    case DiagnosisVerdict::kConsistent:
      return "consistent";
    case DiagnosisVerdict::kNoise:
      return "noise";
    case DiagnosisVerdict::kExplained:
      return "explained";
    case DiagnosisVerdict::kPartly:
      return "partly";
    case DiagnosisVerdict::kUnknown:
      return "unknown";
  }
  return "";
}

}  // namespace sagitta
