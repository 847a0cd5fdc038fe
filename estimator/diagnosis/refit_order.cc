#include "estimator/diagnosis/refit_order.h"

#include <algorithm>
#include <cmath>

namespace sagitta {
namespace {

// Of the best: a set that may lead once others have lost what the full model does not keep; at odds of 20, ln 20 = 3, a
// refit would have to move it by three times kInDoubt.
constexpr double kMayLead = 0.05;
// A choice that bounds the time, for each is a fit of the full model: fewer where the linear evidence holds.
constexpr size_t kMostRefitted = 4;
constexpr size_t kMostInDoubt = 10;

}  // namespace

RefitOrder::RefitOrder(const Posterior& posterior)
    : posterior_(posterior), corrections_(posterior.sets.size(), std::numeric_limits<double>::quiet_NaN()) {}

void RefitOrder::Add(size_t set, double correction) {
  corrections_[set] = correction;
  ++refitted_;
  if (std::isinf(correction)) return;
  if (std::isnan(correction)) correction = 0.0;
  doubt_ = std::max(doubt_, std::abs(correction));
  best_ = std::max(best_, LogOf(set) + correction);
}

size_t RefitOrder::Next() const {
  const size_t none = posterior_.sets.size();
  if (refitted_ >= (doubt_ > kInDoubt ? kMostInDoubt : kMostRefitted)) return none;
  for (size_t s = 0; s < none; ++s) {
    if (!std::isnan(corrections_[s]) || posterior_.sets[s].has_unnamed) continue;
    const size_t within = LargestWithin(s);
    const double log = LogOf(s) + (within == none ? doubt_ : corrections_[within]);
    if (log >= best_ + std::log(kMayLead)) return s;
  }
  return none;
}

double RefitOrder::CorrectionOf(size_t set) const {
  if (!std::isnan(corrections_[set])) return corrections_[set];
  const size_t within = LargestWithin(set);
  return within == posterior_.sets.size() ? 0.0 : corrections_[within];
}

double RefitOrder::LogOf(size_t set) const { return std::log(std::max(posterior_.sets[set].probability, 1e-300)); }

size_t RefitOrder::LargestWithin(size_t set) const {
  const std::vector<int> names = EachOnce(posterior_.sets[set].names, posterior_.sets[set].pieces);
  size_t largest = posterior_.sets.size(), most = 0;
  for (size_t s = 0; s < posterior_.sets.size(); ++s) {
    const std::vector<int>& own = posterior_.sets[s].names;
    if (!std::isfinite(corrections_[s]) || own.size() <= most) continue;
    if (!std::includes(names.begin(), names.end(), own.begin(), own.end())) continue;
    largest = s;
    most = own.size();
  }
  return largest;
}

}  // namespace sagitta
