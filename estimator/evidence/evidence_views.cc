// Views of the noise: which are worth a search, and how likely each is in addition to what a set explains.
#include <glog/logging.h>

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <numeric>
#include <set>
#include <string>

#include "estimator/evidence/evidence.h"
#include "estimator/noise/rigid_bodies.h"
#include "estimator/report/explanations_words.h"
#include "models/constants.h"

namespace sagitta {
namespace {

// Repeatability of arms, from small ones to worn ones: 2 to 500 urad, of axes that slide 1 to 250 um.
constexpr double kLeastRepeatability = 2e-6, kMostRepeatability = 5e-4;
constexpr double kSettled = 0.03;        // of the logarithm of a size, which is found by factors of four, then refined
constexpr int kBitsOfRepeatability = 5;  // 2^-5
constexpr int kBitsOfSigma = 7;          // of a logarithm of one half, 0.4 %
// Rows beyond what is estimated that settle it: of n degrees of freedom a standard deviation is good to 1 / sqrt(2 n),
// 2 % here.
constexpr int kRowsThatSettle = 1000;
// A view that is so much less likely with the best set is not searched: e^-4 = 2 %.
constexpr double kWorthSearching = -4.0;
constexpr int kMostViews = 5;         // as stated, sigma alone, joints that deviate, by the pose, and one more
constexpr int kMostChanges = 8;       // of a view before it is searched: a part, the joints, and six groups
constexpr size_t kMostPromising = 2;  // groups that each change tries: of two stations each says the same of the other
constexpr double kSameSize = 0.1;     // of the logarithm: fifty degrees of freedom leave as much open

struct LogRange {
  double low, high;
};

LogRange RangeOf(const NoisePart& part) {
  if (part.group) return {-std::log(kWidestFactor), std::log(kWidestFactor)};
  return {std::log(kLeastRepeatability), std::log(kMostRepeatability)};
}

// The prior is even over the logarithm: of its range the likelihood keeps what its curvature leaves.
double LogOccam(double log_sd, const LogRange& range) {
  return std::log(std::min(1.0, std::sqrt(2.0 * kPi) * log_sd / (range.high - range.low)));
}

bool IsOf(const ViewedGroup& viewed, const ReadingGroup& group) { return viewed.scaled.group == group; }

// Groups are in order.
std::vector<ViewedGroup>::iterator PlaceOf(const ReadingGroup& group, NoiseView* view) {
  return std::find_if(view->groups.begin(), view->groups.end(),
                      [&](const ViewedGroup& viewed) { return !(viewed.scaled.group < group); });
}

// The view with a part of this size.
NoiseView With(const NoiseView& base, const NoisePart& part, double size) {
  NoiseView view = base;
  if (part.group) {
    view.groups.insert(PlaceOf(*part.group, &view), {{*part.group, size}});
  } else {
    view.kind = part.joints;
    view.sigma = size;
    if (view.kind == NoiseView::Kind::kVisit) view.joints_over_sigma = 1.0;
  }
  return view;
}

// The view in which a part is as stated.
NoiseView Without(const NoiseView& view, const NoisePart& part) {
  NoiseView base = view;
  const auto is_it = [&](const ViewedGroup& viewed) {
    return IsOf(viewed, *part.group) || (part.instead_of && IsOf(viewed, *part.instead_of));
  };
  if (part.group) {
    base.groups.erase(std::remove_if(base.groups.begin(), base.groups.end(), is_it), base.groups.end());
  } else if (part.is_sigma_alone) {
    base.joints_over_sigma = 1.0;
  } else {
    base.kind = NoiseView::Kind::kStated;
    base.sigma = base.log_occam = 0.0;
  }
  return base;
}

bool HaveEqualGroups(const NoiseView& a, const NoiseView& b) {
  return std::equal(a.groups.begin(), a.groups.end(), b.groups.begin(), b.groups.end(),
                    [](const ViewedGroup& own, const ViewedGroup& other) {
                      return IsOf(own, other.scaled.group) &&
                             std::abs(std::log(own.scaled.factor / other.scaled.factor)) < kSameSize;
                    });
}

bool AreAlike(const NoiseView& a, const NoiseView& b) {
  const auto are_equal = [](double one, double other) { return std::abs(std::log(one / other)) < kSameSize; };
  if (a.kind != b.kind || !HaveEqualGroups(a, b) || !are_equal(a.joints_over_sigma, b.joints_over_sigma)) return false;
  return a.kind == NoiseView::Kind::kStated || are_equal(a.sigma, b.sigma);
}

std::string SearchingWith(const NoiseView& view, const Measurements& data) {
  if (view.kind != NoiseView::Kind::kStated) return SearchingWithRepeatability(view.sigma);
  if (!view.groups.empty()) return SearchingWithGroups(view.Scaled(), data);
  return SearchingWithSigmaAlone(1.0 / view.joints_over_sigma);
}

NoisePart SigmaAlone() {
  NoisePart part;
  part.is_sigma_alone = true;
  return part;
}

// Of a group that a view has: another factor, or another group of the kind in its place. That one of two stations
// scatters less and all more is that the other one scatters more.
void AddChangesOf(const ScaledGroup& scaled, const std::vector<ReadingGroup>& groups, std::vector<NoisePart>* parts) {
  parts->push_back({NoiseView::Kind::kStated, scaled.group, scaled.factor});
  for (const ReadingGroup& other : groups) {
    if (other.kind != scaled.group.kind || other == scaled.group) continue;
    parts->push_back({NoiseView::Kind::kStated, other, 1.0 / scaled.factor, scaled.group});
  }
}

// Of what has no name, of all that may be missing: of a family in addition to those of the list.
double ShareOfOneMoreFamily(const ExplanationList& list, const PriorMasses& masses) {
  std::set<std::string> families;
  for (size_t k = 0; k < list.math.size(); ++k) {
    if (list.IsUnnamed(static_cast<int>(k))) families.insert(list.place[k].family);
  }
  return masses.unnamed / (masses.catalogue + masses.unnamed) / (1.0 + static_cast<double>(families.size()));
}

}  // namespace

NoiseSizes SizesOf(const NoiseView& view) {
  NoiseSizes sizes{view.kind, view.sigma, view.joints_over_sigma, {}};
  for (const ViewedGroup& viewed : view.groups)
    std::get<3>(sizes).emplace_back(viewed.scaled.group, viewed.scaled.factor);
  return sizes;
}

std::vector<ScaledGroup> NoiseView::Scaled() const {
  std::vector<ScaledGroup> scaled;
  for (const ViewedGroup& viewed : groups) scaled.push_back(viewed.scaled);
  return scaled;
}

void Evidence::ClimbInViews(const std::function<void(const std::string&)>& progress, const WeightedSet& start) {
  share_of_pose_ = ShareOfOneMoreFamily(list_, masses_);
  const std::vector<ReadingGroup> all = GroupsOfReadings(problem_);
  log_share_of_group_ = std::log(kNoiseIsWrong / static_cast<double>(std::max<size_t>(1, all.size())));
  groups_.clear();
  for (const GroupOfOwnNoise& own : GroupsOfOwnNoise(problem_, parameters_, all)) groups_.push_back(own.scaled.group);
  for (int round = 1; round < kMostViews; ++round) {
    WeightedModel near = models_[0];
    if (round == 1 && !start.members.empty()) near = {0, searches_[0].Evaluate(start.members)};
    const std::optional<Trial> next = NextView(near);
    if (!next) return;
    if (progress) progress(SearchingWith(next->view, problem_.data()));
    VLOG(1) << "diagnosis: joints " << 1e6 * next->view.sigma << " urad, " << next->view.groups.size()
            << " groups of readings: " << next->log_weight - models_[0].log_weight << " over the best so far";
    Climb(Viewed(next->view), near.set);
  }
}

std::vector<NoisePart> Evidence::PartsFor(const NoiseView& view) const {
  std::vector<NoisePart> parts;
  parts.push_back({NoiseView::Kind::kVisit});
  if (columns_.HasRevisits()) parts.push_back({NoiseView::Kind::kPose});
  if (!stated_.visit.isZero(0.0) && view.kind != NoiseView::Kind::kVisit) parts.push_back(SigmaAlone());
  if (!groups_.empty()) AddGroups(view, &parts);
  return parts;
}

// Those that the view has, and the few of which rigid bodies say most, given the view's factors.
void Evidence::AddGroups(const NoiseView& view, std::vector<NoisePart>* parts) const {
  for (const ViewedGroup& viewed : view.groups) AddChangesOf(viewed.scaled, groups_, parts);
  const auto is_in_view = [&view](const ReadingGroup& group) {
    return std::any_of(view.groups.begin(), view.groups.end(), [&](const auto& viewed) { return IsOf(viewed, group); });
  };
  size_t added = 0;
  for (const auto& [scaled, gain] : GroupsOfOwnNoise(WithScaledGroups(problem_, view.Scaled()), parameters_, groups_)) {
    if (added == kMostPromising) return;
    if (is_in_view(scaled.group)) continue;
    parts->push_back({NoiseView::Kind::kStated, scaled.group, scaled.factor});
    ++added;
  }
}

Evidence::Trial Evidence::BestChange(const NoiseView& view, const WeightedSet& set) {
  const auto is_searched = [&](const NoiseView& other) {
    return std::any_of(views_.begin(), views_.end(),
                       [&](const ViewedNormal& known) { return AreAlike(known.view, other); });
  };
  Trial best;
  for (const NoisePart& part : PartsFor(view)) {
    const NoiseView base = Without(view, part);
    const auto [known, is_new] = tried_.try_emplace({SizesOf(base), part, set.members, set.scales});
    if (is_new) known->second = part.is_sigma_alone ? ViewOfSigmaAlone(base, set) : BestView(base, part, set);
    const Trial& trial = known->second;
    if (trial.log_weight <= best.log_weight || AreAlike(trial.view, view) || is_searched(trial.view)) continue;
    best = trial;
  }
  return best;
}

// Changed in one part, then in as many as make it more likely: each search is worth many changes.
std::optional<Evidence::Trial> Evidence::NextView(const WeightedModel& near) {
  std::optional<Trial> next;
  const auto try_next_to = [&](const WeightedModel& model) {
    Trial trial = BestChange(ViewOf(model), model.set);
    if (trial.log_weight < models_[0].log_weight + kWorthSearching) return;
    for (int change = 1; change < kMostChanges; ++change) {
      Trial more = BestChange(trial.view, model.set);
      if (more.log_weight <= trial.log_weight) break;
      trial = std::move(more);
    }
    if (!next || trial.log_weight > next->log_weight) next = std::move(trial);
  };
  try_next_to(near);
  if (!near.set.members.empty()) try_next_to(BestOfNothing());  // which other noise may be enough for
  return next;
}

RowScatter Evidence::ScatterOf(const NoiseView& view) const {
  RowScatter scatter = stated_;
  scatter.readings = view.Scaled();
  scatter.visit *= view.joints_over_sigma;
  if (view.kind == NoiseView::Kind::kStated) return scatter;
  for (long j = 0; j < scatter.visit.size(); ++j) {
    const bool turns = problem_.robot().chain.joints[j].type == JointType::kRevolute;
    (view.kind == NoiseView::Kind::kVisit ? scatter.visit : scatter.pose)[j] =
        turns ? view.sigma : kTravelPerTurn * view.sigma;
  }
  return scatter;
}

// A deviation that follows the pose in its own way is one more cause of the set, with the share of one family of what
// has no name: it is a family that is in no list. That some group scatters otherwise is shared by all groups.
double Evidence::LogPriorOf(const NoiseView& view, const WeightedSet& set) const {
  double log_prior = view.log_occam;
  for (const ViewedGroup& group : view.groups) log_prior += log_share_of_group_ + group.log_occam;
  if (view.kind == NoiseView::Kind::kVisit) log_prior += std::log(kNoiseIsWrong);
  if (view.kind != NoiseView::Kind::kPose) return log_prior;
  std::vector<double> shares(set.members.size(), 1.0);
  const double without = prior_.Log(shares);
  shares.push_back(share_of_pose_);
  return log_prior + prior_.Log(shares) - without;
}

double Evidence::LogWeight(const NoiseView& view, const WeightedSet& set, const FewExplanations& few,
                           const RowSums& sums) const {
  std::vector<int> members(set.members.size());
  std::iota(members.begin(), members.end(), 0);
  const GivenBelieved given_believed = columns_.Project(sums);
  return SearchAmong(few.explanations, given_believed.normal).Evaluate(members, set.scales).log_weight +
         given_believed.log_constant + LogPriorOf(view, set);
}

// With a given factor f of all that scatters the rows say, of a set that leaves R with n degrees of freedom,
//   -n log f - R / 2 f^2
// in place of what the likelihood says of any factor; the joints deviate by 1 / f of that.
Evidence::Trial Evidence::ViewOfSigmaAlone(const NoiseView& base, const WeightedSet& set) {
  const FewExplanations few = WithTheirColumns(list_.math, set.members);
  std::vector<int> members(set.members.size());
  std::iota(members.begin(), members.end(), 0);
  NoiseView view = base;
  const auto weight = [&](double log_factor) {
    view.joints_over_sigma = std::exp(-log_factor);
    const RowSums sums = columns_.Sum(ScatterOf(view), few.columns, 1);
    const ProjectedNormal normal = columns_.Project(sums).normal;
    const double residual = Members(normal, GroupsOf(few.explanations, members), set.scales).residual();
    return LogWeight(view, set, few, sums) - Likelihood(normal.dof).Log(residual) - normal.dof * log_factor -
           0.5 * residual * std::exp(-2.0 * log_factor);
  };
  const double widest = std::log(kWidestFactor);
  const auto [log_factor, least] =
      boost::math::tools::brent_find_minima([&](double at) { return -weight(at); }, -widest, widest, kBitsOfSigma);
  view.joints_over_sigma = std::exp(-log_factor);
  return {view, LogWeight(view, set, few, columns_.Sum(ScatterOf(view), few.columns, 1))};
}

// Or `base` itself, where the rows do not ask for the part. The size is found on as many blocks of rows as settle it;
// all rows say how likely it is.
Evidence::Trial Evidence::BestView(const NoiseView& base, const NoisePart& part, const WeightedSet& set) {
  const auto [low, high] = RangeOf(part);
  const FewExplanations few = WithTheirColumns(list_.math, set.members);
  const int enough = kRowsThatSettle + columns_.num_believed() + static_cast<int>(few.columns.size());
  const int every = std::max(1, columns_.num_rows() / enough);
  const auto weight_of = [&](const NoiseView& view, int one_in) {
    return LogWeight(view, set, few, columns_.Sum(ScatterOf(view), few.columns, one_in));
  };
  const auto weight = [&](double log_size) { return weight_of(With(base, part, std::exp(log_size)), 1); };
  const auto among_some = [&](double log_size) { return weight_of(With(base, part, std::exp(log_size)), every); };
  const double spacing = std::log(4.0);
  double near = part.group ? std::clamp(std::log(part.about), low, high) : low;
  double near_weight = among_some(near);
  for (double at = low + spacing; !part.group && at <= high; at += spacing) {
    const double here = among_some(at);
    if (here <= near_weight) continue;
    near = at;
    near_weight = here;
  }
  // Counted from the nearest of them: the precision is relative.
  const auto [offset, least] = boost::math::tools::brent_find_minima(
      [&](double at) { return -among_some(near + at); }, std::max(low - near, -spacing), std::min(high - near, spacing),
      kBitsOfRepeatability);
  const auto [base_known, is_new] = weights_.try_emplace({SizesOf(base), set.members, set.scales});
  if (is_new) base_known->second = weight_of(base, 1);
  const double at = near + offset, at_weight = every == 1 ? -least : weight(at), base_weight = base_known->second;
  NoiseView view = With(base, part, std::exp(at));
  const double gain = at_weight - LogPriorOf(view, set) - (base_weight - LogPriorOf(base, set));
  if (gain < kLeastGain) return {base, base_weight};
  // The top of the parabola through three points, at most one of them away.
  const double apart = 4.0 * kSettled, up = weight(at + apart), down = weight(at - apart);
  const double slope = (up - down) / (2.0 * apart);
  // At least that of a size whose logarithm is known to 32: to nothing.
  const double curvature = std::max((2.0 * at_weight - up - down) / (apart * apart), 1e-3);
  const double beyond = std::clamp(slope / curvature, -apart, apart);
  view = With(base, part, std::exp(at + beyond));
  const double log_sd = 1.0 / std::sqrt(curvature), occam = LogOccam(log_sd, RangeOf(part));
  if (part.group) {
    const auto own = PlaceOf(*part.group, &view);
    own->log_sd = log_sd;
    own->log_occam = occam;
  } else {
    view.log_occam = occam;
  }
  return {view, at_weight + (slope - 0.5 * curvature * beyond) * beyond + occam};
}

}  // namespace sagitta
