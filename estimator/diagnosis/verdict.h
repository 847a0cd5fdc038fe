// What a diagnosis comes to, in one word.
#pragma once

#include <string>

namespace sagitta {

// Nothing is missing; only the noise is not as stated; what is missing has a name; some of
// it has; none of it has.
enum class DiagnosisVerdict { kConsistent, kNoise, kExplained, kPartly, kUnknown };
// "consistent", ...
std::string WordOf(DiagnosisVerdict verdict);

}  // namespace sagitta
