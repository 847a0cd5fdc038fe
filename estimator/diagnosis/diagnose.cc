#include "estimator/diagnosis/diagnose.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/diagnosis/cautions.h"
#include "estimator/diagnosis/holdout_steps.h"
#include "estimator/diagnosis/leading_set.h"
#include "estimator/diagnosis/learnt_model.h"
#include "estimator/diagnosis/noise_check.h"
#include "estimator/diagnosis/scanned_settings.h"
#include "estimator/diagnosis/set_aside.h"
#include "estimator/diagnosis/unstated_rows.h"
#include "estimator/diagnosis/verdict.h"
#include "estimator/evidence/revisits.h"
#include "estimator/report/diagnosis_caution_words.h"
#include "problems/input_error.h"
#include "problems/range.h"
#include "problems/whole_problem.h"

namespace sagitta {
namespace {

// Of the significance: lack of fit is asked in addition to the posterior. With the tenth of the hold-out (gap.cc) the
// two call a complete model incomplete in a quarter of the significance at most (Bonferroni).
constexpr double kShareOfLackOfFit = 0.15;
constexpr double kIntervalMisses = 0.05;  // of the intervals of 95 %: one that holds no effect at all names none
constexpr int kMostPredicted = 5;         // candidates, each refitted by itself: as many as are listed to people
constexpr double kSettledScatter = 0.05;  // of sigma: what a hundred degrees of freedom leave open is more
constexpr int kMostRounds = 3;            // outliers given the believed model, then the extended one, twice

class Session {
 public:
  Session(const CalibrationProblem& problem, const DiagnosisOptions& options, Diagnosis* diagnosis)
      : problem_(problem),
        options_(options),
        joint_(options.joint),
        d_(*diagnosis),
        aside_(options.significance, joint_) {
    joint_.progress = nullptr;
  }

  void Run() {
    Say("fitting the believed model");
    d_.baseline = FitFully(problem_, options_.joint);
    d_.status = d_.baseline.estimate.status;
    d_.message = d_.baseline.estimate.message;
    if (!IsUsable(d_.status)) return;
    WeighPointsAndRotations(problem_, options_.joint, &d_.baseline);
    aside_.FromFitted(&d_.baseline);
    if (options_.points_are_measured) d_.cautions = CautionsOfReadings(*d_.baseline.problem);
    d_.read_first = d_.cautions.size();
    for (const std::string& caution : FindCautions(problem_, d_.baseline)) d_.cautions.push_back(caution);
    Search();
    for (int round = 1; round < kMostRounds && aside_.FollowExtended(d_.final, ExplainsAll(), &d_.baseline); ++round)
      Search();
    JudgeFinal();
    Describe();
    Decide();
  }

 private:
  const Evidence& evidence() const { return *found_.evidence; }
  // The believed model with the noise that goes with the leading set.
  const DiagnosedModel& lacking() const { return found_.refitted.lacking; }
  const WeightedModel& leading() const { return found_.refitted.model; }
  // Of a set that something is missing by.
  const NameSet& LeadingNames() const { return found_.posterior.sets[found_.posterior.Leading(NamingGate())]; }

  void Say(const std::string& words) const {
    if (options_.progress) options_.progress(words);
  }

  bool ExplainsAll() const { return !selected_.empty() && !d_.has_unexplained; }

  void SayFound() const {
    if (!options_.found) return;
    FoundSoFar found;
    for (const SelectedEffect& effect : selected_)
      found.emplace_back(effect.candidate.spec, found_.posterior.Of(evidence().list().name[effect.explanation]));
    options_.found(found);
  }

  // Weighs everything, refits the most probable sets and assumes the leading one.
  void Search() {
    Say("listing what may be missing");
    const bool is_stated = IsSigmaStated(problem_);
    working_ = std::make_unique<CalibrationProblem>(WithWorkingSigma(d_.baseline, is_stated));
    const double sigma_dof = is_stated ? SigmaDof(problem_.repeat_scatter) : 0.0;
    found_ = FindLeading({*working_, d_.baseline, options_.prior, sigma_dof, NamingGate(), joint_, options_.progress},
                         found_.evidence.get());
    d_.not_testable = evidence().list().not_testable;
    selected_ = found_.refitted.effects;
    SayFound();
    d_.final = found_.refitted.with_effects;
    d_.has_unexplained = found_.is_named && (LeadingNames().has_unnamed || found_.posterior.unnamed > kEvenOdds);
    while (!selected_.empty() && !IsUsable(d_.final.estimate.status)) {
      selected_.pop_back();  // the weakest
      d_.has_unexplained = true;
      d_.final = Extend(lacking(), CandidatesOf(selected_), joint_);
    }
    SayFound();
    if (!is_stated && IsUsable(d_.final.estimate.status)) FollowScatter();
  }

  // Where nothing states sigma it is the scatter about what is named, no longer that about the baseline; priors of what
  // is determined poorly weigh less then, so it needs a few rounds.
  void FollowScatter() {
    for (int round = 0; round < kMostScatterRounds && !selected_.empty(); ++round) {
      const Estimate& left = d_.final.estimate;
      if (left.dof <= 0 || !IsUsable(left.status)) return;
      const double factor = std::sqrt(left.chi2 / left.dof);
      if (std::abs(factor - 1.0) < kSettledScatter) return;
      const DiagnosedModel refit = RefitFully(WithScaledSigmas(*lacking().problem, factor), lacking().estimate, joint_);
      if (!IsUsable(refit.estimate.status)) return;
      found_.refitted.lacking = refit;
      d_.final = Extend(lacking(), CandidatesOf(selected_), joint_);
    }
  }

  // Where nothing is missing, odds of B on something come about with probability 1 / B at most (Markov's inequality),
  // and in fact with about the share 1 / B of that: the smallest effects, which have these odds at all, are few.
  double NamingGate() const { return 1.0 - std::sqrt(options_.significance); }

  // The full estimator has the last word: an effect with which it finds no optimum is not named, nor one whose values
  // it finds to be chance (all held: certainly), nor one that makes untouched rows worse beyond chance, nor, given a
  // rest without a name, one that does not make them better beyond chance: the likelihood is known to be wrong then.
  // Nor is one named that the posterior does not name. What more is missing then, with that probability, is a rest.
  void JudgeFinal() {
    Say("fitting the extended model");
    aside_.NextToMoments(SpecsOf(CandidatesOf(selected_)), {&d_.baseline, &found_.refitted.lacking}, &d_.cautions);
    Judge();
    SetHeldOutAside();  // effects are judged by what stays
    Name();
    SetHeldOutAside();
    if (!d_.has_unexplained && HasRest() && Misfits() && AssumeSigmaWrong()) Name();
    if (!selected_.empty() && !d_.has_unexplained && HasRest()) {
      d_.has_unexplained = true;
      Name();  // what untouched rows do not confirm is not named next to a rest
    }
    d_.has_unexplained |= HasRest();
    if (!selected_.empty()) {
      judged_ = d_.final;
      if (d_.has_unexplained && d_.noise.MayFollowThePose()) FollowRepeatability();
      return AllowForRivals();
    }
    judged_ = lacking();
    if (!d_.has_unexplained) return;
    d_.final = d_.baseline;  // the noise that goes with a cause without a name is no better model
    d_.final_p = LackOfFit(problem_, d_.final, {});
  }

  void Judge() {
    d_.final = Extend(lacking(), CandidatesOf(selected_), joint_);
    if (selected_.empty() || !IsUsable(d_.final.estimate.status)) return;
    const ParameterSet aligned = AlignedAs(d_.baseline.estimate.aligned, d_.final.problem->parameters);
    d_.final = JudgeFully(d_.final.problem, d_.final.estimate.parameters, aligned, joint_);
  }

  void SetHeldOutAside() {
    if (!IsUsable(d_.final.estimate.status)) return;
    aside_.FromHeldOut(!found_.is_named, ExplainsAll(), &d_.baseline, &d_.final, &found_.refitted.lacking,
                       steps_.models());
  }

  // Drops what is not named. That the full model does without an effect says that the linear one was wrong about it:
  // nothing is left for that reason.
  void Name() {
    while (!selected_.empty()) {
      const int idle = IsUsable(d_.final.estimate.status) ? DependentOf(LeastSupported()) : -1;
      int out = idle;
      if (out < 0) {
        out = NotNamed();
        if (out >= 0) d_.has_unexplained = true;
      }
      if (out < 0) out = LeastProbable();
      if (out < 0) return;
      num_idle_ += idle >= 0 ? 1 : 0;
      LeaveUnnamed(selected_[out]);
      selected_.erase(selected_.begin() + out);
      steps_.Drop(static_cast<size_t>(out), selected_.size());
      Judge();
      SayFound();
    }
  }

  // Something is left next to what is named, or instead.
  bool HasRest() {
    FindRest();
    if (!selected_.empty()) {
      return Misfits() || found_.posterior.MoreThan(selected_.size() + num_idle_) > NamingGate() ||
             weighed_.unnamed > kEvenOdds;
    }
    // The most probable set may be noise alone, and those that hold a cause more probable together.
    const bool is_sure_of_noise = d_.noise.IsSureOfGroups(NamingGate()) || leading().is_sigma_refuted;
    const bool is_hardly_noise = d_.noise.is_finding && !is_sure_of_noise && found_.posterior.Something() > kEvenOdds;
    // By the noise as stated nothing missing is all but excluded, and something is more probable than other noise.
    const bool is_refuted = !d_.noise.is_finding && found_.posterior.nothing < 1.0 - NamingGate() &&
                            found_.posterior.Something() > kEvenOdds;
    return found_.posterior.MoreThan(num_idle_) > NamingGate() || d_.noise.MayFollowThePose() || is_hardly_noise ||
           is_refuted || Misfits();
  }

  // The rows scatter more than the noise as stated, with all that is named, makes them: what is left is a wrong sigma,
  // where that is more probable than a further cause.
  bool AssumeSigmaWrong() {
    const NoiseView& view = evidence().ViewOf(leading());
    const bool is_sigma_as_stated =
        view.kind != NoiseView::Kind::kPose && view.groups.empty() && !evidence().IsSigmaOpen(leading());
    if (!is_sigma_as_stated || !IsSigmaRefuted(evidence(), LackOfFitLevel())) return false;
    found_.refitted.model.is_sigma_refuted = true;
    const CalibrationProblem scaled = WithNoiseOf(evidence(), leading(), *lacking().problem);
    const DiagnosedModel refit = RefitFully(scaled, lacking().estimate, joint_);
    if (!IsUsable(refit.estimate.status)) return false;
    found_.refitted.lacking = refit;
    steps_ = {};
    Judge();
    return true;
  }
  double LackOfFitLevel() const { return kShareOfLackOfFit * options_.significance; }

  // The noise so far is what is left beyond all that the leading set holds. What is named leaves more: all that is said
  // goes by one noise, that of the final model, by which (NoiseFloor) no figure of the hold-out closes.
  void FollowRepeatability() {
    d_.final = WithOwnRepeatability(judged_, IsSigmaStated(problem_), joint_);
    if (d_.final.problem == judged_.problem) return;
    d_.noise = FindNoise(evidence(), leading(), problem_, d_.final);
    d_.noise.is_of_final = true;
    d_.final_p = kNotKnown;
  }

  int DependentOf(int place) const { return GoesFirst(evidence().list().math, selected_, place); }

  // What the estimate holds is one of the sets that share the probability.
  void AllowForRivals() {
    const double own = LeadingNames().probability;
    d_.choice = ErrorOfChoice(d_.final.estimate, own, found_.rivals);
    const std::vector<std::vector<EffectSpec>> instead = WhatRivalsHold(own, found_.rivals, 1.0 - NamingGate());
    if (!instead.empty()) d_.cautions.push_back(IsOneOfSeveral(instead));
  }

  // Of the selected effects; -1: all hold.
  int NotNamed() {
    if (!IsUsable(d_.final.estimate.status)) return static_cast<int>(selected_.size()) - 1;
    steps_.Measure(lacking(), d_.final, selected_, evidence().list().math, joint_);
    if (const int worse = DependentOf(steps_.Worst()); worse >= 0) return worse;
    if (!d_.has_unexplained) FindRest();  // else there is a rest, whatever the noise is
    return CountHeldOut(d_.final) >= kFewGains && MayLeaveARest() ? LeastConfirmed() : -1;
  }

  // Of those that the posterior does not name.
  int LeastProbable() {
    Weigh();
    const auto is_less = [this](const auto& a, const auto& b) { return ProbabilityOf(a) < ProbabilityOf(b); };
    const auto least = std::min_element(selected_.begin(), selected_.end(), is_less);
    if (weighed_.IsNamed(ProbabilityOf(*least))) return -1;
    return DependentOf(static_cast<int>(least - selected_.begin()));
  }

  // Of those that do not make untouched rows better beyond chance.
  int LeastConfirmed() {
    const std::vector<double> gains = steps_.Gains();
    const size_t least = std::min_element(gains.begin(), gains.end()) - gains.begin();
    VLOG(1) << "diagnosis: " << selected_[least].candidate.spec.Path() << " makes untouched rows better by "
            << gains[least] << " of the scatter of that, the others by more";
    if (IsBeyondChance(gains[least])) return -1;
    const int out = DependentOf(static_cast<int>(least));
    unconfirmed_.push_back(selected_[out]);
    return out;
  }

  // It stays a piece of what has no name.
  void LeaveUnnamed(const SelectedEffect& effect) {
    found_.refitted.model.pieces = EachOnce(leading().pieces, {effect.explanation});
  }

  // The effect whose values the full estimator finds to be chance most; -1: none.
  int LeastSupported() const {
    int least = -1;
    double largest = kIntervalMisses;
    for (size_t k = 0; k < selected_.size(); ++k) {
      const double p = WaldP(selected_[k].candidate.spec, d_.final.estimate);
      if (p <= largest) continue;
      largest = p;
      least = static_cast<int>(k);
    }
    return least;
  }

  void Describe() {
    Say("alternatives and halves");
    Weigh();
    d_.posterior = ReportPosterior(evidence(), found_.posterior, weighed_, options_.prior, NamingGate());
    d_.candidates = Screen(evidence(), d_.baseline);
    d_.screened = evidence().list().NumNamed();
    PredictHoldout(&d_.candidates);
    d_.where = FindWhere(d_.baseline, d_.final.estimate.sigma.estimated);
    d_.effects.resize(selected_.size());
    const std::vector<CheckedEffect> checked =
        CheckEffects(evidence(), weighed_, leading(), InPlacesOfLeading(), ExplanationsOf(selected_));
    double before = HoldoutRms(d_.baseline);
    const std::vector<EffectView> views = ViewEffects(d_.final, SpecsOf(CandidatesOf(selected_)));
    for (size_t k = 0; k < selected_.size(); ++k) {
      FoundEffect& effect = d_.effects[k];
      static_cast<CheckedEffect&>(effect) = checked[k];
      effect.view = views[k];
      DescribeEffect(selected_[k], &effect);
      const DiagnosedModel& here = k + 1 == selected_.size() ? d_.final : steps_.With(k + 1);
      effect.holdout_before = before;
      if (IsUsable(here.estimate.status)) {
        effect.holdout_after = HoldoutRms(here);
        const Estimate& at_one_noise = (k + 1 == selected_.size() ? judged_ : here).estimate;
        effect.reduced_chi2_after = at_one_noise.chi2 / std::max(1, at_one_noise.dof);
      }
      before = effect.holdout_after;
    }
    CautionOfHalves(d_.effects, &d_.cautions);
    CautionOfLookAlikes(problem_, d_.effects, &d_.cautions);
    CautionOfStatedEffects(lacking(), joint_, &d_.effects, &d_.cautions);
    if (found_.is_refuted) d_.cautions.push_back(ProbabilitiesAreRough());
    d_.next = ProposeMeasuring();
    d_.gap_map = MapGap(d_.baseline, d_.final);
    d_.gap = JudgeGap(d_.baseline, d_.final, NoiseFloor(), IsSigmaStated(problem_));
    d_.gap.floor_is_as_stated = IsFloorAsStated() && !selected_.empty();
    if (selected_.empty()) d_.gap.closed = d_.gap.closed_ci95.low = kNotKnown;  // other noise closes nothing
    d_.groups = GroupEffects(d_.effects, lacking(), d_.baseline, d_.final, NoiseFloor(), joint_);
    for (EffectGroup& group : d_.groups) {
      const double probability = sagitta::ProbabilityOf(group.effect, evidence(), weighed_models_);
      if (probability > 0.0) group.probability = probability;  // else a group of several effects
    }
  }

  // What does not follow the pose only a second visit shows.
  std::optional<NextPoses> ProposeMeasuring() const {
    const ParameterSet& parameters = d_.baseline.estimate.parameters;
    if (!d_.noise.MayFollowThePose()) return ProposeNext(evidence(), *working_, parameters);
    return ProposeRevisits(WithNoiseOf(evidence(), leading(), *working_), parameters);
  }

  // What effects are said to be: given a rest without a name the poses as they are would make it too sure.
  void Weigh() {
    if (weighed_models_.empty()) {
      weighed_models_ = evidence().models();
      weighed_ = found_.posterior;
    }
    if (is_bagged_ || !found_.is_named || !MayLeaveARest()) return;
    is_bagged_ = true;
    weighed_models_ = BaggedModels(evidence(), leading(), Groups());
    if (weighed_models_.size() == evidence().models().size()) return;  // poses are too few
    d_.cautions.push_back(AreBagged(kResamples));
    weighed_ = PosteriorOf(evidence(), weighed_models_);
  }

  double ProbabilityOf(const SelectedEffect& effect) const {
    return weighed_.Of(evidence().list().name[effect.explanation]);
  }

  const std::vector<std::vector<NamedProbability>>& InPlacesOfLeading() {
    if (in_places_.empty()) in_places_ = InPlaces(evidence(), leading());
    return in_places_;
  }

  const PoseGroups& Groups() {
    if (!groups_) groups_ = std::make_unique<PoseGroups>(evidence(), leading(), InPlacesOfLeading());
    return *groups_;
  }

  // Of the first candidates that have a share of the probability: each alone with the believed model.
  void PredictHoldout(std::vector<ScreenedCandidate>* candidates) const {
    if (d_.baseline.problem->ValidationObservations().empty()) return;
    int count = 0;
    for (ScreenedCandidate& entry : *candidates) {
      if (count == kMostPredicted) return;
      if (weighed_.Of(evidence().list().name[entry.explanation]) < kWorthListing) continue;
      ++count;
      const WeightedModel alone = Alone(evidence(), leading().view, entry.explanation);
      const DiagnosedModel with =
          Extend(lacking(), CandidatesOf(SelectedEffectsOf(evidence(), alone, lacking())), joint_);
      if (IsUsable(with.estimate.status)) entry.holdout_rms = HoldoutRms(with);
    }
  }

  void DescribeEffect(const SelectedEffect& chosen, FoundEffect* described) const {
    FoundEffect& effect = *described;
    effect.candidate = chosen.candidate;
    effect.probability = ProbabilityOf(chosen);
    effect.reduction = chosen.fit.reduction;
    const Estimate &after = judged_.estimate, &final = d_.final.estimate;
    // The reduction is in units of the evidence's rows, the refit may have other sigmas.
    const double unit = UnitOfRows(evidence(), leading());
    effect.corrected_p =
        CorrectedP(chosen.fit.reduction, chosen.fit.parameters, unit * after.chi2 / std::max(1, after.dof), after.dof,
                   evidence().IsSigmaStated(), d_.screened);
    effect.parameters = ParameterRowsOf(chosen.candidate.spec, final);
    effect.bounds = PhysicalBoundsOf(d_.final, chosen.candidate.spec, effect.parameters);
    effect.numbers = AllowForSetting(d_.final, chosen.candidate.spec, &effect.parameters);
  }

  // What the noise has to be with the final model, and how well that fits then.
  void FindRest() {
    d_.noise = FindNoise(evidence(), leading(), problem_, d_.final);
    d_.final_p = LackOfFit(problem_, d_.final, d_.noise);
  }

  // Whether the noise or untouched rows say that something is left. This and the following after FindRest.
  bool Misfits() const {
    const bool is_stated = IsSigmaStated(problem_);
    return (is_stated && d_.final_p < LackOfFitLevel()) || IsFarFromFloor(d_.final, is_stated, options_.significance);
  }

  // m. A deviation of the joints that may be an error which follows the pose is no noise: it would close the gap by
  // being called noise.
  double NoiseFloor() const { return (IsFloorAsStated() ? d_.baseline : d_.final).estimate.noise_floor; }
  bool IsFloorAsStated() const {
    return IsSigmaStated(problem_) && (d_.noise.MayFollowThePose() || evidence().FollowsPose(leading()));
  }

  // Where untouched rows get no better at all, what was found is at most a part of it, too. Once steps are
  // measured, where anything is selected.
  bool MayLeaveARest() const {
    return d_.has_unexplained || d_.noise.MayFollowThePose() ||
           (!selected_.empty() && HoldoutRms(d_.final) >= HoldoutRms(steps_.With(0)));
  }

  void SetMayFollowThePose(DiagnosedModel* model) const {
    if (!d_.noise.MayFollowThePose() || model->problem == d_.baseline.problem) return;  // which has what is stated
    model->problem = std::make_shared<CalibrationProblem>(*model->problem);
    model->problem->latent.may_follow_pose = true;
  }

  void Decide() {
    NameLeftOut(d_.final, aside_.outliers(), &d_.noise);
    d_.noise.outliers_held_out = aside_.held_out();
    d_.baseline_p = LackOfFit(problem_, d_.baseline, {});
    if (d_.has_unexplained) {
      d_.unexplained = LearnFunction(evidence(), found_.posterior, leading(), *lacking().problem);
      Say("learning what has no name");
      auto learnt = LearnModel(evidence(), leading(), Groups(), d_.baseline, judged_, joint_);
      if (learnt) SetMayFollowThePose(&learnt->model);
      if (learnt) d_.learnt = std::make_shared<LearntModel>(*std::move(learnt));
      if (d_.learnt && problem_.ValidationObservations().empty()) d_.cautions.push_back(LearntUnchecked());
    }
    SetMayFollowThePose(&d_.final);
    d_.noise.is_bound = d_.has_unexplained;
    const bool is_noise = d_.noise.is_finding || !d_.noise.outliers.empty();
    d_.verdict = VerdictOf(!selected_.empty(), d_.has_unexplained, is_noise);
    std::vector<std::pair<EffectSpec, double>> unconfirmed;
    for (const SelectedEffect& effect : unconfirmed_)
      unconfirmed.emplace_back(effect.candidate.spec, ProbabilityOf(effect));
    if (!unconfirmed.empty()) d_.cautions.push_back(NotConfirmed(problem_.robot(), unconfirmed));
    CautionOfNotNamed(unconfirmed, &d_);
    CautionOfHoldout(d_.final, d_.has_unexplained, IsSigmaStated(problem_), options_.significance, &d_.cautions);
  }

  const CalibrationProblem& problem_;
  const DiagnosisOptions& options_;
  JointOptions joint_;
  Diagnosis& d_;
  SetAside aside_;
  std::unique_ptr<CalibrationProblem> working_;  // what the evidence is made of
  LeadingSet found_;
  Posterior weighed_;                          // of weighed_models_
  std::vector<WeightedModel> weighed_models_;  // the evidence's models, or averaged over resamples
  bool is_bagged_ = false;
  size_t num_idle_ = 0;    // effects that the full model does without
  DiagnosedModel judged_;  // the same with what is named
  std::vector<std::vector<NamedProbability>> in_places_;
  std::unique_ptr<PoseGroups> groups_;
  std::vector<SelectedEffect> selected_, unconfirmed_;  // named; what untouched rows do not confirm
  HoldoutSteps steps_;                                  // of the selected effects
};

}  // namespace

void CheckOptions(const DiagnosisOptions& options) {
  CheckIn(allowed::kLevel, options.significance, "DiagnosisOptions.significance");
  CheckIn(allowed::kProbability, options.prior.nothing, "DiagnosisOptions.prior.nothing");
  CheckIn(allowed::kProbability, options.prior.catalogue, "DiagnosisOptions.prior.catalogue");
  CheckIn(allowed::kProbability, options.prior.unnamed, "DiagnosisOptions.prior.unnamed");
  CheckIn(allowed::kProbability, options.prior.further, "DiagnosisOptions.prior.further");
  if (!options.prior.SumToOne()) throw InputError({"", 0, "DiagnosisOptions.prior"}, kMassesDoNotSum);
  CheckOptions(options.joint);
}

Diagnosis Diagnose(const CalibrationProblem& problem, const DiagnosisOptions& options) {
  CheckOptions(options);
  CheckIsWhole(problem, "Diagnose");
  Diagnosis diagnosis;
  std::vector<std::string> left_out;
  const auto stated = WithoutUnstatedRows(problem, &left_out);
  Session(stated ? *stated : problem, options, &diagnosis).Run();
  const auto others = diagnosis.cautions.begin() + static_cast<long>(diagnosis.read_first);
  diagnosis.cautions.insert(others, left_out.begin(), left_out.end());
  return diagnosis;
}

}  // namespace sagitta
