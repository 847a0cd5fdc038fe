// One cause without a name, or several causes of which some have one.
//
// A set that holds a function without a name together with effects of the catalogue on the same part, or with the same
// driver, can be read in two ways: as so many causes, or as one cause without a name of which these effects are pieces.
// A hose, for instance, pulls at a wrist joint in a way of its own, and in part like a wrong encoder gain there. Both
// readings predict the same rows; the priors of causes and of sizes decide between them. Causes have sizes of their
// own. Parts of one cause move the rows by as much: an effect with a function that the rows do not show is no piece of
// it.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "estimator/explanations/explanations.h"

namespace sagitta {

// The second reading of sets of one list.
class NamelessCauses {
 public:
  // robot: of effects of its own. further: SetPrior::further.
  NamelessCauses(const Robot& robot, const ExplanationList& list, double further)
      : robot_(robot), list_(list), further_(further) {}

  // Of a set, ascending: functions without a name, and effects of the catalogue that may be pieces of the same cause.
  struct Cause {
    std::vector<int> functions, pieces;
  };
  Cause OneOf(const std::vector<int>& members);
  // Log of how much more probable one nameless cause with these pieces is than so many causes, before any row is seen.
  double LogPriorOdds(const std::vector<int>& members, const Cause& cause);
  // That of `members` causes there is one more, given that all but one more are known.
  static double OneMore(double further, size_t members);
  // The set with one size of the cause, averaged over it; the other members at their best scales. All are of a list of
  // explanations, which may be another one.
  static WeightedSet WithOneSize(const WeightedSet& set, const Cause& cause,
                                 const std::vector<Explanation>& explanations, const ProjectedNormal& normal,
                                 const ResidualLikelihood& likelihood);

  // The second reading of a set; gain: of its log weight over that of the first one.
  struct AsOne {
    std::vector<int> pieces;  // explanations
    WeightedSet set;
    double gain = 0.0;
  };
  // Nothing where before any row is seen so many causes are more probable: that there is one more of them is no wonder.
  // members: the set's explanations. The set counts its own in `explanations`, the list or some of it, in the same
  // order.
  std::optional<AsOne> ReadAsOne(const std::vector<int>& members, const WeightedSet& set,
                                 const std::vector<Explanation>& explanations, const ProjectedNormal& normal,
                                 const ResidualLikelihood& likelihood);

 private:
  // What may be pieces of a cause with these functions, by explanation, and the share of all of them.
  struct Pieces {
    std::vector<bool> may_be;
    double share = 0.0;
  };
  const Pieces& PiecesOf(const std::vector<int>& functions);

  const Robot& robot_;
  const ExplanationList& list_;
  const double further_;
  std::map<std::vector<int>, Pieces> pieces_;
};

}  // namespace sagitta
