// What may be missing, as a search over sets of it sees it.
#pragma once

#include <vector>

#include "estimator/random_effects/sweep.h"

namespace sagitta {

constexpr int kNoExplanation = -1;

struct Explanation {
  ColumnGroup group;
  double share = 0.0;  // of the probability that something is missing; those of a list sum to 1, the unlisted included
  int excludes = 0;    // explanations of one number exclude each other: settings of one effect on one target
  bool is_general = false;  // any smooth function of a driver: it follows several causes at once
  // Place in the list of the explanation without which it does nothing: a set holds both, as two causes of the prior,
  // which come and go together.
  int needs = kNoExplanation;
  bool is_weight = false;  // SetPrior::holds_weight
};

// nothing: no explanation holds. further: each one in addition to the first. P(set of m) = (1 - nothing) further^(m-1)
// m! times the product of the shares: m draws in any order.
struct SetPrior {
  double nothing = 0.5;
  double further = 0.3;
  bool holds_weight = false;  // sets without a weight are out of the question

  double Log(const std::vector<double>& shares) const;
};

// Some of a list, and the columns they need, ascending: their groups count within those.
struct FewExplanations {
  std::vector<int> columns;
  std::vector<Explanation> explanations;
};
// Of a list, those at the places `chosen`. One that needs what is not among them is in no set: it has no share.
FewExplanations WithTheirColumns(const std::vector<Explanation>& list, const std::vector<int>& chosen);

// Of a list, the groups of those at the places `members`.
std::vector<const ColumnGroup*> GroupsOf(const std::vector<Explanation>& list, const std::vector<int>& members);

// Places of a member and of those that need it, last first.
std::vector<size_t> GoingWith(const std::vector<Explanation>& list, const std::vector<int>& members, size_t place);

}  // namespace sagitta
