#include "estimator/diagnosis/verdict.h"

namespace sagitta {

DiagnosisVerdict VerdictOf(bool has_effects, bool has_unexplained, bool noise_is_finding) {
  if (has_effects) return has_unexplained ? DiagnosisVerdict::kPartly : DiagnosisVerdict::kExplained;
  if (has_unexplained) return DiagnosisVerdict::kUnknown;
  return noise_is_finding ? DiagnosisVerdict::kNoise : DiagnosisVerdict::kConsistent;
}

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
