#include "estimator/validation/trust.h"

#include <algorithm>
#include <cmath>

#include "estimator/inspection/reading_lint.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/row_stream.h"
#include "estimator/least_squares/row_sums.h"
#include "estimator/statistics/distributions.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// m per coordinate: interferometric length measurement in a workshop is not better (1 um and more per metre), and no
// industrial arm returns to a point within it.
constexpr double kBelowAnyInstrument = 1e-6;
constexpr double kBetter = 1.0;

std::string Millimetres(double metres) { return Significant(1e3 * metres, 3) + " mm"; }

Eigen::Matrix3Xd Errors(const CalibrationProblem& problem, const ParameterSet& parameters,
                        const std::vector<int>& observations) {
  const Eigen::Matrix3Xd predicted = PredictPoints(problem, parameters, observations);
  Eigen::Matrix3Xd errors(3, predicted.cols());
  for (Eigen::Index k = 0; k < predicted.cols(); ++k)
    errors.col(k) = problem.data.observations[observations[k]].point_in_station - predicted.col(k);
  return errors;
}

UnseenPoints JudgeHoldout(const CalibrationProblem& problem, const Estimate& estimate) {
  const std::vector<int> observations = problem.data.PointsAmong(problem.ValidationObservations());
  UnseenPoints holdout = MeasureUnseen(problem, observations, Errors(problem, estimate.parameters, observations));
  if (observations.empty()) return holdout;
  const auto metres = [](const std::vector<int>& listed) {
    return NoiseRoots(listed.size(), Matrix3<double>::Identity());
  };
  const auto columns = static_cast<int>(estimate.estimated.size());
  PredictedSums sums(columns);
  const RowStream stream(problem, observations, metres, LatentTreatment::kIgnore);
  const bool valid = stream.ForEach(estimate.parameters, estimate.estimated, [&](const RowPiece& piece) {
    std::vector<int> listed;
    for (const int k : piece.positions) listed.push_back(observations[k]);
    const NoiseRoots scatter = ScatterOf(estimate, listed);
    for (int i = 0; i < piece.num_observations(); ++i) sums.Add(scatter[i], piece.rows.block(3 * i, 0, 3, columns));
  });
  if (!valid) return holdout;
  const PredictedSquares predicted = sums.Squares(RootOf(estimate.covariance));
  ComparePrediction(predicted, estimate, &holdout);
  return holdout;
}

// What parts of the data ask for, as the spread of a model error of which each split is one draw: Student's t with as
// many degrees of freedom as there are splits, instead of the normal quantile.
double FactorBetweenParts(const AgreementReport& agreement) {
  const auto splits = std::count_if(agreement.splits.begin(), agreement.splits.end(),
                                    [](const PartComparison& split) { return split.by != "random"; });
  const auto draws = std::max(1.0, static_cast<double>(splits));
  return agreement.inflation * StudentQuantile(0.975, draws) / NormalQuantile(0.975);
}

// The largest of what was found; its reason in one line.
void JudgeModelError(const Estimate& estimate, double significance, Trust* trust) {
  const auto take = [trust](double factor, const std::string& words) {
    if (!(factor > trust->model_error)) return;
    trust->model_error = factor;
    trust->model_error_words = words;
  };
  if (estimate.agreement.disagrees)
    take(FactorBetweenParts(estimate.agreement), "parts of the data contradict each other");
  const auto excess = [&](const UnseenPoints& unseen, const char* name) {
    if (unseen.points > 0 && unseen.p_value < significance)
      take(unseen.Excess(), std::string(name) + " larger than predicted");
  };
  excess(trust->holdout, "errors on the points held out are");
  excess(trust->cross_validation.unseen, "errors in the cross-validation are");
  if (trust->model_error > 1.0) {
    trust->model_error_words = "the intervals are " + Significant(trust->model_error, 2) +
                               " times as wide as noise alone would make them: " + trust->model_error_words +
                               "; 'sagitta diagnose' may find why";
  }
}

void Widen(Trust* trust, Estimate* estimate) {
  const auto widen = [&](double value, double lower, Interval* interval) {
    interval->low = std::max(lower, value - trust->model_error * (value - interval->low));
    interval->high = value + trust->model_error * (interval->high - value);
  };
  for (size_t i = 0; i < estimate->table.size(); ++i) {
    ParameterEstimate& row = estimate->table[i];
    trust->ci95_noise_only.push_back(row.ci95);
    if (trust->model_error == 1.0 || !row.free) continue;
    const double lower = estimate->parameters.coordinates()[i].lower;
    widen(row.value, lower, &row.ci95);
    widen(row.value, lower, &row.unconditional_ci95);
    row.at_bound |= row.ci95.low <= lower;
  }
}

std::vector<std::string> ReasonsAgainst(const CalibrationProblem& problem, const Estimate& estimate,
                                        const Trust& trust) {
  std::vector<std::string> reasons;
  const UnseenPoints& quoted = trust.Quoted();
  if (quoted.points == 0) reasons.push_back("nothing checks it: too few configurations to set any aside");
  if (trust.holdout.points > 0 && trust.holdout.p_value < problem.experiment.significance) {
    reasons.push_back("the errors on the points held out are " + Significant(trust.holdout.Excess(), 2) +
                      " times what the estimate predicted for them (p = " + Significant(trust.holdout.p_value, 2) +
                      ")");
  }
  if (quoted.points > 0 && trust.nominal.distance_rms < kBetter * quoted.distance_rms)
    reasons.push_back("on points that it has not seen it is no better than the nominal robot");
  if (estimate.dof <= 0) reasons.push_back("there are as many unknowns as readings: the data cannot check themselves");
  if (estimate.dof > 0 && estimate.fit.rms < kBelowAnyInstrument) {
    reasons.push_back("residuals of " + Significant(1e6 * estimate.fit.rms, 2) +
                      " um are below any instrument's noise: were the points measured, or commanded or simulated?");
  }
  if (!trust.suspects.empty()) {
    const auto n = trust.suspects.size();
    reasons.push_back(std::to_string(n) + (n == 1 ? " row is" : " rows are") + " suspect (" + trust.suspects[0].row +
                      (n > 1 ? ", …" : "") + ")");
  }
  if (estimate.fit.distance_rms > SuspiciousMisfit(problem.robot.chain)) {
    reasons.push_back("the calibrated robot still misses by " + Millimetres(estimate.fit.distance_rms) +
                      " (RMS): robot file and measurements do not belong together");
  }
  return reasons;
}

std::string NotMeasured(const Estimate& estimate) {
  static const char* kNumbers[] = {"no", "one", "two", "three", "four", "five", "six"};
  const size_t n = estimate.identifiability.unidentifiable.size();
  if (n == 0) return "";
  const std::string number = n < std::size(kNumbers) ? kNumbers[n] : std::to_string(n);
  return "; " + number + (n == 1 ? " direction was" : " directions were") + " not measured";
}

std::string FirstSentence(const CalibrationProblem& problem, const Trust& trust) {
  const UnseenPoints& quoted = trust.Quoted();
  if (quoted.points == 0) return "No points were set aside to say how good this robot is on poses it has not seen.";
  const double better = quoted.distance_rms > 0.0 ? trust.nominal.distance_rms / quoted.distance_rms : 0.0;
  std::string words = "On poses it has not seen this robot is now within " + Millimetres(quoted.distance_rms) +
                      " (RMS; 95 % of points within " + Millimetres(quoted.distance_p95) + ", worst " +
                      Millimetres(quoted.distance_max) + " at config " + quoted.worst.front().configuration + ")";
  if (better > 1.0) words += ", " + Significant(better, 2) + " times better than nominal";
  if (quoted.predicted_rms > 0.0) {
    const bool agrees = quoted.p_value >= problem.experiment.significance;
    words += agrees ? "; the prediction agrees"
                    : "; the prediction was " + Significant(quoted.Excess(), 2) + " times smaller";
  }
  return words + ".";
}

}  // namespace

Trust JudgeTrust(const CalibrationProblem& problem, std::uint64_t seed, Estimate* estimate) {
  Trust trust;
  trust.suspects = FindSuspects(problem, *estimate);
  trust.cross_validation = CrossValidate(problem, *estimate, seed);
  trust.holdout = JudgeHoldout(problem, *estimate);
  trust.repeatability = MeasurePoseRepeatability(problem);
  const std::vector<int> quoted = problem.data.PointsAmong(
      trust.holdout.points > 0 ? problem.ValidationObservations() : problem.CalibrationObservations());
  if (estimate->aligned.num_coordinates() > 0)
    trust.nominal = MeasureUnseen(problem, quoted, Errors(problem, estimate->aligned, quoted));
  JudgeModelError(*estimate, problem.experiment.significance, &trust);
  Widen(&trust, estimate);
  trust.verdict.reasons = ReasonsAgainst(problem, *estimate, trust);
  trust.verdict.trusted = trust.verdict.reasons.empty();
  trust.verdict.words = FirstSentence(problem, trust);
  trust.verdict.words += trust.verdict.trusted
                             ? " Trust it inside the measured joint ranges" + NotMeasured(*estimate) + "."
                             : " Do not trust it yet: " + Enumerate(trust.verdict.reasons) + ".";
  return trust;
}

}  // namespace sagitta
