#include "estimator/report/agreement_words.h"

#include <algorithm>

#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kWorstSplits = 3;  // splits that are named

std::string KindInWords(const PartComparison& kind) {
  if (kind.by == SplitBy::kRandom) return "random halves of the configurations";
  if (kind.by == SplitBy::kRegion) return "halves of the workspace (by each joint and by x, y, z of the base)";
  if (kind.by == SplitBy::kStation) return "stations";
  if (kind.by == SplitBy::kMarker) return "markers, each against the others";
  if (kind.by == SplitBy::kLoad) return "loads, each against the others";
  return "the first and the last half of the time";
}

std::string SplitInWords(const PartComparison& split) {
  if (split.by == SplitBy::kTime) return "time";
  if (split.by == SplitBy::kLoad) return "loads " + split.key;
  return split.by == SplitBy::kRegion ? "by " + split.key : split.key;
}

std::string Worst(const AgreementReport& report) {
  std::vector<PartComparison> splits = report.splits;
  std::stable_sort(splits.begin(), splits.end(),
                   [](const auto& a, const auto& b) { return a.inflation > b.inflation; });
  std::string text;
  for (size_t i = 0; i < std::min(kWorstSplits, splits.size()); ++i) {
    text += (text.empty() ? "" : ", ") + SplitInWords(splits[i]) + " " + Significant(splits[i].inflation, 2);
  }
  return text;
}

void DescribeRepeats(const CalibrationProblem& problem, AgreementReport* report) {
  const RepeatFit& repeats = report->repeats;
  if (!repeats.known || repeats.p_value >= problem.experiment().significance) return;
  std::string words =
      "Repeated shots of one arrival agree with each other " + Significant(std::sqrt(repeats.ratio), 2) +
      " times better than the model agrees with them (lack of fit, p = " + Significant(repeats.p_value, 2) +
      "): they share an error, of the robot or of the model, and are not independent.";
  if (report->covariance != CovarianceKind::kSandwich && problem.latent.empty()) {
    words +=
        " Intervals that count them as independent are too short; state repeatability_urad: estimate, or "
        "covariance: sandwich.";
  }
  report->words.push_back(words);
}

// Rows of one arrival share what the joints scatter by: a model of that is right for everything that is computed from
// the estimate, a sandwich for intervals of single parameters.
std::string Advised(const CalibrationProblem& problem) {
  if (!problem.latent.empty()) return "covariance: sandwich is recommended.";
  return "Recommended: repeatability_urad: estimate, for joints that scatter from arrival to arrival; where the "
         "intervals stay too short with it, covariance: sandwich, for single parameters ('sagitta changed' needs "
         "the model's covariance).";
}

void DescribeSandwich(const CalibrationProblem& problem, AgreementReport* report) {
  if (!report->sandwich_advised) return;
  constexpr double kSaid = 2.0;  // standard deviations
  std::string words = "The intervals assume that the rows are independent and alike. ";
  if (report->shared_errors > kSaid) {
    words += "Points of one shot err alike (by " + Significant(report->shared_errors, 2) +
             " standard deviations of chance): the arm is off there, not the instrument. ";
  }
  words += "Judged by whole configurations (covariance: sandwich) they would be " +
           Significant(report->sandwich_ratio, 2) + " times as wide (median)";
  if (report->random_share_model > 0.0) {
    words += "; of the differences between random halves their joint 95 % intervals hold " +
             WholePercent(report->random_share_model) + ", with the sandwich " +
             WholePercent(report->random_share_sandwich);
  }
  report->words.push_back(words + ". " + Advised(problem));
}

}  // namespace

std::string PartsContradict() { return "parts of the data contradict each other; 'sagitta diagnose' may find why"; }

void DescribeAgreement(const CalibrationProblem& problem, AgreementReport* report) {
  report->words.clear();
  DescribeRepeats(problem, report);
  DescribeSandwich(problem, report);
  if (report->kinds.empty()) {
    report->words.push_back("Too few configurations to compare one part of them with another.");
    return;
  }
  std::string shares;
  for (const PartComparison& kind : report->kinds) {
    shares += (shares.empty() ? "" : "; ") + KindInWords(kind) + " " + WholePercent(kind.share()) + " of " +
              std::to_string(kind.compared);
  }
  report->words.push_back(
      "Differences of parameters between parts of the data that lie within their joint 95 % interval: " + shares + ".");
  if (!report->disagrees) {
    report->words.push_back(
        "No part of the data contradicts another: the intervals need no allowance for model error.");
    return;
  }
  report->words.push_back(
      "Parts of the data contradict each other: the model's error differs between them. By noise alone, 95 % of the "
      "differences would need intervals " +
      Significant(report->inflation, 2) + " times as wide (largest: " + Worst(*report) +
      "). What the differences have beyond noise is the variance of the model's error between parts; the 95 % "
      "intervals, the standard deviations and those of predictions carry it. 'sagitta diagnose' may find what the "
      "model lacks.");
}

}  // namespace sagitta
