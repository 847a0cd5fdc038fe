#include "estimator/validation/suspects.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "estimator/inspection/reading_lint.h"
#include "estimator/inspection/row_lint.h"
#include "estimator/inspection/tried_readings.h"
#include "estimator/inspection/wild_rows.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/refit.h"
#include "estimator/least_squares/sample.h"
#include "estimator/report/noise_words.h"
#include "estimator/report/validation_words.h"

namespace sagitta {
namespace {

// What fits lies where other rows do, or is nearer by the digits that a point in metres or inches has at least.
constexpr double kFits = 10.0;  // median distances
constexpr double kFitsShare = 1e-3;

struct SuspectedRows {
  const CalibrationProblem& problem;
  const FittedStream* fitted;  // or null
  ParameterSet parameters;     // what the residuals are of, but for a linear step
  std::vector<int> observations;
  Eigen::Matrix3Xd residuals;  // predicted - measured, m
  int unknowns = 0;            // of the fit that left them

  const Observation& at(int k) const { return problem.data().observations[observations[k]]; }
  const Shot& shot(int k) const { return problem.data().shots[at(k).shot]; }
  Vector3<double> measured(int k) const { return at(k).point_in_station; }
  Vector3<double> predicted(int k) const { return measured(k) + residuals.col(k); }
};

// Other ways to read one point; the nearest to its prediction wins.
class Proposals {
 public:
  // median: of the distances of all rows.
  Proposals(double as_stated, double median, const Vector3<double>& predicted)
      : least_(std::min(as_stated / kReadingImprovement, std::max(kFits * median, kFitsShare * as_stated))),
        predicted_(predicted) {}
  void TryPoint(const Vector3<double>& point, const std::string& words) {
    TryDistance((point - predicted_).norm(), words);
  }
  void TryDistance(double distance, const std::string& words) {
    if (distance >= least_) return;
    least_ = distance;
    words_ = words;
  }
  const std::string& words() const { return words_; }

 private:
  double least_;
  Vector3<double> predicted_;
  std::string words_;
};

void TryNumbers(const Vector3<double>& point, Proposals* proposals) {
  for (int axis = 0; axis < 3; ++axis) {
    Vector3<double> turned = point;
    turned[axis] *= -1.0;
    proposals->TryPoint(turned, FitsTurned(axis));
    const int next = (axis + 1) % 3;
    Vector3<double> exchanged = point;
    std::swap(exchanged[axis], exchanged[next]);
    proposals->TryPoint(exchanged, FitsExchanged(axis, next));
    for (const double factor : {10.0, 0.1}) {
      Vector3<double> shifted = point;
      shifted[axis] *= factor;
      proposals->TryPoint(shifted, FitsShifted(axis, factor > 1.0));
    }
  }
  proposals->TryPoint(1e3 * point, FitsInMetres());
  proposals->TryPoint(1e-3 * point, FitsInThousandths());
  proposals->TryPoint(25.4 * point, FitsInInches());
}

// Another marker of the shot, the other station, another configuration.
void TryLabels(const SuspectedRows& rows, int k, Proposals* proposals) {
  const Measurements& data = rows.problem.data();
  for (int other = 0; other < static_cast<int>(rows.observations.size()); ++other) {
    if (other == k) continue;
    const double distance = (rows.measured(k) - rows.predicted(other)).norm();
    const Observation& row = rows.at(other);
    if (row.shot == rows.at(k).shot) {
      proposals->TryDistance(distance, FitsAsMarker(data.markers[row.marker], data.SourceOf(row)));
    } else if (row.marker == rows.at(k).marker && rows.shot(other).station == rows.shot(k).station) {
      proposals->TryDistance(distance, FitsConfiguration(data.ConfigurationOf(row).id, data.SourceOf(row)));
    }
  }
  const int own = rows.shot(k).station;
  const Pose<double> base = rows.parameters.BaseInStation(own);
  const Vector3<double> in_base = base.rotation.transpose() * (rows.predicted(k) - base.translation);
  for (int s = 0; s < rows.parameters.num_stations(); ++s) {
    if (s == own) continue;
    proposals->TryDistance((rows.parameters.BaseInStation(s) * in_base - rows.measured(k)).norm(),
                           FitsStation(data.stations[s]));
  }
}

// What trackers write where they lost their target: one number three times, as -9999 or 0.
bool IsOneNumber(const Vector3<double>& point) { return point.x() == point.y() && point.x() == point.z(); }

// Excluded as an outlier by the noise model, which has looked closer.
std::vector<Suspect> LeftOut(const CalibrationProblem& problem, const Estimate& estimate) {
  std::vector<Suspect> suspects;
  for (const Outlier& outlier : estimate.noise_report.outliers) {
    const Observation& row = problem.data().observations[outlier.observation];
    std::string words = "off by " + OutlierIsOffBy(outlier);
    if (outlier.swapped_with >= 0) {
      const Observation& other = problem.data().observations[outlier.swapped_with];
      words += "; " + FitsAsMarker(problem.data().markers[other.marker], problem.data().SourceOf(other));
    }
    suspects.push_back({outlier.observation, problem.data().SourceOf(row), words});
  }
  return suspects;
}

ParameterSet Unheld(ParameterSet parameters) {
  for (int i = 0; i < parameters.num_coordinates(); ++i) parameters.coordinate(i).held = false;
  return parameters;
}

// Residuals of one robust linear fit (row_lint.h) at `parameters`. False: there is none. Where rows are too many to be
// kept, the step is that of a sample of them, configuration by configuration: it moves no point by more than a small
// part of the noise.
bool FitLinearly(const ParameterSet& parameters, SuspectedRows* rows) {
  const std::vector<int> columns = parameters.EstimatedCoordinates();
  const std::vector<int> looked_at = SampleForStep(rows->problem.data(), rows->observations, columns.size());
  const NoiseRoots noise = ObservationNoise(rows->problem, looked_at, kFallbackSigma);
  Linearization here = Linearize(rows->problem, parameters, looked_at, columns, noise, LatentTreatment::kIgnore);
  std::vector<int> seen;  // what no point depends on, as a marker's rotation, is left out
  for (int c = 0; c < here.num_columns(); ++c) {
    if (here.jacobian.col(c).squaredNorm() > 0.0) seen.push_back(c);
  }
  if (seen.size() < columns.size()) here.jacobian = here.jacobian(Eigen::all, seen).eval();
  if (!here.valid || here.num_rows() <= here.num_columns()) return false;
  rows->unknowns = here.num_columns();
  Eigen::VectorXd step;
  const Eigen::Matrix3Xd residuals = RobustLinearResiduals(here, noise, &step);
  if (looked_at.size() == rows->observations.size()) {
    rows->residuals = residuals;
    return true;
  }
  std::vector<int> moved;
  for (const int c : seen) moved.push_back(columns[c]);
  ParameterSet there = parameters;
  Move(moved, step, 1.0, &there);
  const Eigen::Matrix3Xd predicted = rows->fitted != nullptr
                                         ? rows->fitted->Predict(rows->problem, there, rows->observations)
                                         : PredictPoints(rows->problem, there, rows->observations);
  rows->residuals = -ResidualsOf(rows->problem.data(), rows->observations, predicted);
  return rows->residuals.allFinite();
}

// Residuals of a fit that resists what it finds: gross readings leave it, and the rest is looked at again until no more
// are found. One reading in metres moves everything by so much that no other would be seen.
bool FitRobustly(const Estimate& estimate, SuspectedRows* rows, std::vector<int>* outliers) {
  constexpr int kRounds = 6;
  const std::vector<int> fitted = rows->problem.CalibrationObservations();
  // Where a blunder spoiled the estimate so far that nothing is left of it, begin at the aligned nominal robot.
  ParameterSet parameters = IsUsable(estimate.status) ? estimate.parameters : Unheld(estimate.aligned);
  bool is_restarted = !IsUsable(estimate.status);
  if (estimate.fit.distance_rms > SuspiciousMisfit(rows->problem)) {
    if (const std::optional<FarRows> far = FindFarRows(rows->problem)) {
      parameters = Unheld(far->parameters);
      is_restarted = true;
    }
  }
  for (int round = 0; round < kRounds; ++round) {
    if (!FitLinearly(parameters, rows)) return round > 0;
    rows->parameters = parameters;
    const std::vector<int> found = GrossOutliers(rows->residuals, rows->unknowns);
    if (found == *outliers) return true;
    *outliers = found;
    RefitOptions options;
    options.weights.assign(fitted.size(), 1.0);
    for (const int k : found) {
      const auto place = std::lower_bound(fitted.begin(), fitted.end(), rows->observations[k]);
      if (place != fitted.end()) options.weights[place - fitted.begin()] = 0.0;
    }
    const Refit refit = RefitFrom(rows->problem, parameters, options);
    if (refit.converged) {
      parameters = refit.parameters;
    } else if (!is_restarted) {  // what a blunder has led astray does not find back: begin at the aligned nominal robot
      parameters = Unheld(estimate.aligned);
      is_restarted = true;
    } else {
      return true;
    }
  }
  return true;
}

}  // namespace

std::vector<Suspect> FindSuspects(const CalibrationProblem& problem, const Estimate& estimate,
                                  const FittedStream* fitted) {
  std::vector<Suspect> suspects = LeftOut(problem, estimate);
  SuspectedRows rows{
      problem, fitted, estimate.parameters, problem.data().PointsAmong(problem.CalibrationObservations()), {}, 0};
  std::vector<int> outliers;
  if (!FitRobustly(estimate, &rows, &outliers)) return suspects;
  std::vector<double> distances;
  for (Eigen::Index k = 0; k < rows.residuals.cols(); ++k) distances.push_back(rows.residuals.col(k).norm());
  const double median = TypicalDistance(distances, rows.unknowns);
  const bool is_near = median <= SuspiciousMisfit(problem);  // else no reading can be said to fit
  for (const int k : outliers) {
    const int observation = rows.observations[k];
    const auto is_known = [&](const Suspect& suspect) { return suspect.observation == observation; };
    if (std::any_of(suspects.begin(), suspects.end(), is_known)) continue;
    Proposals proposals(distances[k], median, rows.predicted(k));
    const bool is_lost = IsOneNumber(rows.measured(k));
    if (is_near && !is_lost) {
      TryNumbers(rows.measured(k), &proposals);
      TryLabels(rows, k, &proposals);
    }
    std::string cure = proposals.words().empty() ? MeasureAgain() : proposals.words();
    if (is_lost) cure = ReadingIsLost();
    suspects.push_back({observation, problem.data().SourceOf(rows.at(k)),
                        RowIsOff(distances[k], distances[k] / median) + "; " + cure});
  }
  std::stable_sort(suspects.begin(), suspects.end(),
                   [](const Suspect& a, const Suspect& b) { return a.observation < b.observation; });
  return suspects;
}

}  // namespace sagitta
