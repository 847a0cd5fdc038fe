#include "tools/report/calibration_report.h"

#include "tools/report/first_screen.h"
#include "tools/report/histograms.h"
#include "tools/report/parameter_pictures.h"
#include "tools/report/report_html.h"
#include "tools/report/residual_pictures.h"

namespace sagitta {
namespace {

Section WhereTheRestLies(const Calibration& calibration) {
  Section section;
  section.title = "What is left, and where";
  section.paragraphs = {"measured − predicted. All rows are in residuals.csv."};
  const DrawnReadings readings(calibration.problem, calibration.estimate);
  section.pictures = {ResidualsOverDrivers(readings), ResidualsInWorkspace(readings),
                      WhitenedHistogram(calibration.problem, calibration.estimate)};
  return section;
}

Section HowWellKnown(const Estimate& estimate) {
  Section section;
  section.title = "How well each parameter is known";
  section.pictures = KnownParameters(estimate);
  for (Picture& picture : Correlations(estimate)) section.pictures.push_back(std::move(picture));
  return section;
}

}  // namespace

std::vector<Section> CalibrationPage(const Calibration& calibration) {
  std::vector<Section> sections = CalibrationSections(calibration);
  // Between what is read first and what is looked up.
  const auto first = sections.begin() + static_cast<long>(FirstScreen(calibration).size());
  sections.insert(first, {WhereTheRestLies(calibration), HowWellKnown(calibration.estimate)});
  return sections;
}

std::string CalibrationToHtml(const Calibration& calibration, const Provenance& provenance) {
  return SectionsToPage(CalibrationPage(calibration), provenance);
}

}  // namespace sagitta
