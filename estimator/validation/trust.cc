#include "estimator/validation/trust.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "estimator/agreement/breaks.h"
#include "estimator/calibration/bounds.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/inspection/data_lint.h"
#include "estimator/inspection/explained_errors.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/intervals/predicted_sums.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/normal_equations.h"
#include "estimator/least_squares/row_stream.h"
#include "estimator/least_squares/sample.h"
#include "estimator/noise/repeat_spread.h"
#include "estimator/report/validation_words.h"
#include "estimator/statistics/distributions.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

// Share by which errors differ before one is called better: of a hundred points an RMS is known to some 5 %.
constexpr double kBetterRobot = 0.05;
// Times that points fit worse than by equal weights before these are wrong: weights that are right hardly lose.
constexpr double kWrongWeights = 2.0;
constexpr double kSamePose = 1e-3;  // rad or m, of every joint: what points show there they show at the other too

// Root R of what parameters leave open: [J H] R = [J root(C), K root(S)], K = H + J G (prediction.h), H of the held.
Eigen::MatrixXd RootWithHeld(const Estimate& estimate) {
  const Eigen::MatrixXd of_estimated = RootOf(estimate.covariance), of_held = RootOf(estimate.held.second_moment);
  const Eigen::Index n = of_estimated.rows(), h = of_held.rows();
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(n + h, of_estimated.cols() + of_held.cols());
  root.topLeftCorner(n, of_estimated.cols()) = of_estimated;
  if (h == 0) return root;
  root.topRightCorner(n, of_held.cols()) = estimate.held.slopes * of_held;
  root.bottomRightCorner(h, of_held.cols()) = of_held;
  return root;
}

UnseenPoints JudgeHoldout(const CalibrationProblem& problem, const Estimate& estimate) {
  const std::vector<int> observations = problem.data().PointsAmong(problem.ValidationObservations());
  UnseenPoints holdout = MeasureUnseen(
      problem, observations, ResidualsOf(problem.data(), observations, estimate.predicted(Eigen::all, observations)));
  const std::optional<PredictedSquares> predicted = PredictedOfHoldout(problem, estimate);
  if (predicted) ComparePrediction(*predicted, estimate, &holdout, DofOfSizes(problem.repeat_scatter));
  return holdout;
}

// Aligned to the calibration rows alone.
UnseenPoints NominalOnHoldout(const CalibrationProblem& problem, const Estimate& estimate) {
  if (estimate.predicted_aligned.cols() == 0) return {};
  const std::vector<int> points = problem.data().PointsAmong(problem.ValidationObservations());
  return MeasureUnseen(problem, points,
                       ResidualsOf(problem.data(), points, estimate.predicted_aligned(Eigen::all, points)));
}

// By what model error widens one coordinate: its standard deviation and its interval.
struct Widening {
  double sigma = 1.0;
  double interval = 1.0;
};

// s^2 + t^2 in place of s^2, t^2 = `between` with `draws` degrees of freedom, s^2 = `noise` with `dof`; Student's t
// with the degrees of freedom of the sum.
Widening BetweenPartsWiden(double noise, double dof, double between, double draws) {
  if (!(between > 0.0 && noise > 0.0 && draws > 0.0)) return {};
  const double together = WelchDof(noise, dof, between, draws);
  Widening widening;
  widening.sigma = std::sqrt(1.0 + between / noise);
  widening.interval = widening.sigma * StudentQuantile(kUpperOf95, together) / StudentQuantile(kUpperOf95, dof);
  return widening;
}

// However much parts contradict each other, a parameter is no less known than its effect's prior has it.
double WithinPrior(const Estimate& estimate, size_t p) {
  const double prior = estimate.parameters.coordinates()[estimate.estimated[p]].effect_prior;
  const auto i = static_cast<Eigen::Index>(p);
  return prior > 0.0 ? std::max(1.0, prior / std::sqrt(estimate.covariance(i, i))) : kInfinity;
}

// One per estimated coordinate. What no parts determine is widened like the median of the others.
std::vector<Widening> WideningsOf(const Estimate& estimate, const BetweenParts& between, double excess) {
  std::vector<Widening> all(estimate.estimated.size());
  std::vector<double> sigmas, intervals;
  for (size_t p = 0; between.known() && p < all.size(); ++p) {
    const auto i = static_cast<Eigen::Index>(p);
    if (!(between.draws[i] > 0.0)) continue;
    const double noise = estimate.covariance(i, i), dof = estimate.interval_dof[i];
    all[p] = BetweenPartsWiden(noise, dof, between.variance[i], between.draws[i]);
    sigmas.push_back(all[p].sigma);
    intervals.push_back(all[p].interval);
  }
  for (size_t p = 0; p < all.size(); ++p) {
    const bool is_known = !between.known() || between.draws[static_cast<Eigen::Index>(p)] > 0.0;
    if (!is_known && !sigmas.empty()) all[p] = {Median(sigmas), Median(intervals)};
    const double most = WithinPrior(estimate, p);
    all[p].sigma = std::min(std::max(all[p].sigma, excess), most);
    all[p].interval = std::min(std::max(all[p].interval, excess), most);
  }
  return all;
}

// How much points that were not fitted are off beyond what was predicted for them, and which.
ExcessOf FindExcess(double significance, Trust* trust) {
  ExcessOf found = ExcessOf::kNone;
  const auto take = [&](const UnseenPoints& unseen, ExcessOf of) {
    if (!(unseen.points > 0 && unseen.p_value < significance && unseen.Excess() > trust->excess)) return;
    trust->excess = unseen.Excess();
    found = of;
  };
  take(trust->holdout, ExcessOf::kHoldout);
  take(trust->cross_validation.unseen, ExcessOf::kCrossValidation);
  return found;
}

// Medians of the widenings, and words where any interval is wider.
void SayModelError(const Estimate& estimate, const std::vector<Widening>& widenings, ExcessOf excess, Trust* trust) {
  if (widenings.empty()) return;
  const auto at = std::max_element(widenings.begin(), widenings.end(),
                                   [](const Widening& a, const Widening& b) { return a.interval < b.interval; });
  if (!(at->interval > 1.0)) return;
  std::vector<double> sigmas, intervals;
  for (const Widening& widening : widenings) {
    sigmas.push_back(widening.sigma);
    intervals.push_back(widening.interval);
  }
  trust->model_error_sigma = Median(sigmas);
  trust->model_error = Median(intervals);
  const auto& name = estimate.parameters.coordinates()[estimate.estimated[at - widenings.begin()]].name;
  trust->model_error_words = ModelErrorInWords(trust->model_error, at->interval, name, trust->between.reason, excess);
}

void WidenIntervals(const std::vector<Widening>& widenings, Trust* trust, Estimate* estimate) {
  for (const ParameterEstimate& row : estimate->table) {
    trust->sigma.push_back(row.sigma);
    trust->ci95_noise_only.push_back(row.ci95);
  }
  for (size_t p = 0; p < widenings.size(); ++p) {
    const int i = estimate->estimated[p];
    ParameterEstimate& row = estimate->table[i];
    const double lower = estimate->parameters.coordinates()[i].lower, factor = widenings[p].interval;
    if (factor == 1.0) continue;
    trust->sigma[i] *= widenings[p].sigma;
    // What held ones add is as large as before: a_u'^2 = a_u^2 + (f^2 - 1) a^2 of each arm.
    const double more = factor * factor - 1.0, spread = widenings[p].sigma * row.sigma;
    Interval &own = row.ci95, &unconditional = row.unconditional_ci95;
    const auto grown = [more](double all, double arm) { return std::sqrt(all * all + more * arm * arm); };
    unconditional = {std::max(lower, row.value - grown(row.value - unconditional.low, row.value - own.low)),
                     row.value + grown(unconditional.high - row.value, own.high - row.value)};
    own = {std::max(lower, row.value - factor * (row.value - own.low)), row.value + factor * (own.high - row.value)};
    row.unconditional_sigma =
        std::sqrt(row.unconditional_sigma * row.unconditional_sigma + spread * spread - row.sigma * row.sigma);
    row.at_bound |= row.ci95.low <= lower;
  }
}

void AddModelError(double significance, Trust* trust, Estimate* estimate) {
  const ExcessOf excess = FindExcess(significance, trust);
  const std::vector<Widening> widenings = WideningsOf(*estimate, trust->between, trust->excess);
  SayModelError(*estimate, widenings, excess, trust);
  WidenIntervals(widenings, trust, estimate);
}

// Times by which the points fit worse than with equal weights and without priors. Where these are wrong, the fit goes
// by some rows alone. Values on their bounds stay there: what lies beyond is no better fit.
double WorseThanByEqualWeights(const CalibrationProblem& problem, const Estimate& estimate) {
  if (!estimate.sigma.stated || !problem.weight_roots.empty()) return 1.0;
  std::vector<int> columns = MovingColumns(estimate);
  const std::vector<int> points = problem.data().PointsAmong(problem.CalibrationObservations());
  const std::vector<int> sample = SampleForStep(problem.data(), points, columns.size());
  const NoiseRoots metres(sample.size(), Matrix3<double>::Identity());
  const auto linearize = [&] {
    return Linearize(problem, estimate.parameters, sample, columns, metres, LatentTreatment::kIgnore);
  };
  Linearization rows = linearize();
  // How a marker is turned, points do not say.
  std::vector<int> seen;
  for (int c = 0; rows.valid && c < rows.num_columns(); ++c) {
    if (!rows.jacobian.col(c).isZero(0.0)) seen.push_back(columns[static_cast<size_t>(c)]);
  }
  if (seen.size() < columns.size() && !seen.empty()) columns = seen, rows = linearize();
  if (!rows.valid || rows.num_rows() <= rows.num_columns()) return 1.0;
  const LinearSolution solution = SolveLinearization(rows);
  const double freedom = rows.num_rows() - rows.num_columns();
  const double equal = solution.residual_norm_squared / freedom;
  if (!solution.full_rank || !(equal > 0.0)) return 1.0;
  return std::sqrt(rows.residual.squaredNorm() / rows.num_rows() / equal);
}

// What the data want farthest below its physical bound, by noise and model error; nothing: nothing by far.
std::optional<BelowBound> LowestBelowBound(const CalibrationProblem& problem, const Estimate& estimate,
                                           double model_error) {
  const auto rests = [&](int i) { return RestsOnBound(estimate.parameters, i); };
  if (std::none_of(estimate.estimated.begin(), estimate.estimated.end(), rests)) return std::nullopt;
  const auto roots = [&](const std::vector<int>& listed) { return FitRoots(problem, listed, kFallbackSigma); };
  const FittedRows fitted =
      FittedOnce(problem, estimate.parameters, problem.CalibrationObservations(), estimate.estimated, roots);
  const double least = estimate.sigma.stated ? model_error : 0.0;
  const std::vector<BelowBound> found =
      FindBelowBounds(fitted.rows, estimate.parameters, model_error * AppliedNoise(estimate.sigma), least);
  if (found.empty()) return std::nullopt;
  return *std::max_element(found.begin(), found.end(),
                           [](const BelowBound& a, const BelowBound& b) { return a.sigmas < b.sigmas; });
}

// Configurations that are held out where a fitted one stands.
int HeldOutWhereFitted(const CalibrationProblem& problem, int* all) {
  std::set<int> fitted, held_out;
  const auto configuration = [&](int i) {
    return problem.data().shots[problem.data().observations[i].shot].configuration;
  };
  for (const int i : problem.ValidationObservations()) held_out.insert(configuration(i));
  const auto joints = [&](int c) -> const Eigen::VectorXd& { return problem.data().configurations[c].q; };
  *all = static_cast<int>(held_out.size());
  if (held_out.empty()) return 0;
  for (const int i : problem.CalibrationObservations()) fitted.insert(configuration(i));
  std::multimap<double, int> by_sum;  // equal poses have sums that are close
  for (const int c : fitted) by_sum.emplace(joints(c).sum(), c);
  const double reach = kSamePose * problem.robot().num_joints();
  return static_cast<int>(std::count_if(held_out.begin(), held_out.end(), [&](int c) {
    const double sum = joints(c).sum();
    return std::any_of(by_sum.lower_bound(sum - reach), by_sum.upper_bound(sum + reach), [&](const auto& other) {
      return (joints(other.second) - joints(c)).cwiseAbs().maxCoeff() < kSamePose;
    });
  }));
}

// Torques that the model lacks bend the arm: what gives way to those it knows, or their mass, comes out wrong by them.
bool LoadsDriveUnknowns(const CalibrationProblem& problem, const Estimate& estimate) {
  if (problem.experiment().torques_measured) return false;
  return std::any_of(estimate.table.begin(), estimate.table.end(), [](const ParameterEstimate& row) {
    return row.free && (CoordinateKindOf(row.name) == CoordinateKind::kCompliance || row.quantity == Quantity::kMass);
  });
}

// Worse than the nominal robot, though within what is uncertain, and more of it is of the parameters than of the
// readings.
bool LosesByFewPoses(const Trust& trust) {
  return trust.nominal.points > 0 && trust.gain.compared == Compared::kWithinUncertainty &&
         trust.gain.ratio < 1.0 - kBetterRobot && trust.Quoted().parameters_share > 0.5;
}

std::string WhyNothingChecks(const CrossValidation& cross_validation) {
  if (cross_validation.not_run) return NothingChecksTheMethod();
  return cross_validation.unpredictable.points > 0 ? NothingIsPredictable() : NothingChecksIt();
}

std::vector<std::string> ReasonsAgainst(const CalibrationProblem& problem, const Estimate& estimate,
                                        const Trust& trust) {
  std::vector<std::string> reasons;
  const UnseenPoints& quoted = trust.Quoted();
  if (quoted.points == 0) reasons.push_back(WhyNothingChecks(trust.cross_validation));
  int held_out = 0;
  const int seen = HeldOutWhereFitted(problem, &held_out);
  if (2 * seen > held_out) reasons.push_back(HeldOutIsFitted(seen, held_out));
  for (const UnseenPoints* unseen : {&trust.holdout, &trust.cross_validation.unseen}) {
    if (unseen->points == 0 || unseen->p_mostly_unknown >= problem.experiment().significance) continue;
    reasons.push_back(PredictionIsOff(unseen == &trust.holdout, unseen->Excess(), unseen->p_value));
  }
  if (trust.gain.compared == Compared::kWorse) reasons.push_back(WorseThanNominal(trust.nominal.distance_rms));
  if (LosesByFewPoses(trust)) reasons.push_back(PosesAreTooFew(trust.nominal.distance_rms, quoted.distance_rms));
  if (estimate.dof <= 0) reasons.push_back(NoRedundancy());
  if (estimate.dof > 0 && estimate.fit.rms < kBelowAnyInstrument) {
    reasons.push_back(BelowAnyInstrument(estimate.fit.rms));
  }
  if (!trust.suspects.empty()) {
    reasons.push_back(RowsAreSuspect(trust.suspects.size(), trust.suspects[0].row));
  }
  if (const std::optional<BelowBound> lowest = LowestBelowBound(problem, estimate, trust.model_error_sigma)) {
    const std::string& name = estimate.parameters.coordinates()[lowest->coordinate].name;
    reasons.push_back(ComesOutNegative(name, lowest->sigmas, problem.experiment().torques_measured));
  }
  if (LoadsDriveUnknowns(problem, estimate)) {
    const std::vector<ScaledTorque> off = TorquesOffByAFactor(trust.torques, problem.experiment().significance);
    if (!off.empty()) {
      reasons.push_back(TorquesAreOthers(problem.robot().chain.joints[off[0].joint].name, off[0].slope, off.size()));
    }
  }
  const std::vector<PriorConflict> priors = PriorsAgainstRows(problem, estimate);
  if (!priors.empty()) reasons.push_back(RowsContradictPrior(estimate.parameters, priors[0], priors.size()));
  const double worse = WorseThanByEqualWeights(problem, estimate);
  if (worse > kWrongWeights && priors.empty()) reasons.push_back(WeightsAreWrong(worse));
  // What is held for noise that is stated far too large is left in the residuals, and looks like a move.
  std::optional<Break> moved;
  if (StatedTooLarge(estimate) == 1.0) moved = FindBreak(problem, estimate);
  if (moved) reasons.push_back(SomethingMoved(problem, *moved));
  if (estimate.fit.distance_rms > SuspiciousMisfit(problem)) {
    reasons.push_back(RobotStillMisses(estimate.fit.distance_rms, !trust.suspects.empty()));
  }
  if (trust.across) reasons.push_back(WeightsPullAcross(trust.across->angle));
  return reasons;
}

// Stated standard deviations that the residuals refute, joints that never moved, and the errors that no arm is made or
// mastered with: an interval wholly beyond.
std::vector<std::string> LimitsOf(const CalibrationProblem& problem, const Estimate& estimate) {
  std::vector<std::string> limits;
  const SigmaReport& sigma = estimate.sigma;
  const bool is_refuted = !sigma.IsOfResiduals() && sigma.scaled && sigma.p_value < problem.experiment().significance;
  if (is_refuted && estimate.noise_report.components.empty())
    limits.push_back(ResidualsRefuteNoise(sigma.a_posteriori, sigma.origin == NoiseOrigin::kRepeats));
  for (const MeasuredRange& range : StillJointsOf(problem)) {
    limits.push_back(JointWasNotMeasured(problem.robot().chain.joints[range.joint], range.least, range.most));
  }
  for (const ParameterEstimate& row : estimate.table) {
    const bool is_length = row.quantity == Quantity::kLength;
    const double size = is_length ? kErrorLength : kErrorAngle;
    const double least = std::min(std::abs(row.ci95.low - row.nominal), std::abs(row.ci95.high - row.nominal));
    const bool is_beyond = std::abs(row.value - row.nominal) > size && least > size;
    if (CoordinateKindOf(row.name) != CoordinateKind::kGeometry || !row.identifiable || !is_beyond) continue;
    limits.push_back(CorrectionIsLarge(row.name, row.value - row.nominal, is_length));
  }
  return limits;
}

}  // namespace

std::optional<PredictedSquares> PredictedOfHoldout(const CalibrationProblem& problem, const Estimate& estimate) {
  const std::vector<int> observations = problem.data().PointsAmong(problem.ValidationObservations());
  if (observations.empty()) return std::nullopt;
  std::vector<int> columns = estimate.estimated;
  columns.insert(columns.end(), estimate.held.coordinates.begin(), estimate.held.coordinates.end());
  PredictedSums sums(static_cast<int>(columns.size()));
  const RowStream stream = StreamOfArrivals(problem, observations);
  const bool valid = stream.ForEach(estimate.parameters, columns, [&](const RowPiece& piece) {
    ForEachArrival(
        problem, piece, observations, [](int) { return true; },
        [&](const std::vector<int>& positions, const RowMajorMatrix& jacobian, const Eigen::MatrixXd& latent) {
          std::vector<int> listed;
          for (const int k : positions) listed.push_back(observations[k]);
          sums.AddArrival(InstrumentOf(estimate, listed), jacobian, TimesStated(estimate) * latent);
        });
  });
  if (!valid) return std::nullopt;
  return sums.Squares(RootWithHeld(estimate));
}

Trust JudgeTrust(const CalibrationProblem& problem, const FittedStream& fitted, const FoldPlan& folds,
                 Estimate* estimate, const BetweenParts& between) {
  Trust trust;
  trust.between = between;
  trust.suspects = FindSuspects(problem, *estimate, &fitted);
  trust.cross_validation = CrossValidate(problem, fitted, *estimate, folds);
  trust.holdout = JudgeHoldout(problem, *estimate);
  const std::vector<int> quoted =
      trust.holdout.points > 0 ? problem.ValidationObservations() : problem.CalibrationObservations();
  trust.noise = ShareOfNoise(*estimate, problem.data().PointsAmong(quoted), trust.Quoted());
  // What joints deviate by at an arrival is part of it.
  if (!problem.latent.empty() && !problem.latent.may_follow_pose) trust.noise.beyond_noise = 0.0;
  trust.repeatability = MeasurePoseRepeatability(problem);
  trust.nominal = trust.holdout.points > 0 ? NominalOnHoldout(problem, *estimate) : trust.cross_validation.nominal;
  trust.gain = CompareRms(trust.nominal, trust.Quoted(), problem.experiment().significance, kBetterRobot);
  AddModelError(problem.experiment().significance, &trust, estimate);
  trust.across = FindLoadDirection(problem);
  trust.torques = CompareTorques(problem, estimate->parameters);
  trust.verdict.reasons = ReasonsAgainst(problem, *estimate, trust);
  trust.verdict.trusted = trust.verdict.reasons.empty();
  trust.limits = LimitsOf(problem, *estimate);
  trust.verdict.words =
      VerdictInWords(trust, problem.experiment().significance, kBetterRobot, LeftOpen(*estimate).size());
  const double too_large = StatedTooLarge(*estimate);
  if (too_large > 1.0) {
    trust.verdict.words = StatedNoiseIsTooLarge(too_large, estimate->fit.rms) + " " + trust.verdict.words;
  }
  return trust;
}

Trust JudgeByHoldout(const CalibrationProblem& problem, Estimate* estimate) {
  Trust trust;
  trust.holdout = JudgeHoldout(problem, *estimate);
  // Where the residuals refute the stated noise, the scale that makes it fit them holds what the estimate lacks.
  UnseenPoints as_stated = trust.holdout;
  if (estimate->sigma.stated && estimate->sigma.scaled)
    as_stated.predicted_rms /= std::max(1.0, estimate->sigma.a_posteriori);
  trust.noise.beyond_noise =
      problem.latent.may_follow_pose
          ? BeyondInstrument(*estimate, problem.data().PointsAmong(problem.ValidationObservations()), trust.holdout)
          : BeyondScatter(as_stated);
  AddModelError(problem.experiment().significance, &trust, estimate);
  return trust;
}

}  // namespace sagitta
