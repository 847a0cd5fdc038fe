#include "estimator/random_effects/explanation.h"

#include <algorithm>
#include <cmath>

namespace sagitta {

double SetPrior::Log(const std::vector<double>& shares) const {
  if (shares.empty()) return std::log(nothing);
  const double m = static_cast<double>(shares.size());
  double log = std::log(1.0 - nothing) + (m - 1.0) * std::log(further) + std::lgamma(m + 1.0);
  for (const double share : shares) log += std::log(share);
  return log;
}

FewExplanations WithTheirColumns(const std::vector<Explanation>& list, const std::vector<int>& chosen) {
  FewExplanations few;
  for (const int k : chosen) {
    const std::vector<int>& own = list[k].group.columns;
    few.columns.insert(few.columns.end(), own.begin(), own.end());
  }
  few.columns = EachOnce(few.columns);
  for (const int k : chosen) {
    Explanation& own = few.explanations.emplace_back(list[k]);
    for (int& column : own.group.columns) column = PlaceIn(few.columns, column);
    if (own.needs == kNoExplanation) continue;
    const auto needed = std::find(chosen.begin(), chosen.end(), own.needs);
    if (needed == chosen.end()) own.share = 0.0;
    own.needs = needed == chosen.end() ? kNoExplanation : static_cast<int>(needed - chosen.begin());
  }
  return few;
}

std::vector<const ColumnGroup*> GroupsOf(const std::vector<Explanation>& list, const std::vector<int>& members) {
  std::vector<const ColumnGroup*> groups;
  for (const int m : members) groups.push_back(&list[m].group);
  return groups;
}

std::vector<size_t> GoingWith(const std::vector<Explanation>& list, const std::vector<int>& members, size_t place) {
  std::vector<size_t> going;
  for (size_t k = members.size(); k-- > 0;) {
    if (k == place || list[members[k]].needs == members[place]) going.push_back(k);
  }
  return going;
}

}  // namespace sagitta
