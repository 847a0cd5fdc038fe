#include "estimator/inspection/reading_lint.h"

#include <algorithm>
#include <cmath>

#include "estimator/calibration/unit_guess.h"
#include "estimator/inspection/data_lint.h"
#include "estimator/inspection/explained_errors.h"
#include "estimator/inspection/linear_state.h"
#include "estimator/inspection/moved_rows.h"
#include "estimator/inspection/other_label.h"
#include "estimator/inspection/readings.h"
#include "estimator/inspection/rotation_lint.h"
#include "estimator/inspection/sampled_problem.h"
#include "estimator/inspection/wild_rows.h"
#include "estimator/report/inspection_label_words.h"
#include "models/constants.h"

namespace sagitta {
namespace {

constexpr double kSuspiciousReading = 0.005;  // of the reach: no arm needs that much calibration
constexpr double kReadingImprovement = 5.0;
constexpr double kAsGood = 1.1;    // readings that fit alike: the simplest is named
constexpr double kPerfect = 1e-4;  // of the reach: no better fit means anything
constexpr size_t kShown = 6;
constexpr size_t kMostAlike = 2;
constexpr double kLongestArm = 100.0;  // m; of the arms that are built the longest reach some tens
constexpr double kLargestError = 4.0;  // times 5 mm or 1 deg: no arm is made or mastered that badly
constexpr double kMostFarRows = 0.2;   // of all: more are no exceptions

// alike: names of other readings that fit as well.
Finding DescribeReading(const Reading& reading, double misfit, const std::vector<std::string>& alike) {
  const std::string words = MisfitOfReading(misfit, reading.misfit, reading.name, alike);
  return {Severity::kSerious, reading.code, words, reading.remedy, {}};
}

Finding Unexplained(const CalibrationProblem& problem, double misfit, double suspicious,
                    const ExplainedErrors& errors) {
  Finding finding = Found(Severity::kSerious, "misfit", MisfitUnexplained(misfit));
  for (const MeasuredRange& range : StillJointsOf(problem))
    finding.words += "; " + JointStands(problem.robot().chain.joints[range.joint], range.least, range.most);
  if (errors.left <= suspicious) {
    finding.words += ErrorsThatWouldExplain(errors.value, errors.quantity == Quantity::kLength, errors.largest);
  }
  return finding;
}

// Next to a robot whose lengths are 1000 times too large any points are nearly one: then the robot in millimetres fits
// them, and far better than their own mean does.
std::optional<Finding> LongRobot(const CalibrationProblem& problem, const AlignedSample& aligned, double spread) {
  if (Reach(problem.robot().chain) < kLongestArm) return std::nullopt;  // rather the points are in another unit
  Reading reading = RobotInMillimetres(problem);
  reading.misfit = AlignedMisfit(Reread(problem, reading), aligned.rows);
  const bool fits = reading.misfit <= SuspiciousMisfit(reading.robot->chain);
  if (!fits || !(reading.misfit * kReadingImprovement < spread)) return std::nullopt;
  return DescribeReading(reading, aligned.misfit, {});
}

}  // namespace

double SuspiciousMisfit(const Chain& chain) { return kSuspiciousReading * Reach(chain); }
double SuspiciousMisfit(const CalibrationProblem& problem) { return kSuspiciousReading * Reach(problem); }

ReadingLint LintReadings(const CalibrationProblem& problem, const AlignedSample& aligned) {
  ReadingLint lint;
  const double suspicious = SuspiciousMisfit(problem);
  lint.misfit = aligned.misfit;
  lint.readings.push_back({"as stated", lint.misfit});
  if (lint.misfit <= suspicious) return lint;
  const ExplainedErrors errors = ExplainByErrors(problem, aligned.rows);
  lint.is_suspicious = !(errors.left <= suspicious && errors.relative <= kLargestError);
  if (!lint.is_suspicious) return lint;
  double spread = 0.0;
  const bool is_one_point = AreAllOnePoint(problem, &spread);
  const std::optional<Finding> robot = is_one_point ? LongRobot(problem, aligned, spread) : std::nullopt;
  // Metres that are called mm lie within millimetres of each other, too.
  const auto unit = robot ? std::nullopt : GuessWrongUnit(problem, aligned);
  if (robot) {
    lint.findings.push_back(*robot);
  } else if (unit) {
    lint.findings.push_back({Severity::kSerious,
                             "unit",
                             unit->column + ": " + unit->words,
                             unit->hint,
                             {unit->file + ":" + std::to_string(unit->line)}});
  } else if (is_one_point) {
    lint.findings.push_back(OnePointInWords(spread));
  }
  lint.is_explained = !lint.findings.empty();
  if (lint.is_explained) return lint;
  std::vector<Reading> readings = AllReadings(problem);
  const CalibrationProblem sampled = SampledProblem(problem);
  const std::vector<int> some = SampleOfRows(sampled);
  const double as_stated = AlignedMisfit(sampled, some);
  for (Reading& reading : readings) {
    const CalibrationProblem reread = Reread(sampled, reading);
    std::vector<int> rows;
    for (const int i : some) {
      if (!reread.data().observations[i].excluded) rows.push_back(i);
    }
    reading.misfit = AlignedMisfit(reread, rows);
    // Some readings leave rows out. Where those were what did not fit, the others fit as stated as well.
    const bool leaves_out = rows.size() < some.size();
    if (leaves_out && reading.misfit * kReadingImprovement >= AlignedMisfit(sampled, rows)) reading.misfit = as_stated;
  }
  double least = as_stated;
  for (const Reading& reading : readings) least = std::min(least, reading.misfit);
  const double best = std::max(kPerfect * Reach(problem), kAsGood * least);
  const auto simplest =
      std::find_if(readings.begin(), readings.end(), [&](const Reading& reading) { return reading.misfit <= best; });
  const bool explains = simplest != readings.end() && simplest->misfit * kReadingImprovement < as_stated;
  lint.is_explained = explains;
  std::vector<std::string> alike;
  for (auto other = simplest; explains && ++other != readings.end() && alike.size() < kMostAlike;) {
    if (other->misfit <= best) alike.push_back(other->name);
  }
  lint.findings.push_back(explains ? DescribeReading(*simplest, as_stated, alike)
                                   : Unexplained(problem, lint.misfit, suspicious, errors));
  std::stable_sort(readings.begin(), readings.end(),
                   [](const Reading& a, const Reading& b) { return a.misfit < b.misfit; });
  for (size_t i = 0; i < std::min(kShown, readings.size()); ++i)
    lint.readings.push_back({readings[i].name, readings[i].misfit});
  return lint;
}

ReadingLint LintReadingsOfGoodRows(const CalibrationProblem& problem, const AlignedSample& aligned) {
  ReadingLint lint = LintReadings(problem, aligned);
  if (lint.is_explained) return lint;
  if (const std::optional<Finding> rotations = LintRotations(problem)) {
    lint.findings = {*rotations};
    lint.is_suspicious = lint.is_explained = true;
    return lint;
  }
  const double suspicious = SuspiciousMisfit(problem);
  const bool is_missed = lint.misfit <= suspicious && MissesAllRows(problem, aligned, suspicious);  // by the sample
  if (!lint.is_suspicious && !is_missed) return lint;
  std::optional<OtherLabel> other = FindOtherFrame(problem);
  std::optional<FarRows> far_rows;
  if (!other) far_rows = FindFarRows(problem);
  if (far_rows) other = FindOtherLabel(problem, *far_rows);
  if (!other && lint.is_suspicious) {
    if (const std::optional<FarRows> moved = FindMovedRows(problem)) other = FindOtherLabel(problem, *moved);
  }
  if (other) {
    lint.findings = {OtherLabelInWords(problem, *other)};
    lint.is_suspicious = lint.is_explained = true;
    return lint;
  }
  if (!lint.is_suspicious) return lint;
  std::vector<Finding> rows;
  const CalibrationProblem sampled = SampledProblem(problem);
  const LinearState state = Align(sampled, false, &rows);
  const size_t all = sampled.CalibrationObservations().size();
  const size_t far = all - state.problem.CalibrationObservations().size();
  if (far > 0 && far <= kMostFarRows * all) {
    ReadingLint good = LintReadings(state.problem);
    if (!good.is_suspicious || good.is_explained) return good;
  }
  if (!far_rows) return lint;
  if (const std::optional<Finding> wild = FindWildRows(problem, *far_rows)) lint.findings.front() = *wild;
  return lint;
}

Plausibility CheckPlausible(const CalibrationProblem& problem, const AlignedSample& aligned) {
  const ReadingLint lint = LintReadingsOfGoodRows(problem, aligned);
  if (!lint.is_suspicious) return {};
  return {false, lint.findings.front()};
}

ReadingLint LintReadings(const CalibrationProblem& problem) { return LintReadings(problem, AlignedSample(problem)); }

ReadingLint LintReadingsOfGoodRows(const CalibrationProblem& problem) {
  return LintReadingsOfGoodRows(problem, AlignedSample(problem));
}

Plausibility CheckPlausible(const CalibrationProblem& problem) {
  return CheckPlausible(problem, AlignedSample(problem));
}

}  // namespace sagitta
