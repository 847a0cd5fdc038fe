#include "estimator/random_effects/explanation.h"

#include <algorithm>
#include <map>

namespace sagitta {

FewExplanations WithTheirColumns(const std::vector<Explanation>& list, const std::vector<int>& chosen) {
  FewExplanations few;
  for (const int k : chosen) {
    const std::vector<int>& own = list[k].group.columns;
    few.columns.insert(few.columns.end(), own.begin(), own.end());
  }
  few.columns = EachOnce(few.columns);
  for (const int k : chosen) {
    few.explanations.push_back(list[k]);
    for (int& column : few.explanations.back().group.columns) column = PlaceIn(few.columns, column);
  }
  return few;
}

std::vector<const ColumnGroup*> GroupsOf(const std::vector<Explanation>& list, const std::vector<int>& members) {
  std::vector<const ColumnGroup*> groups;
  for (const int m : members) groups.push_back(&list[m].group);
  return groups;
}

Needs::Needs(const std::vector<Explanation>& list) : list_(list), of_(list.size(), kNoExplanation) {
  std::map<int, int> place;  // of the first of each number
  for (size_t k = 0; k < list.size(); ++k) place.emplace(list[k].excludes, static_cast<int>(k));
  for (size_t k = 0; k < list.size(); ++k) {
    const auto needed = place.find(list[k].needs);
    if (list[k].needs != kNoExplanation && needed != place.end()) of_[k] = needed->second;
  }
}

int Needs::LackedBy(const std::vector<int>& members, int explanation) const {
  const bool has_it =
      std::any_of(members.begin(), members.end(), [&](int m) { return list_[m].excludes == list_[explanation].needs; });
  return has_it ? kNoExplanation : of_[explanation];
}

std::vector<size_t> Needs::GoingWith(const std::vector<int>& members, size_t place) const {
  std::vector<size_t> going;
  for (size_t k = members.size(); k-- > 0;) {
    if (k == place || list_[members[k]].needs == list_[members[place]].excludes) going.push_back(k);
  }
  return going;
}

}  // namespace sagitta
