#include "tools/report/validation_report.h"

#include <numeric>

#include "estimator/report/inspection_words.h"
#include "estimator/validation/unseen.h"
#include "problems/text.h"
#include "tools/report/histograms.h"
#include "tools/report/report_html.h"
#include "tools/report/residual_pictures.h"

namespace sagitta {
namespace {

// Of points; rows that are rotations have no distance.
UnseenPoints DistancesOf(const CalibrationProblem& problem, const Eigen::Matrix3Xd& predicted) {
  std::vector<int> points;
  Eigen::Matrix3Xd errors(3, predicted.cols());
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    const Observation& row = problem.data().observations[i];
    if (!row.is_point() || !row.point_in_station.allFinite()) continue;
    errors.col(static_cast<Eigen::Index>(points.size())) =
        row.point_in_station - predicted.col(static_cast<Eigen::Index>(i));
    points.push_back(static_cast<int>(i));
  }
  return MeasureUnseen(problem, points, errors.leftCols(static_cast<Eigen::Index>(points.size())));
}

Section Head(const KnownRobot& known, const Measurements& rows, const Validation& validation) {
  Section head;
  head.title = (known.robot.name.empty() ? "Robot" : known.robot.name) + ": validation";
  const bool is_off = !(validation.contradiction.empty() && validation.refutation.empty());
  for (const std::string* words : {&validation.contradiction, &validation.refutation}) {
    if (!words->empty()) head.paragraphs.push_back("- " + *words + ".");
  }
  head.paragraphs.push_back((is_off ? "Off by " : "Within ") + InMillimetres(validation.after.distance_rms) +
                            " (RMS; nominal robot " + InMillimetres(validation.before.distance_rms) + ") on " +
                            Plural(static_cast<int>(rows.configurations.size()), "configuration") + ", estimate " +
                            known.file + ".");
  const std::string unread = NotReadInWords(rows.unread_columns);
  if (!unread.empty()) head.paragraphs.push_back(unread);
  return head;
}

Section Residuals(const KnownRobot& known, const Validation& validation) {
  Section section = ResidualSection("Residuals on " + Plural(validation.after.observations, "observation"),
                                    validation.before, validation.after);
  section.paragraphs.push_back("before: the nominal robot, base poses and markers fitted to the calibration rows.");
  if (validation.predicted_rms > 0.0) {
    const double excess = validation.after.rms / validation.predicted_rms;
    section.paragraphs.push_back("Coordinate RMS " + Fixed(1e3 * validation.after.rms, 4) + " mm, predicted " +
                                 Fixed(1e3 * validation.predicted_rms, 4) +
                                 " mm from noise and parameter uncertainty: " + Significant(excess, 2) + " times (" +
                                 PValueInWords(validation.p_value) + ").");
  }
  const std::string carried = WhatFiguresCarry(known);
  if (!carried.empty()) section.paragraphs.push_back(carried);
  for (const std::string& warning : validation.warnings) section.paragraphs.push_back("- " + warning + ".");
  return section;
}

}  // namespace

std::vector<Section> ValidationSections(const KnownRobot& known, const Measurements& rows,
                                        const Validation& validation) {
  return {Head(known, rows, validation), Residuals(known, validation)};
}

std::string ValidationToHtml(const KnownRobot& known, const Measurements& rows, const Validation& validation,
                             const Provenance& provenance) {
  std::vector<Section> sections = ValidationSections(known, rows, validation);
  const CalibrationProblem problem = PredictionProblem(known, rows);
  const DrawnReadings readings(problem, problem.parameters, validation.predicted);
  std::vector<int> all(problem.data().observations.size());
  std::iota(all.begin(), all.end(), 0);
  const Eigen::Matrix3Xd nominal = PredictPoints(problem, NominalParameters(known, problem), all);
  sections.back().pictures = BeforeAndAfter(DistancesOf(problem, nominal), DistancesOf(problem, validation.predicted));
  Section left;
  left.title = "What is left, and where";
  left.paragraphs = {"measured − predicted. All rows are in residuals.csv."};
  left.pictures = {ResidualsOverDrivers(readings), ResidualsInWorkspace(readings)};
  sections.push_back(std::move(left));
  return SectionsToPage(sections, provenance);
}

}  // namespace sagitta
