// What a diagnosis comes to, in one word.
#pragma once

#include <string>

namespace sagitta {

// Nothing is missing; only the noise is not as stated; what is missing has a name; some of
// it has; none of it has.
enum class DiagnosisVerdict { kConsistent, kNoise, kExplained, kPartly, kUnknown };
// noise_is_finding: noise other than stated, or outliers.
DiagnosisVerdict VerdictOf(bool has_effects, bool has_unexplained, bool noise_is_finding);
// "consistent", ...
std::string WordOf(DiagnosisVerdict verdict);

}  // namespace sagitta
