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
#include "estimator/inspection/sorted_points.h"
#include "estimator/inspection/tried_readings.h"
#include "estimator/inspection/wild_rows.h"
#include "estimator/inspection/wrong_part.h"
#include "estimator/report/inspection_label_words.h"

namespace sagitta {
namespace {

constexpr double kSuspiciousReading = 0.005;  // of the reach: no arm needs that much calibration
constexpr size_t kShown = 6;
constexpr double kLongestArm = 100.0;  // m; of the arms that are built the longest reach some tens
constexpr double kLargestError = 4.0;  // times 5 mm or 1 deg: no arm is made or mastered that badly
constexpr double kMostFarRows = 0.2;   // of all: more are no exceptions

// alike: names of other readings that fit as well.
Finding DescribeReading(const Reading& reading, double misfit, const std::vector<std::string>& alike,
                        bool limits_decide) {
  const std::string words = MisfitOfReading(misfit, reading.misfit, reading.name, alike, limits_decide);
  return {Severity::kSerious, reading.code, words, reading.remedy, {}};
}

Finding Unexplained(const CalibrationProblem& problem, double misfit, double suspicious,
                    const ExplainedErrors& errors) {
  Finding finding = Found(Severity::kSerious, "misfit", MisfitUnexplained(misfit, problem.data().stations.size() == 1));
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
  return DescribeReading(reading, aligned.misfit, {}, false);
}

// A unit that is wrong in the robot or in a column, or points that are all one.
std::optional<Finding> WrongLengths(const CalibrationProblem& problem, const AlignedSample& aligned) {
  double spread = 0.0;
  const bool is_one_point = AreAllOnePoint(problem, &spread);
  std::optional<Finding> robot = is_one_point ? LongRobot(problem, aligned, spread) : std::nullopt;
  if (robot) return robot;
  if (const auto unit = GuessWrongUnit(problem, aligned)) {
    return Finding{Severity::kSerious,
                   "unit",
                   unit->column + ": " + unit->words,
                   unit->hint,
                   {unit->file + ":" + std::to_string(unit->line)}};
  }
  // Metres that are called mm lie within millimetres of each other, too: so this comes last.
  if (is_one_point) return OnePointInWords(spread);
  return std::nullopt;
}

// The other readings of the files, on a sample of the rows.
TriedReadings TryAll(const CalibrationProblem& problem) {
  const CalibrationProblem sampled = SampledProblem(problem);
  return TryReadings(sampled, SampleOfRows(sampled), AllReadings(problem));
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
  if (const std::optional<Finding> length = WrongLengths(problem, aligned)) {
    lint.findings.push_back(*length);
    lint.is_explained = true;
    return lint;
  }
  const TriedReadings reread = TryAll(problem);
  lint.is_explained = reread.simplest.has_value();
  lint.findings.push_back(lint.is_explained ? DescribeReading(reread.all[*reread.simplest], reread.as_stated,
                                                              reread.Alike(), reread.limits_decide)
                                            : Unexplained(problem, lint.misfit, suspicious, errors));
  for (const Reading& reading : reread.BestOf(kShown)) lint.readings.push_back({reading.name, reading.misfit});
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
  const bool is_missed =
      lint.misfit <= suspicious &&  // by the sample
      MissesRows(problem, aligned, problem.data().PointsAmong(problem.CalibrationObservations()), suspicious);
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
  std::optional<WrongPart> part;
  if (lint.is_suspicious) {
    part = FindWrongPart(problem, far_rows);
  } else if (far_rows) {
    part = FindWrongRows(problem, *far_rows);
  }
  if (!part && lint.is_suspicious) {
    if (std::optional<Finding> sorted = FindSortedPoints(problem)) part = WrongPart{std::move(*sorted), {}};
  }
  if (part) {
    lint.findings = {part->finding};
    lint.wrong_rows = part->rows;
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

namespace {

// A mistake that has a name, of all rows: those that are held out judge the calibration, and may have it alone.
std::optional<Finding> MistakeInAllRows(const CalibrationProblem& problem) {
  CalibrationProblem whole = problem;
  for (Configuration& configuration : whole.mutable_data()->configurations) configuration.is_validation = false;
  const ReadingLint lint = LintReadingsOfGoodRows(whole);
  return lint.is_suspicious && lint.is_explained ? std::optional(lint.findings.front()) : std::nullopt;
}

}  // namespace

Plausibility CheckPlausible(const CalibrationProblem& problem, const AlignedSample& aligned) {
  const ReadingLint lint = LintReadingsOfGoodRows(problem, aligned);
  const std::vector<int> held_out = problem.data().PointsAmong(problem.ValidationObservations());
  const bool may_have_more =
      lint.is_suspicious ? lint.is_explained : MissesRows(problem, aligned, held_out, SuspiciousMisfit(problem));
  if (!held_out.empty() && may_have_more) {
    if (const std::optional<Finding> found = MistakeInAllRows(problem)) return {false, *found};
  }
  return lint.is_suspicious ? Plausibility{false, lint.findings.front()} : Plausibility{};
}

ReadingLint LintReadings(const CalibrationProblem& problem) { return LintReadings(problem, AlignedSample(problem)); }

ReadingLint LintReadingsOfGoodRows(const CalibrationProblem& problem) {
  return LintReadingsOfGoodRows(problem, AlignedSample(problem));
}

}  // namespace sagitta
