#include "estimator/evidence/evidence.h"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "estimator/evidence/nameless_cause.h"
#include "estimator/explanations/compensator_shapes.h"
#include "estimator/report/explanations_words.h"
#include "models/constants.h"

namespace sagitta {
namespace {

// Repeatability of arms, from small ones to worn ones: 2 to 500 urad, by octaves, then refined.
constexpr double kLeastRepeatability = 2e-6, kMostRepeatability = 5e-4;
constexpr double kSettled = 0.03;  // of log sigma
constexpr int kSettledBits = 5;    // 2^-5
// Rows beyond what is estimated that settle it: of n degrees of freedom a standard deviation is good to 1 / sqrt(2 n),
// 2 % here.
constexpr int kRowsThatSettle = 1000;
// A view that is so much less likely with the best set is not searched: e^-4 = 2 %.
constexpr double kWorthSearching = -4.0;
constexpr int kMostViews = 4;
// A deviation is another than stated only where the interval of 95 % for it, by the likelihood ratio, does not hold
// what is stated: half the quantile of chi-square with one degree of freedom.
constexpr double kLeastGain = 1.92;
// Where a thousand sets share the probability they differ in details: the rest would say the same of every effect.
constexpr size_t kMostModels = 1000;

// Of what has no name, of all that may be missing: of a family in addition to those of the list.
double ShareOfOneMoreFamily(const ExplanationList& list, const PriorMasses& masses) {
  std::set<std::string> families;
  for (size_t k = 0; k < list.math.size(); ++k) {
    if (list.IsUnnamed(static_cast<int>(k))) families.insert(list.place[k].family);
  }
  return masses.unnamed / (masses.catalogue + masses.unnamed) / (1.0 + static_cast<double>(families.size()));
}

// What is estimated stays as it is, and a spring that is held.
ParameterSet WithValuesOf(const ParameterSet& own, const ParameterSet& other) {
  ParameterSet moved = own;
  moved.CopyByName(other);
  Eigen::VectorXd back = Eigen::VectorXd::Zero(own.num_coordinates());
  for (const int i : HeldSpring(own)) back[i] = own.Value(i) - moved.Value(i);
  moved.Plus(back);
  for (int i = 0; i < own.num_coordinates(); ++i) moved.coordinate(i) = own.coordinates()[i];
  return moved;
}

}  // namespace

void Normalise(std::vector<WeightedModel>* models) {
  std::stable_sort(models->begin(), models->end(),
                   [](const WeightedModel& a, const WeightedModel& b) { return a.log_weight > b.log_weight; });
  std::vector<double> logs;
  for (const WeightedModel& model : *models) logs.push_back(model.log_weight);
  const double sum = LogSumExp(logs);
  for (WeightedModel& model : *models) model.probability = std::exp(model.log_weight - sum);
}

Evidence::Evidence(const CalibrationProblem& problem, const ParameterSet& parameters, const CandidateList& candidates,
                   const PriorMasses& masses, double sigma_dof, const std::function<void(const std::string&)>& progress,
                   const Evidence* before, const LinearizedAbout& about)
    : problem_(problem),
      about_(about),
      parameters_(WithValuesOf(parameters, about.parameters)),
      columns_(problem, parameters_, candidates.candidates, about_),
      list_(ListExplanations(problem, parameters_, candidates, masses, &columns_)),
      masses_(masses),
      prior_{masses.nothing, masses.further},
      sigma_dof_(sigma_dof),
      stated_(StatedScatter(problem)) {
  ViewedNormal stated = Viewed({});
  DropInvisible(stated.given_believed.normal, masses, &list_);
  share_of_pose_ = ShareOfOneMoreFamily(list_, masses);
  if (progress) progress("weighing " + std::to_string(list_.math.size()) + " explanations");
  Climb(std::move(stated), before == nullptr ? WeightedSet() : BestOf(*before));
  const auto& joints = problem.robot().chain.joints;
  const bool any_turns =
      std::any_of(joints.begin(), joints.end(), [](const Joint& joint) { return joint.type == JointType::kRevolute; });
  for (int round = 1; round < kMostViews && any_turns; ++round) {
    const WeightedSet best = models_[0].set;
    const std::optional<Trial> next = NextView();
    if (!next) break;
    if (progress) progress(SearchingWithRepeatability(next->view.sigma));
    Climb(Viewed(next->view), best);
  }
  Explore();
}

std::optional<Evidence::Trial> Evidence::NextView() {
  const WeightedModel& best = models_[0];
  std::vector<Trial> trials;
  const auto try_kind = [&](NoiseView::Kind kind, const WeightedSet& set) {
    const auto [known, is_new] = tried_.try_emplace({kind, set.members, set.scales});
    if (is_new) known->second = BestView(kind, set);
    trials.push_back(known->second);
  };
  const auto try_beside = [&](const WeightedSet& set) {
    try_kind(NoiseView::Kind::kVisit, set);
    if (columns_.HasRevisits()) try_kind(NoiseView::Kind::kPose, set);
  };
  try_beside(best.set);
  if (!best.set.members.empty()) try_beside(BestOfNothing().set);  // which other noise may be enough for
  const auto is_known = [&](const NoiseView& view) {
    return std::any_of(views_.begin(), views_.end(), [&](const ViewedNormal& known) {
      return known.view.kind == view.kind && std::abs(std::log(known.view.sigma / view.sigma)) < 0.1;
    });
  };
  std::optional<Trial> next;
  for (const Trial& trial : trials) {
    if (trial.log_weight < best.log_weight + kWorthSearching || is_known(trial.view)) continue;
    if (!next || trial.log_weight > next->log_weight) next = trial;
  }
  return next;
}

JointScatter Evidence::ScatterOf(const NoiseView& view) const {
  JointScatter scatter = stated_;
  if (view.kind == NoiseView::Kind::kStated) return scatter;
  for (long j = 0; j < scatter.visit.size(); ++j) {
    if (problem_.robot().chain.joints[j].type != JointType::kRevolute) continue;
    (view.kind == NoiseView::Kind::kVisit ? scatter.visit : scatter.pose)[j] = view.sigma;
  }
  return scatter;
}

ViewedNormal Evidence::Viewed(const NoiseView& view) const {
  std::set<std::vector<int>> own;
  for (const Explanation& each : list_.math) {
    own.insert(each.group.columns);
    if (each.needs != kNoExplanation) own.insert(ColumnsTogether(list_.math[each.needs].group, each.group));
  }
  const JointScatter scatter = ScatterOf(view);
  return {view, scatter, columns_.ProjectAll(scatter, own)};
}

// A deviation that follows the pose in its own way is one more cause of the set, with the share of one family of what
// has no name: it is a family that is in no list.
double Evidence::LogPriorOf(const NoiseView& view, const WeightedSet& set) const {
  switch (view.kind) {
    case NoiseView::Kind::kStated:
      return 0.0;
    case NoiseView::Kind::kVisit:
      return std::log(kNoiseIsWrong) + view.log_occam;
    case NoiseView::Kind::kPose:
      break;
  }
  std::vector<double> shares(set.members.size(), 1.0);
  const double without = prior_.Log(shares);
  shares.push_back(share_of_pose_);
  return prior_.Log(shares) - without + view.log_occam;
}

double Evidence::LogWeight(const NoiseView& view, const WeightedSet& set, const FewExplanations& few,
                           const RowSums& sums) const {
  std::vector<int> members(set.members.size());
  std::iota(members.begin(), members.end(), 0);
  const GivenBelieved given_believed = columns_.Project(sums);
  return SearchAmong(few.explanations, given_believed.normal).Evaluate(members, set.scales).log_weight +
         given_believed.log_constant + LogPriorOf(view, set);
}

// In the first view, whose normal equations are there.
double Evidence::LogWeightAsStated(const WeightedSet& set) const {
  return SearchIn(0).Evaluate(set.members, set.scales).log_weight + views_[0].given_believed.log_constant;
}

// The size is found on as many blocks of rows as settle it; all rows say how likely it is.
Evidence::Trial Evidence::BestView(NoiseView::Kind kind, const WeightedSet& set) const {
  const double low = std::log(kLeastRepeatability), high = std::log(kMostRepeatability);
  const FewExplanations few = WithTheirColumns(list_.math, set.members);
  const int enough = kRowsThatSettle + columns_.num_believed() + static_cast<int>(few.columns.size());
  const int every = std::max(1, columns_.num_rows() / enough);
  const auto view_at = [&](double log_sigma) { return NoiseView{kind, std::exp(log_sigma)}; };
  const auto weight = [&](double log_sigma, int one_in = 1) {
    const NoiseView view = view_at(log_sigma);
    return LogWeight(view, set, few, columns_.Sum(ScatterOf(view), few.columns, one_in));
  };
  const auto among_some = [&](double log_sigma) { return weight(log_sigma, every); };
  const double spacing = std::log(2.0);
  double near = low, near_weight = among_some(low);
  for (double at = low + spacing; at <= high; at += spacing) {
    const double here = among_some(at);
    if (here <= near_weight) continue;
    near = at;
    near_weight = here;
  }
  // Counted from the nearest of them: the precision is relative.
  const auto offset = boost::math::tools::brent_find_minima([&](double at) { return -among_some(near + at); },
                                                            std::max(low - near, -spacing),
                                                            std::min(high - near, spacing), kSettledBits)
                          .first;
  const double best = near + offset, best_weight = weight(best);
  const double gain = best_weight - LogPriorOf(view_at(best), set) - LogWeightAsStated(set);
  if (gain < kLeastGain) return {};
  // The prior is even over log sigma: of its range the likelihood keeps what its curvature leaves.
  const double apart = 4.0 * kSettled;
  const double curvature = (2.0 * best_weight - weight(best - apart) - weight(best + apart)) / (apart * apart);
  const double width = std::sqrt(2.0 * kPi / std::max(curvature, 1e-3));
  const double occam = std::log(std::min(1.0, width / (high - low)));
  return {{kind, std::exp(best), occam}, best_weight + occam};
}

const WeightedModel& Evidence::BestOfNothing() const {
  return *std::find_if(models_.begin(), models_.end(),
                       [](const WeightedModel& model) { return model.set.members.empty(); });
}

void Evidence::Correct(const std::vector<double>& log_corrections) {
  for (size_t m = 0; m < models_.size(); ++m) models_[m].log_weight += log_corrections[m];
  Normalise(&models_);
}

void Evidence::AddModel(int view, const WeightedSet& set) {
  const ViewedNormal& viewed = views_[view];
  models_.push_back(
      {view, set, 0.0, set.log_weight + viewed.given_believed.log_constant + LogPriorOf(viewed.view, set)});
}

WeightedSet Evidence::BestOf(const Evidence& other) const {
  const auto key = [](const ExplanationList& list, size_t k) {
    return std::make_tuple(list.name[k], list.start[k].Path(), list.start[k].values, list.math[k].group.size());
  };
  std::map<std::tuple<std::string, std::string, std::vector<double>, int>, int> here;
  for (size_t k = 0; k < list_.math.size(); ++k) here.emplace(key(list_, k), static_cast<int>(k));
  WeightedSet set;
  for (const int m : other.models()[0].set.members) {
    const auto same = here.find(key(other.list(), static_cast<size_t>(m)));
    if (same != here.end()) set.members.push_back(same->second);
  }
  set.members = EachOnce(set.members);
  return set;
}

void Evidence::Climb(ViewedNormal viewed, const WeightedSet& start) {
  views_.push_back(std::move(viewed));
  const int view = static_cast<int>(views_.size()) - 1;
  SetSearch& search = searches_.emplace_back(SearchIn(view));
  search.ClimbFrom(start);
  AddModel(view, search.Best());
  if (!search.Best().members.empty()) AddModel(view, search.Empty());
  Normalise(&models_);
}

void Evidence::Explore() {
  std::vector<WeightedModel> climbed = std::move(models_);
  models_.clear();
  const double hopeless = climbed[0].log_weight - kWorthKeeping;
  for (int view = 0; view < static_cast<int>(views_.size()); ++view) {
    const auto is_near = [&](const WeightedModel& model) { return model.view == view && model.log_weight >= hopeless; };
    if (std::any_of(climbed.begin(), climbed.end(), is_near)) {
      for (const WeightedSet& set : searches_[view].Explore()) AddModel(view, set);
    } else {
      for (const WeightedModel& model : climbed) {
        if (model.view == view) models_.push_back(model);
      }
    }
  }
  searches_.clear();
  AddReadings();
  Normalise(&models_);
  if (models_.size() <= kMostModels) return;
  const auto holds_something = [](const WeightedModel& model) { return !model.set.members.empty(); };
  models_.erase(std::remove_if(models_.begin() + kMostModels, models_.end(), holds_something), models_.end());
  Normalise(&models_);
}

void Evidence::AddReadings() {
  NamelessCauses causes(problem_.robot(), list_, masses_.further);
  for (size_t i = models_.size(); i-- > 0;) {
    const WeightedModel& many = models_[i];
    auto one = causes.ReadAsOne(many.set.members, many.set, list_.math, NormalOf(many.view), LikelihoodOf(many.view));
    if (!one) continue;
    WeightedModel as_one = many;
    as_one.pieces = std::move(one->pieces);
    as_one.set = std::move(one->set);
    as_one.log_weight += one->gain;
    models_.push_back(std::move(as_one));
  }
}

GroupValues Evidence::ValuesOfMember(const WeightedModel& model, int member) const {
  const std::vector<const ColumnGroup*> groups = GroupsOf(list_.math, model.set.members);
  return ValuesOf(NormalOf(model.view), groups, model.set.scales).Of(model.PlaceOf(member), groups);
}

Members Evidence::MembersOf(const WeightedModel& model, const std::vector<double>* scales) const {
  return Members(NormalOf(model.view), GroupsOf(list_.math, model.set.members),
                 scales == nullptr ? model.set.scales : *scales);
}

double Evidence::ResidualOf(const WeightedModel& model) const { return MembersOf(model).residual(); }

double Evidence::SigmaIsWrong(const WeightedModel& model) const {
  return LikelihoodOf(model.view).ProbabilityWrong(ResidualOf(model));
}

}  // namespace sagitta
