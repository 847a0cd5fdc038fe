// What may be missing, as a search over sets of it sees it.
#pragma once

#include <vector>

#include "estimator/random_effects/sweep.h"

namespace sagitta {

constexpr int kNoExplanation = -1;

struct Explanation {
  ColumnGroup group;
  double share = 0.0;          // of the probability that something is missing; all of a list sum to 1
  int excludes = 0;            // explanations of one number exclude each other: settings of one effect on one target
  bool is_general = false;     // any smooth function of a driver: it follows several causes at once
  int needs = kNoExplanation;  // that number, of the explanation without which it does nothing
};

// Some of a list, and the columns they need, ascending: their groups count within those.
struct FewExplanations {
  std::vector<int> columns;
  std::vector<Explanation> explanations;
};
// Of a list, those at the places `chosen`.
FewExplanations WithTheirColumns(const std::vector<Explanation>& list, const std::vector<int>& chosen);

// Of a list, the groups of those at the places `members`.
std::vector<const ColumnGroup*> GroupsOf(const std::vector<Explanation>& list, const std::vector<int>& members);

// What the explanations of a list need. A set holds one of them only together with what that needs: it comes with it,
// as two causes of the prior, and goes with it.
class Needs {
 public:
  explicit Needs(const std::vector<Explanation>& list);

  // Place in the list of what the explanation at a place needs; kNoExplanation.
  int Of(int explanation) const { return of_[explanation]; }
  // Whether it needs what the list does not have: it is in no set.
  bool IsHopeless(int explanation) const {
    return list_[explanation].needs != kNoExplanation && of_[explanation] == kNoExplanation;
  }
  // What it needs and the members lack; kNoExplanation.
  int LackedBy(const std::vector<int>& members, int explanation) const;
  // Places of a member and of those that need it, last first.
  std::vector<size_t> GoingWith(const std::vector<int>& members, size_t place) const;

 private:
  const std::vector<Explanation>& list_;
  std::vector<int> of_;
};

}  // namespace sagitta
