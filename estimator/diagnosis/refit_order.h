// Which sets of effects are refitted in the full model, and what the refits say of the others.
//
// What a refit moves the log evidence of one set by, the linear evidence of others may be off by as well: the doubt d.
// A set may lead where, with d in its favour, it has a twentieth of the best so far. A set that holds more than a
// refitted one, also as pieces of a nameless cause, shares what that lost or won, and is not in doubt; nor is one with
// something that has no name, which the full model cannot hold.
#pragma once

#include <limits>
#include <vector>

#include "estimator/evidence/posterior.h"

namespace sagitta {

constexpr double kInDoubt = 1.0;  // log evidence: odds that a refit changes by less are not worth more of them

class RefitOrder {
 public:
  // Must outlive the order; its sets are meant by their places.
  explicit RefitOrder(const Posterior& posterior);

  // correction: by which the refit moved the set's log evidence; -infinity: the full model has no optimum there; not a
  // number: the full model does not hold all of the set.
  void Add(size_t set, double correction);
  // The most probable of those that may lead; none: the number of sets.
  size_t Next() const;
  // That of the refit, or of the largest refitted set within it; 0: neither is known.
  double CorrectionOf(size_t set) const;

 private:
  double LogOf(size_t set) const;
  size_t LargestWithin(size_t set) const;  // the number of sets: none

  const Posterior& posterior_;
  std::vector<double> corrections_;  // not a number: not refitted
  size_t refitted_ = 0;
  double doubt_ = 0.0;
  double best_ = -std::numeric_limits<double>::infinity();  // log of the corrected probability, not normalised
};

}  // namespace sagitta
