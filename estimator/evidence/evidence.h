// The posterior over everything that could explain the gap: sets of explanations given each view of the noise.
//
// The noise is one more thing that may be other than stated. Its factor is part of the likelihood (evidence_score.h);
// that joints deviate at every visit by more or less than stated, that some deviation follows the pose in a way of its
// own, or that a group of readings scatters by a factor of its own, are other covariances of the rows. Each view has
// its normal equations; their log weights compare directly:
//
//   log p(r | view, set) = -1/2 log |C| - 1/2 log |J' C^-1 J| + log f(R) + log B(set)
//
// A view is searched only where it is worth that, which the best set so far says at the cost of its few columns.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "estimator/explanations/explanations.h"
#include "estimator/random_effects/set_search.h"
#include "models/effects/learnt_deviation.h"

namespace sagitta {

constexpr double kEvenOdds = 0.5;  // as likely as not
// That a stated noise is wrong in its factor, in its repeatability, and in that of some group of readings: one
// experiment in twenty each.
constexpr double kNoiseIsWrong = 0.05;

// A group of readings with the factor that a view has for it, with nothing, or a set, missing.
struct ViewedGroup {
  ScaledGroup scaled;
  double log_sd = 0.0;     // of the factor's logarithm
  double log_occam = 0.0;  // as of the view
};

// Joints that slide deviate in this proportion to those that turn, m/rad: both by as much of what is typical of a
// joint.
constexpr double kTravelPerTurn = kTypicalTravel / kTypicalTurn;

// How the noise is assumed to be.
struct NoiseView {
  enum class Kind {
    kStated,
    kVisit,  // joint repeatability is another than stated
    kPose    // a deviation of the joints that follows the pose, without a name
  };
  Kind kind = Kind::kStated;
  double sigma = 0.0;      // of the latter two: rad of joints that turn, those that slide in proportion
  double log_occam = 0.0;  // of the even prior over log sigma, what the likelihood keeps
  std::vector<ViewedGroup> groups = {};
  // Of a wrong factor of sigma, its inverse: it scales all that scatters, and the joints deviate as stated all the
  // same.
  double joints_over_sigma = 1.0;

  bool IsNoiseStated() const { return kind != Kind::kVisit && groups.empty() && joints_over_sigma == 1.0; }
  bool IsStated() const { return IsNoiseStated() && kind == Kind::kStated; }
  std::vector<ScaledGroup> Scaled() const;
};

// What a view is, in an order.
using NoiseSizes = std::tuple<NoiseView::Kind, double, double, std::vector<std::pair<ReadingGroup, double>>>;
NoiseSizes SizesOf(const NoiseView& view);

// What of the noise may be other than in a view: how the joints deviate, where it is given how a group scatters, or
// sigma where the joints deviate as stated.
struct NoisePart {
  NoiseView::Kind joints = NoiseView::Kind::kStated;
  std::optional<ReadingGroup> group = std::nullopt;
  double about = 0.0;  // the group's factor is near it
  std::optional<ReadingGroup> instead_of = std::nullopt;
  bool is_sigma_alone = false;

  // By all that a search for its size depends on, given the view without it.
  bool operator<(const NoisePart& other) const {
    return std::tie(joints, group, about, is_sigma_alone) <
           std::tie(other.joints, other.group, other.about, other.is_sigma_alone);
  }
};

// Weights over all views and sets, normalised.
struct WeightedModel {
  int view = 0;
  WeightedSet set;
  double probability = 0.0;
  double log_weight = 0.0;  // before normalisation
  // Members of the catalogue that are read as pieces of the set's nameless cause, ascending (nameless_cause.h).
  std::vector<int> pieces = {};
  // Readings scatter more than is stated, whatever the prior says, and that is more probable than any cause.
  bool is_sigma_refuted = false;

  size_t PlaceOf(int member) const { return PlaceIn(set.members, member); }
  bool HasPiece(int member) const { return std::binary_search(pieces.begin(), pieces.end(), member); }
};

// Sorted by weight, with probabilities that sum to 1.
void Normalise(std::vector<WeightedModel>* models);

// Normal equations of the explanations in one view of the noise.
struct ViewedNormal {
  NoiseView view;
  RowScatter scatter;
  GivenBelieved given_believed;
};

// What the rows say of all explanations, for every view of the noise.
class Evidence {
 public:
  // sigma_dof: what states the noise (ResidualLikelihood). before: of other rows of the same problem; the search starts
  // from its best set. about: as of EvidenceColumns.
  Evidence(const CalibrationProblem& problem, const ParameterSet& parameters, const CandidateList& candidates,
           const PriorMasses& masses, double sigma_dof, const std::function<void(const std::string&)>& progress,
           const Evidence* before = nullptr, const LinearizedAbout& about = {});

  const Robot& robot() const { return problem_.robot(); }
  const LinearizedAbout& about() const { return about_; }
  // The believed ones, where the model is linearized.
  const ParameterSet& parameters() const { return parameters_; }
  const ExplanationList& list() const { return list_; }
  const EvidenceColumns& columns() const { return columns_; }
  const std::deque<ViewedNormal>& views() const { return views_; }
  // Best first; without those below e^-kWorthKeeping of the best, but always with some that hold nothing.
  const std::vector<WeightedModel>& models() const { return models_; }
  const WeightedModel& BestOfNothing() const;
  const NoiseView& ViewOf(const WeightedModel& model) const { return views_[model.view].view; }
  const ProjectedNormal& NormalOf(int view) const { return views_[view].given_believed.normal; }
  // Adds to each model's log weight and sorts them anew.
  void Correct(const std::vector<double>& log_corrections);
  ResidualLikelihood LikelihoodOf(int view) const { return Likelihood(NormalOf(view).dof); }
  ResidualLikelihood Likelihood(double dof) const { return {dof, sigma_dof_, kNoiseIsWrong}; }
  const SetPrior& prior() const { return prior_; }
  const PriorMasses& masses() const { return masses_; }
  // Whether joints deviate by the pose in the model's view, which no effect does: a cause without a name.
  bool FollowsPose(const WeightedModel& model) const { return ViewOf(model).kind == NoiseView::Kind::kPose; }
  SetSearch SearchAmong(const std::vector<Explanation>& explanations, const ProjectedNormal& normal) const {
    return SetSearch(normal, explanations, prior_, Likelihood(normal.dof));
  }
  // Of all explanations given a view.
  SetSearch SearchIn(int view) const { return SearchAmong(list_.math, NormalOf(view)); }
  // A model's set; with other scales than its own where they are given.
  Members MembersOf(const WeightedModel& model, const std::vector<double>* scales = nullptr) const;
  // Coefficients of one member of a model's set and their covariance, in typical sizes, the others estimated too.
  GroupValues ValuesOfMember(const WeightedModel& model, int member) const;
  bool IsSigmaStated() const { return sigma_dof_ > 0.0; }
  // That sigma is not what is stated, in a model; 0 where nothing states it.
  double SigmaIsWrong(const WeightedModel& model) const;
  // Whether the scatter says what sigma is: none is stated, or it is probably wrong.
  bool IsSigmaOpen(const WeightedModel& model) const {
    return !IsSigmaStated() || model.is_sigma_refuted || ViewOf(model).joints_over_sigma != 1.0 ||
           SigmaIsWrong(model) > kEvenOdds;
  }
  // Square of the residual that a model leaves.
  double ResidualOf(const WeightedModel& model) const;

 private:
  struct Trial {
    NoiseView view;
    double log_weight = -std::numeric_limits<double>::infinity();  // there is none
  };
  // In views other than the stated one as long as any is worth it. start: a set near the best one, which says the first
  // of them, because in the noise as stated the best set may hold what is noise; nothing where none is known.
  void ClimbInViews(const std::function<void(const std::string&)>& progress, const WeightedSet& start);
  RowScatter ScatterOf(const NoiseView& view) const;
  ViewedNormal Viewed(const NoiseView& view) const;
  // Of the view, in addition to the set's own.
  double LogPriorOf(const NoiseView& view, const WeightedSet& set) const;
  // Of the set given a view; `sums` are of its few columns alone.
  double LogWeight(const NoiseView& view, const WeightedSet& set, const FewExplanations& few,
                   const RowSums& sums) const;
  // The most likely view in which a part is other than in `base`, which has it as stated.
  Trial BestView(const NoiseView& base, const NoisePart& part, const WeightedSet& set);
  // The most likely view in which sigma is wrong and the joints deviate as stated.
  Trial ViewOfSigmaAlone(const NoiseView& base, const WeightedSet& set);
  // What may be other than in a view.
  std::vector<NoisePart> PartsFor(const NoiseView& view) const;
  void AddGroups(const NoiseView& view, std::vector<NoisePart>* parts) const;
  // The most likely view with one part other than in `view` that is not searched yet.
  Trial BestChange(const NoiseView& view, const WeightedSet& set);
  // The view that is most likely with one of two sets, the model's and nothing; nothing where none is worth a search.
  std::optional<Trial> NextView(const WeightedModel& near);
  // What the best set of another evidence is called here.
  WeightedSet BestOf(const Evidence& other) const;
  // In one more view, from a set; what is best there is added to the models.
  void Climb(ViewedNormal viewed, const WeightedSet& start);
  // All models, by views that are not hopeless: what lies further below the best than is kept is not explored.
  void Explore();
  void AddModel(int view, const WeightedSet& set);
  // Of each model of which members may be pieces of one nameless cause, that reading too.
  void AddReadings();

  const CalibrationProblem problem_;
  const LinearizedAbout about_;
  const ParameterSet parameters_;
  EvidenceColumns columns_;
  ExplanationList list_;
  PriorMasses masses_;
  SetPrior prior_;
  double share_of_pose_ = 0.0;  // of the prior, of a deviation that follows the pose
  double sigma_dof_;
  RowScatter stated_;
  std::deque<ViewedNormal> views_;  // stay where they are
  std::deque<SetSearch> searches_;  // in each view, until all are explored
  std::vector<WeightedModel> models_;
  std::vector<ReadingGroup> groups_;  // that may have noise of their own
  double log_share_of_group_ = 0.0;   // of the prior, of each
  // Log weights of sets in views, by view, members and scales.
  std::map<std::tuple<NoiseSizes, std::vector<int>, std::vector<double>>, double> weights_;
  // Best views with sets, by the view without the part, the part, members and scales: the set of nothing is asked every
  // time.
  std::map<std::tuple<NoiseSizes, NoisePart, std::vector<int>, std::vector<double>>, Trial> tried_;
};

}  // namespace sagitta
