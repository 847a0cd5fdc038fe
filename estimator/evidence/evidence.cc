#include "estimator/evidence/evidence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "estimator/evidence/nameless_cause.h"
#include "estimator/explanations/compensator_shapes.h"

namespace sagitta {
namespace {

// Where a thousand sets share the probability they differ in details: the rest would say the same of every effect.
constexpr size_t kMostModels = 1000;

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
      prior_{masses.nothing, masses.further, about.holds_weight},
      sigma_dof_(sigma_dof),
      stated_(StatedScatter(problem)) {
  ViewedNormal stated = Viewed({});
  DropInvisible(stated.given_believed.normal, masses, &list_);
  if (progress) progress("weighing " + std::to_string(list_.math.size()) + " explanations");
  const WeightedSet start = before == nullptr ? WeightedSet() : BestOf(*before);
  Climb(std::move(stated), start);
  ClimbInViews(progress, start);
  Explore();
}

ViewedNormal Evidence::Viewed(const NoiseView& view) const {
  std::set<std::vector<int>> own;
  for (const Explanation& each : list_.math) {
    own.insert(each.group.columns);
    if (each.needs != kNoExplanation) own.insert(ColumnsTogether(list_.math[each.needs].group, each.group));
  }
  const RowScatter scatter = ScatterOf(view);
  return {view, scatter, columns_.ProjectAll(scatter, own)};
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
