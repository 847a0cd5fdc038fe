#include "estimator/noise/noise_words.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

namespace sagitta {
namespace {

constexpr double kDominates = 2.0;  // one source over the other
constexpr size_t kListed = 20;      // outliers named one by one

std::string Number(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// Two digits of the uncertainty: "41 +- 3".
std::string WithUncertainty(double value, double sigma) {
  if (!(sigma > 0.0)) return Number("%.3g", value);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma) + 1e-9)), 0, 9);
  char text[64];
  std::snprintf(text, sizeof text, "%.*f ± %.*f", decimals, value, decimals, sigma);
  return text;
}

std::string SourceName(const CalibrationProblem& problem, const SigmaReport& sigma) {
  const Experiment& experiment = problem.experiment;
  if (experiment.weights == "eq14") return "eq14";
  switch (experiment.noise.from) {
    case NoiseSpec::From::kRepeats:
      return "repeats";
    case NoiseSpec::From::kResiduals:
      return "residuals";
    case NoiseSpec::From::kInstrument:
      return "instrument";
    case NoiseSpec::From::kVarianceComponents:
      return "variance-components";
    default:
      return sigma.stated ? "stated" : "estimated";
  }
}

std::string RepeatWords(const RepeatScatter& scatter) {
  const Vector3<double> um = 1e6 * scatter.sigma;
  return "The noise is the spread of repeated shots: x " + Number("%.3g", um.x()) + ", y " + Number("%.3g", um.y()) +
         ", z " + Number("%.3g", um.z()) + " µm (" + std::to_string(scatter.dof) +
         " degrees of freedom per axis). What repeats share, as the robot's own error, is not in it.";
}

std::string ComponentWords(const VarianceComponent& component, bool instrument_is_factor) {
  const bool is_instrument = component.joints.empty();
  const double unit = is_instrument && instrument_is_factor ? 1.0 : 1e6;
  const char* of_instrument = instrument_is_factor ? " times the stated noise" : " µm";
  const std::string name = is_instrument ? of_instrument : (component.is_prismatic ? " µm" : " µrad");
  const double value = unit * component.value, low = unit * component.low, high = unit * component.high;
  if (!component.estimated) return component.name + " " + Number("%.3g", value) + name + " as stated";
  const std::string range = " (95 %: " + Number("%.3g", low) + " to " + Number("%.3g", high) + ")";
  if (component.low == 0.0 && component.value < 0.5 * component.high) {
    return component.name + " " + Number("%.3g", value) + name + ", not told from none, below " + Number("%.3g", high) +
           name + " (95 %)";
  }
  return component.name + " " + WithUncertainty(value, unit * component.sigma) + name + range;
}

// "the robot, not the tracker, is the noise: 41 +- 3 urad per joint against 10 um"
std::string WhoIsTheNoise(const NoiseReport& report) {
  const double robot = 1e6 * report.robot_rms, instrument = 1e6 * report.instrument_rms;
  std::string joints;
  for (const VarianceComponent& component : report.components) {
    if (component.joints.empty() || component.value == 0.0) continue;
    joints += (joints.empty() ? "" : ", ") +
              (report.per_joint || component.joints.size() == 1 ? component.name + " " : std::string()) +
              WithUncertainty(1e6 * component.value, 1e6 * component.sigma) +
              (component.is_prismatic ? " µm" : " µrad");
  }
  const std::string moves = " moves a coordinate by " + Number("%.3g", robot) + " µm RMS, the instrument reads it to " +
                            Number("%.3g", instrument) + " µm";
  if (robot > kDominates * instrument) {
    return "The robot, not the instrument, is the noise: " + joints + (report.per_joint ? "" : " per joint") +
           " at every arrival" + moves + ".";
  }
  if (joints.empty() || instrument > kDominates * robot) {
    return "The instrument, not the robot, is the noise: it reads a coordinate to " + Number("%.3g", instrument) +
           " µm, the joints' repeatability moves it by " + Number("%.3g", robot) + " µm RMS.";
  }
  return "Robot and instrument are noise alike: " + joints + (report.per_joint ? "" : " per joint") + moves + ".";
}

std::string ChoiceWords(const NoiseReport& report) {
  const std::string figures = " (one per joint gains " + Number("%.3g", report.gain_per_joint) +
                              " in deviance, and has to gain " + Number("%.3g", report.penalty) + ")";
  return report.per_joint ? "The data tell the joints' repeatabilities apart" + figures + "."
                          : "The data carry one repeatability for all joints of a kind" + figures + ".";
}

// Arrivals at one configuration tell the robot's scatter from what the model lacks there.
bool VisitsTwice(const CalibrationProblem& problem) {
  std::map<int, std::set<int>> visits;
  for (size_t s = 0; s < problem.data.shots.size(); ++s) {
    visits[problem.data.shots[s].configuration].insert(problem.latent.visit_of_shot[s]);
  }
  return std::any_of(visits.begin(), visits.end(), [](const auto& entry) { return entry.second.size() > 1; });
}

void DescribeComponents(const CalibrationProblem& problem, NoiseReport* report) {
  report->words.push_back(WhoIsTheNoise(*report));
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
  if (report->penalty > 0.0) report->words.push_back(ChoiceWords(*report));
}

void DescribeOutliers(const CalibrationProblem& problem, Estimate* estimate) {
  NoiseReport& report = estimate->noise_report;
  if (report.loss == "none") return;
  const Measurements& data = problem.data;
  report.words.push_back("Loss: " + report.loss + " on the whitened distance of each marker point, turning at " +
                         Number("%.3g", report.loss_tuning) + " standard deviations; it widens the intervals by " +
                         Number("%.1f", 100.0 * (std::sqrt(report.loss_inflation) - 1.0)) + " %.");
  if (report.outliers.empty()) {
    report.words.push_back("No outliers.");
    return;
  }
  std::string list;
  for (size_t i = 0; i < std::min(kListed, report.outliers.size()); ++i) {
    const Outlier& outlier = report.outliers[i];
    const Observation& row = data.observations[outlier.observation];
    list += (list.empty() ? "" : "; ") + data.SourceOf(row) + " (" + data.markers[row.marker] + ", " +
            Number("%.3g", 1e3 * outlier.size) + " mm";
    if (outlier.swapped_with >= 0) {
      const Observation& other = data.observations[outlier.swapped_with];
      list += ", exchanged with " + data.markers[other.marker] + " of line " +
              std::to_string(data.files[other.file].rows[other.row].line);
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
  std::string shared;
  for (const std::string& words : report.shared) shared += (shared.empty() ? "" : "; ") + words;
  const std::string warning =
      "the flagged rows share a cause (" + shared +
      "): that is a misfit of the model there, not outliers, and they stay in all figures; try sagitta diagnose";
  estimate->warnings.push_back(warning);
  report.words.push_back(count + " flagged, but " + warning + ". Flagged: " + list + ".");
}

// What the fit weighs with where that is not the inverse of the noise.
void DescribeWeights(const CalibrationProblem& problem, NoiseReport* report) {
  if (problem.weight_roots.empty()) return;
  const NoiseSpec& noise = problem.experiment.noise;
  if (problem.experiment.weights == "equal") {
    report->words.push_back(
        "Weights: equal (ordinary least squares). The intervals count the noise of each row as it is "
        "(sandwich, eq. (8) of paper 003); weights: sigma would make them shorter.");
    return;
  }
  report->words.push_back("Weights: eq. (14) of paper 003, lambda " + Number("%.3g", noise.lambda) + ", sigma0 " +
                          Number("%.3g", 1e6 * noise.sigma0) +
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
  const NoiseSpec& noise = problem.experiment.noise;
  report.words.push_back("The noise is the spread of the residuals in " + std::to_string(report.groups.size()) +
                         " groups (" + noise.group + "): " + Number("%.3g", 1e6 * low) + " to " +
                         Number("%.3g", 1e6 * high) + " µm.");
  if (noise.group == "residual") {
    estimate->warnings.push_back(
        "weights from each row's own residual make intervals that are too short (of 95 % intervals of the "
        "published scheme three in ten hold the truth); use group: config-axis or state the noise");
  }
}

}  // namespace

void DescribeNoise(const CalibrationProblem& problem, Estimate* estimate) {
  NoiseReport& report = estimate->noise_report;
  report.source = SourceName(problem, estimate->sigma);
  report.loss = problem.experiment.loss;
  if (problem.repeat_scatter) report.words.push_back(RepeatWords(*problem.repeat_scatter));
  if (!report.components.empty()) DescribeComponents(problem, &report);
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
