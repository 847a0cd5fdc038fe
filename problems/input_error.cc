#include "problems/input_error.h"

#include <algorithm>
#include <cctype>

#include "problems/parameter_set.h"
#include "problems/text.h"
#include "problems/unit_words.h"

namespace sagitta {
namespace {

std::string Compose(const InputError::Where& where, const std::string& what, const std::string& hint) {
  std::string message;
  if (!where.file.empty()) {
    message += where.file + ":";
    if (where.line > 0) message += std::to_string(where.line) + ":";
    message += " ";
  }
  if (!where.key.empty()) message += where.key + ": ";
  message += what;
  if (!hint.empty()) message += " (" + hint + ")";
  return message;
}

template <typename Predicate>
std::string Filter(const std::string& text, Predicate keep) {
  std::string kept;
  std::copy_if(text.begin(), text.end(), std::back_inserter(kept), keep);
  return kept;
}

// Without zeros in front: q01 is q1.
std::string Digits(const std::string& text) {
  const std::string digits = Filter(text, [](unsigned char c) { return std::isdigit(c) != 0; });
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
}

std::string LettersAndDigits(const std::string& text) {
  return Filter(text, [](unsigned char c) { return std::isalnum(c) != 0; });
}

// The name without its unit: x_cm -> x, x -> x.
std::string Stem(const std::string& name) {
  const size_t bar = name.rfind('_');
  if (bar == std::string::npos || bar == 0) return name;
  return IsUnitWord(name.substr(bar + 1)) ? name.substr(0, bar) : name;
}

// Levenshtein distance in which two swapped neighbours count once.
int Distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) d[i][0] = static_cast<int>(i);
  for (size_t k = 0; k <= b.size(); ++k) d[0][k] = static_cast<int>(k);
  for (size_t i = 1; i <= a.size(); ++i) {
    for (size_t k = 1; k <= b.size(); ++k) {
      d[i][k] = std::min({d[i - 1][k] + 1, d[i][k - 1] + 1, d[i - 1][k - 1] + (a[i - 1] != b[k - 1])});
      const bool swapped = i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1];
      if (swapped) d[i][k] = std::min(d[i][k], d[i - 2][k - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

// Short names have near neighbours that are simply other names.
int LargestSlip(size_t length) {
  if (length <= 3) return 0;
  if (length <= 5) return 1;
  return length <= 9 ? 2 : 3;
}

std::string BeforeLastBar(const std::string& name) { return name.substr(0, name.rfind('_')); }

}  // namespace

InputError::InputError(Where where, const std::string& what, const std::string& hint)
    : std::runtime_error(Compose(where, what, hint)), where_(std::move(where)), hint_(hint) {}

int NameDistance(const std::string& given_name, const std::string& given_candidate) {
  const std::string name = LowerCaseOf(given_name);
  const std::string candidate = LowerCaseOf(given_candidate);
  if (name == candidate) return 0;
  const std::string letters = LettersAndDigits(name);
  if (!letters.empty() && letters == LettersAndDigits(candidate)) return 0;
  // x1 and x2 are two names, not one and its slip.
  if (Digits(name) != Digits(candidate)) return -1;
  if (Stem(candidate) != candidate && Stem(name) == Stem(candidate)) return 1;
  const size_t length = std::max(name.size(), candidate.size());
  // Spares the table where the lengths alone decide.
  if (length - std::min(name.size(), candidate.size()) > 3 || length > 60) return -1;
  const int distance = Distance(name, candidate);
  return distance <= LargestSlip(length) ? 1 + distance : -1;
}

bool IsSlipOfColumn(const std::string& name, const std::string& listed) {
  const int distance = NameDistance(name, listed);
  if (distance < 0 || distance <= 1) return distance >= 0;
  if (distance > 2 && std::tolower(name[0]) != std::tolower(listed[0])) return false;
  const bool has_unit = listed.find('_') != std::string::npos;
  return !has_unit || NameDistance(BeforeLastBar(name), BeforeLastBar(listed)) >= 0;
}

bool IsAnotherLetter(const std::string& name, const std::string& other) {
  if (name.size() != other.size()) return false;
  for (size_t i = 0; i < name.size(); ++i) {
    const bool is_word = (i == 0 || name[i - 1] == '_') && (i + 1 == name.size() || name[i + 1] == '_');
    if (name[i] != other[i] && !is_word) return false;
  }
  return name != other;
}

std::string NearestName(const std::string& name, const std::vector<std::string>& candidates) {
  std::string nearest;
  int smallest = -1;
  for (const std::string& candidate : candidates) {
    const int distance = NameDistance(name, candidate);
    if (distance < 0 || (smallest >= 0 && distance >= smallest)) continue;
    smallest = distance;
    nearest = candidate;
  }
  return nearest;
}

std::string SpellingHint(const std::string& name, const std::vector<std::string>& candidates) {
  for (const std::string& candidate : candidates) {
    if (!name.empty() && NameWithinKind(candidate) == name) return "did you mean '" + candidate + "'?";
  }
  const std::string nearest = NearestName(name, candidates);
  if (!nearest.empty()) return "did you mean '" + nearest + "'?";
  if (candidates.empty()) return "";
  constexpr size_t kShown = 20;
  const auto shown = candidates.begin() + static_cast<long>(std::min(kShown, candidates.size()));
  std::string hint = "known: " + Joined({candidates.begin(), shown});
  if (candidates.size() > kShown) hint += ", ... " + std::to_string(candidates.size()) + " in all";
  return hint;
}

}  // namespace sagitta
