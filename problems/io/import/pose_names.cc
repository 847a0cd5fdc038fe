#include "problems/io/import/pose_names.h"

#include <algorithm>
#include <cctype>

#include "problems/text.h"

namespace sagitta {
namespace {

// What has more is a remark: its parts are kept as pairs of ends, by the square of their number.
constexpr size_t kMostParts = 32;

// Where separators are, and the end.
std::vector<size_t> EndsOfParts(const std::string& text) {
  std::vector<size_t> ends;
  for (size_t i = 0; i <= text.size(); ++i) {
    if (i == text.size() || SeparatesParts(static_cast<unsigned char>(text[i]))) ends.push_back(i);
  }
  return ends;
}

}  // namespace

bool SeparatesParts(unsigned char c) { return c < 0x80 && std::isalnum(c) == 0; }

std::string Plain(const std::string& name, bool as_written) {
  if (as_written) return name;
  std::string plain;
  for (size_t i = 0; i < name.size(); ++i) {
    const bool goes_on = !plain.empty() && std::isdigit(static_cast<unsigned char>(plain.back())) != 0;
    const bool is_last = i + 1 == name.size() || std::isdigit(static_cast<unsigned char>(name[i + 1])) == 0;
    if (name[i] != '0' || goes_on || is_last) plain += name[i];
  }
  return LowerCaseOf(plain);
}

std::vector<NameInCell> NamesIn(const std::string& cell, PoseNameAt at, bool as_written) {
  const std::string name = Plain(cell, as_written);
  if (at == PoseNameAt::kWhole) return {{name, ""}};
  const std::vector<size_t> ends = EndsOfParts(name);
  if (ends.size() > kMostParts) return {{name, ""}};
  std::vector<NameInCell> parts;
  for (size_t from = 0, first = 0; first < ends.size(); from = ends[first++] + 1) {
    for (size_t last = first; last < ends.size(); ++last) {
      const bool begins = from == 0, ends_it = ends[last] == name.size();
      if ((at == PoseNameAt::kBefore && !begins) || (at == PoseNameAt::kBehind && !ends_it)) continue;
      const std::string before = begins ? "" : name.substr(0, from - 1),
                        behind = ends_it ? "" : name.substr(ends[last] + 1);
      parts.push_back({name.substr(from, ends[last] - from), before + (begins || ends_it ? "" : "_") + behind});
    }
  }
  std::stable_sort(parts.begin(), parts.end(),
                   [](const NameInCell& a, const NameInCell& b) { return a.name.size() > b.name.size(); });
  return parts;
}

std::set<std::string> PiecesOf(const std::string& text) {
  const std::vector<size_t> ends = EndsOfParts(text);
  std::set<std::string> pieces;
  for (size_t from = 0, first = 0; first < ends.size(); from = ends[first++] + 1) {
    for (size_t last = first; last < ends.size(); ++last) pieces.insert(text.substr(from, ends[last] - from));
  }
  return pieces;
}

}  // namespace sagitta
