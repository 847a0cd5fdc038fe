// What an inspection has to say: one finding each, in words, with what to do about it and where it is.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estimator/report/inspection_words.h"

namespace sagitta {

// serious: an estimate from these data would be wrong or void; warning: it would be worse than it could be;
// note: what the data cannot answer as they are.
enum class Severity { kSerious, kWarning, kNote };
const char* SeverityName(Severity severity);

// One thing that is wrong, or worth knowing.
struct Finding {
  Severity severity = Severity::kNote;
  std::string code;  // "sign_flip", "outliers", …; stable, for programs
  std::string words;
  std::string remedy;
  std::vector<std::string> rows;  // "file:line", as many as are concerned
};

// A finding in the words of estimator/report.
inline Finding Found(Severity severity, const char* code, Advice advice, std::vector<std::string> rows = {}) {
  return {severity, code, std::move(advice.words), std::move(advice.remedy), std::move(rows)};
}

}  // namespace sagitta
