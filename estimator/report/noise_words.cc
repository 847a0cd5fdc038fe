#include "estimator/report/noise_words.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "estimator/noise/robot_scatter.h"
#include "estimator/noise/rotation_noise.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kDominates = 2.0;  // one source over the other
constexpr size_t kListed = 20;      // outliers named one by one

// "41.2 µrad (95 %: 36 to 47.1)". An interval and no ±, which in the table of parameters is an expanded uncertainty:
// that of a variance is not even about its value.
std::string WithInterval(const VarianceComponent& component, double unit, const std::string& name) {
  const std::string value = Significant(unit * component.value, 3) + name;
  if (!component.estimated) return value;
  return value + " (95 %: " + Significant(unit * component.low, 3) + " to " + Significant(unit * component.high, 3) +
         ")";
}

std::string SourceName(const CalibrationProblem& problem, const SigmaReport& sigma) {
  const Experiment& experiment = problem.experiment();
  if (experiment.method.weights == Weights::kEq14) return "eq14";
  switch (experiment.noise.from) {
    case NoiseSpec::From::kRepeats:
      return "repeats";
    case NoiseSpec::From::kResiduals:
      return "residuals";
    case NoiseSpec::From::kInstrument:
      return "instrument";
    case NoiseSpec::From::kVarianceComponents:
      return "variance-components";
    case NoiseSpec::From::kDefault:
    case NoiseSpec::From::kSigma:
    case NoiseSpec::From::kRows:
      break;
  }
  return sigma.stated && sigma.origin != NoiseOrigin::kFound ? "stated" : "estimated";
}

std::string OfEachAxis(const Vector3<double>& numbers) {
  return "x " + Significant(numbers.x(), 3) + ", y " + Significant(numbers.y(), 3) + ", z " +
         Significant(numbers.z(), 3);
}

// Empty where nothing is known of rotations.
std::string RotationRepeatWords(const RepeatScatter& scatter, const SigmaReport& sigma) {
  const double times = scatter.rotation_is_estimated && sigma.scaled ? sigma.a_posteriori : 1.0;
  const Vector3<double> urad = 1e6 * times * scatter.rotation_sigma;
  if (!(urad.minCoeff() > 0.0)) return "";
  const std::string dof = " (" + Fixed(scatter.rotation_dof, 0) + " degrees of freedom of all axes together)";
  if (scatter.rotation_is_estimated) {
    return " Too few rotations were read twice: that of rotations is the spread of their residuals, " +
           Significant(urad.x(), 3) + " µrad of every axis" + dof + ".";
  }
  if (!scatter.rotation_axes_differ)
    return " Of rotations " + Significant(urad.x(), 3) + " µrad of every axis" + dof + ".";
  return " Of rotations " + OfEachAxis(urad) + " µrad" + dof + ".";
}

std::string RepeatWords(const RepeatScatter& scatter, const SigmaReport& sigma) {
  const std::string of_points =
      scatter.axes_differ
          ? OfEachAxis(1e6 * scatter.sigma) + " µm (" + std::to_string(scatter.dof) + " degrees of freedom per axis)."
          : Significant(1e6 * scatter.sigma.x(), 3) + " µm of every axis (" + std::to_string(3 * scatter.dof) +
                " degrees of freedom of all axes together: too few to weigh each axis by its own).";
  return "The noise is the spread of repeated shots: " + of_points + RotationRepeatWords(scatter, sigma) +
         " What repeats share, as the robot's own error, is not in it.";
}

std::string ComponentWords(const VarianceComponent& component, bool instrument_is_factor) {
  const bool is_instrument = component.joints.empty() && !component.of_rotations;
  const double unit = is_instrument && instrument_is_factor ? 1.0 : 1e6;
  const char* of_instrument = instrument_is_factor ? " times the stated noise" : " µm";
  const std::string name = is_instrument ? of_instrument : (component.is_prismatic ? " µm" : " µrad");
  if (!component.estimated) return component.name + " " + WithInterval(component, unit, name) + " as stated";
  if (component.low == 0.0 && component.value < 0.5 * component.high) {
    return component.name + " " + Significant(unit * component.value, 3) + name +
           ", not distinguished from none, below " + Significant(unit * component.high, 3) + name + " (95 %)";
  }
  return component.name + " " + WithInterval(component, unit, name);
}

// "the robot, not the tracker, is the noise: 41 urad (95 %: 36 to 47) per joint against 10 um"
std::string WhoIsTheNoise(const NoiseReport& report) {
  const double robot = 1e6 * report.robot_rms, instrument = 1e6 * report.instrument_rms;
  std::string joints;
  for (const VarianceComponent& component : report.components) {
    if (component.joints.empty() || component.value == 0.0) continue;
    joints += (joints.empty() ? "" : ", ") +
              (report.per_joint || component.joints.size() == 1 ? component.name + " " : std::string()) +
              WithInterval(component, 1e6, component.is_prismatic ? " µm" : " µrad");
  }
  const std::string moves = " moves a coordinate by " + Significant(robot, 3) + " µm RMS, the instrument reads it to " +
                            Significant(instrument, 3) + " µm";
  if (robot > kDominates * instrument) {
    return "The robot, not the instrument, is the noise: " + joints + (report.per_joint ? "" : " per joint") +
           " at every arrival" + moves + ".";
  }
  if (joints.empty() || instrument > kDominates * robot) {
    return "The instrument, not the robot, is the noise: it reads a coordinate to " + Significant(instrument, 3) +
           " µm, the joints' repeatability moves it by " + Significant(robot, 3) + " µm RMS.";
  }
  return "Robot and instrument are noise alike: " + joints + (report.per_joint ? "" : " per joint") + moves + ".";
}

std::string WhyThisNoise(const NoiseReport& report) {
  const std::string figures = " (one per joint gains " + Significant(report.gain_per_joint, 3) +
                              " in deviance, and has to gain " + Significant(report.penalty, 3) + ")";
  return report.per_joint ? "The data separate the joints' repeatabilities" + figures + "."
                          : "The data carry one repeatability for all joints of a kind" + figures + ".";
}

// Arrivals at one configuration separate the robot's scatter from what the model lacks there.
bool VisitsTwice(const CalibrationProblem& problem) {
  std::map<int, std::set<int>> visits;
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    visits[problem.data().shots[s].configuration].insert(problem.latent.visit_of_shot[s]);
  }
  return std::any_of(visits.begin(), visits.end(), [](const auto& entry) { return entry.second.size() > 1; });
}

// Rows that are distinguished from an earlier one of their marker by neither visit nor repeat.
int RowsWithoutArrival(const CalibrationProblem& problem) {
  int rows = 0;
  std::set<std::tuple<int, int, int, std::string, std::string, std::string>> seen;
  for (const Observation& row : problem.data().observations) {
    const Shot& shot = problem.data().shots[row.shot];
    if (!row.is_point()) continue;
    if (!seen.insert({shot.configuration, shot.station, row.marker, shot.visit, shot.repeat, shot.load}).second) ++rows;
  }
  return rows;
}

// What the arm scatters by from arrival to arrival counts as the instrument's where arrivals have no name.
void DescribeUnnamedArrivals(const CalibrationProblem& problem, NoiseReport* report) {
  const int rows = RowsWithoutArrival(problem);
  if (rows == 0) return;
  report->words.push_back(
      std::to_string(rows) + (rows == 1 ? " row counts as a repeated shot" : " rows count as repeated shots") +
      " of one arrival, for neither visit nor repeat distinguishes them from earlier ones. If the arm came anew for "
      "them, its own scatter stands in the instrument's figure, and the figures of both are wrong: name the "
      "arrivals in a column visit.");
}

void DescribeComponents(const CalibrationProblem& problem, NoiseReport* report) {
  report->words.push_back(WhoIsTheNoise(*report));
  DescribeUnnamedArrivals(problem, report);
  std::string all;
  for (const VarianceComponent& component : report->components) {
    if (component.joints.empty() && !component.estimated) continue;
    all += (all.empty() ? "" : "; ") + ComponentWords(component, report->instrument_is_factor);
  }
  if (!all.empty()) report->words.push_back("Variance components (REML): " + all + ".");
  if (!VisitsTwice(problem) && report->robot_rms > report->instrument_rms) {
    report->words.push_back(
        "No configuration was visited twice: what the model lacks at a configuration counts as repeatability here.");
  }
  if (report->penalty > 0.0) report->words.push_back(WhyThisNoise(*report));
}

void DescribeOutliers(const CalibrationProblem& problem, Estimate* estimate) {
  NoiseReport& report = estimate->noise_report;
  if (report.loss == LossKind::kNone) return;
  const Measurements& data = problem.data();
  report.words.push_back("Loss: " + WordOf(report.loss) +
                         " on the whitened distance of each marker point, turning at " +
                         Significant(report.loss_tuning, 3) + " standard deviations; it widens the intervals by " +
                         Fixed(100.0 * (std::sqrt(report.loss_inflation) - 1.0), 1) + " %.");
  if (report.outliers.empty()) {
    report.words.push_back("No outliers.");
    return;
  }
  std::string list;
  for (size_t i = 0; i < std::min(kListed, report.outliers.size()); ++i) {
    const Outlier& outlier = report.outliers[i];
    const Observation& row = data.observations[outlier.observation];
    list += (list.empty() ? "" : "; ") + data.SourceOf(row) + " (" + data.markers[row.marker] + ", " +
            OutlierIsOffBy(outlier);
    if (outlier.swapped_with >= 0) {
      const Observation& other = data.observations[outlier.swapped_with];
      list += ", exchanged with " + data.markers[other.marker];
      if (other.file >= 0) list += " of line " + std::to_string(data.files[other.file].rows[other.row].line);
    }
    list += ")";
  }
  if (report.outliers.size() > kListed) list += "; and " + std::to_string(report.outliers.size() - kListed) + " more";
  const std::string count =
      std::to_string(report.outliers.size()) + (report.outliers.size() == 1 ? " outlier" : " outliers");
  if (!report.systematic) {
    report.words.push_back(count + ", left out of all figures: " + list + ".");
    return;
  }
  const std::string warning =
      "the flagged rows share a cause (" + Joined(report.shared, "; ") +
      "): that is a misfit of the model there, not outliers, and they stay in all figures; try sagitta diagnose";
  estimate->warnings.push_back(warning);
  report.words.push_back(count + " flagged, but " + warning + ". Flagged: " + list + ".");
}

// What the fit weighs with where that is not the inverse of the noise.
void DescribeWeights(const CalibrationProblem& problem, NoiseReport* report) {
  if (problem.weight_roots.empty()) return;
  const NoiseSpec& noise = problem.experiment().noise;
  if (problem.experiment().method.weights == Weights::kEqual) {
    report->words.push_back(
        "Weights: equal (ordinary least squares). The intervals count the noise of each row as it is "
        "(sandwich, eq. (8) of paper 003); weights: sigma would make them shorter.");
    return;
  }
  report->words.push_back("Weights: eq. (14) of paper 003, lambda " + Significant(noise.lambda, 3) + ", sigma0 " +
                          Significant(1e6 * noise.sigma0, 3) +
                          " µm. The intervals count the noise of each row as it is (sandwich, eq. (11)).");
}

void DescribeGroups(const CalibrationProblem& problem, Estimate* estimate) {
  NoiseReport& report = estimate->noise_report;
  if (report.groups.empty()) return;
  double low = report.groups[0].sigma, high = low;
  for (const NoiseGroup& group : report.groups) {
    low = std::min(low, group.sigma);
    high = std::max(high, group.sigma);
  }
  const NoiseSpec& noise = problem.experiment().noise;
  report.words.push_back("The noise is the spread of the residuals in " + std::to_string(report.groups.size()) +
                         " groups (" + WordOf(noise.group) + "): " + Significant(1e6 * low, 3) + " to " +
                         Significant(1e6 * high, 3) + " µm.");
  if (noise.group == ResidualGroup::kResidual) {
    estimate->warnings.push_back(
        "weights from each row's own residual make intervals that are too short (of those of 95 % some 85 to 90 % hold "
        "the truth); use group: config-axis or state the noise");
  }
}

}  // namespace

std::string OutliersAreOf(int hits, int outliers, const std::string& category, double share) {
  return std::to_string(hits) + " of " + std::to_string(outliers) + " are of " + category + ", which has " +
         WholePercent(share) + " of the rows";
}

std::string OutliersLieAt(const std::string& what, double from, double to, const std::string& unit) {
  return "they lie at " + what + " from " + Significant(from, 4) + " to " + Significant(to, 4) + " " + unit +
         " more often than the rows do";
}

std::string AreNoMinority(double share) { return WholePercent(share) + " of the rows are no minority"; }

std::string RobotScatterInWords(double tau) {
  return "In addition to the stated sigmas every coordinate scatters by " + InMillimetres(tau) +
         " (maximum likelihood), and rows are weighed by both; noise: {from: rows} weighs by the stated sigmas "
         "alone.";
}

std::string RotationScatterInWords(double spread, bool is_in_addition) {
  const std::string mrad = Significant(1e3 * spread, 3) + " mrad";
  if (is_in_addition)
    return "In addition to the stated sigmas every axis of a rotation scatters by " + mrad +
           ", and rotations are weighed by both.";
  return "No rotation states a standard deviation: its residuals scatter by " + mrad +
         " in every axis, and rotations are weighed by that.";
}

std::string NameOfNoise(NoiseOrigin origin) {
  switch (origin) {
    case NoiseOrigin::kRepeats:
      return "the scatter of the repeats";
    case NoiseOrigin::kScaled:
    case NoiseOrigin::kFound:
      return "the noise that was found";
    case NoiseOrigin::kStated:
      break;
  }
  return "the stated sigmas";
}

std::string SigmaInWords(const Estimate& estimate, double significance) {
  const SigmaReport& sigma = estimate.sigma;
  const double reduced = sigma.a_posteriori * sigma.a_posteriori;
  const std::string name = NameOfNoise(sigma.origin), times = Significant(sigma.a_posteriori, 3);
  const std::string chance = " (" + PValueInWords(sigma.p_value) + ")";
  if (sigma.scaled && estimate.intervals.is_empirical()) {
    return "The residuals are " + times + " times " + name + chance +
           "; the intervals use the scatter as it is seen between configurations.";
  }
  if (sigma.scaled && reduced > kInstrumentIsNotTheNoise) {
    const std::string share = "1/" + Fixed(reduced, 0);
    return (sigma.origin == NoiseOrigin::kStated ? "The stated sigmas explain " + share + " of the scatter"
                                                 : "Of the scatter " + share + " is " + name) +
           ": the robot, the model or rows that are wrong, not the instrument, are the noise; all intervals are scaled "
           "by " +
           times + ".";
  }
  if (sigma.scaled) {
    return "The residuals are larger than " + name + chance + "; all intervals are scaled by " + times + ".";
  }
  if (1.0 - sigma.p_value < significance) {
    const std::string factor = Significant(1.0 / sigma.a_posteriori, 3);
    if (sigma.origin == NoiseOrigin::kStated)
      return "The residuals are smaller than the stated sigmas: those are too large by about a factor " + factor +
             "; intervals use them as stated.";
    return "The residuals are smaller than " + name + " by about a factor " + factor + "; intervals use the latter.";
  }
  return "The residuals agree with " + name + chance + ".";
}

void SayRotationsAreAssumed(bool by_repeats, Estimate* estimate) {
  estimate->warnings.push_back("the readings are too few to determine what rotations scatter by: 1 mrad is assumed" +
                               std::string(by_repeats ? "" : " where points scatter by 1 mm") +
                               "; add the column sigma_rot_urad, or measure more poses");
}

namespace {

std::string TwoNoisesInWords(const VarianceComponent& point, const VarianceComponent& rotation) {
  return "No standard deviation is stated; two are estimated: " + InMillimetres(point.value) +
         " of every coordinate of a point, " + Significant(1e3 * rotation.value, 3) +
         " mrad of every axis of a rotation.";
}

}  // namespace

std::string OutlierIsOffBy(const Outlier& outlier) {
  std::vector<std::string> sizes;
  if (outlier.size > 0.0) sizes.push_back(Significant(1e3 * outlier.size, 3) + " mm");
  if (outlier.angle > 0.0) sizes.push_back(Significant(1e3 * outlier.angle, 3) + " mrad");
  return Joined(sizes, " and ");
}

void DescribeOrigin(const CalibrationProblem& problem, Estimate* estimate) {
  NoiseReport& report = estimate->noise_report;
  report.source = SourceName(problem, estimate->sigma);
  if (!problem.repeat_scatter) return;
  report.words.push_back(RepeatWords(*problem.repeat_scatter, estimate->sigma));
  DescribeUnnamedArrivals(problem, &report);
}

void DescribeNoise(const CalibrationProblem& problem, Estimate* estimate) {
  NoiseReport& report = estimate->noise_report;
  report.loss = problem.experiment().method.loss;
  DescribeOrigin(problem, estimate);
  if (HasTwoNoises(report)) {
    report.source = "estimated";
    report.words.push_back(TwoNoisesInWords(report.components[0], *RotationComponent(report)));
  } else if (!report.components.empty()) {
    DescribeComponents(problem, &report);
  }
  DescribeGroups(problem, estimate);
  DescribeWeights(problem, &report);
  DescribeOutliers(problem, estimate);
  if (report.converged) return;
  const std::string warning = "the noise did not settle in " + std::to_string(report.rounds) +
                              " rounds of fit and noise: the last round's values are given";
  estimate->warnings.push_back(warning);
  report.words.push_back(warning + ".");
}

}  // namespace sagitta
