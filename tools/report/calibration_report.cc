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
  section.pictures.push_back(ResidualsOverDrivers(readings));
  section.pictures.push_back(ResidualsInWorkspace(readings));
  section.pictures.push_back(WhitenedHistogram(calibration.problem, calibration.estimate));
  return section;
}

Section HowWellKnown(const Estimate& estimate) {
  Section section;
  section.title = "How well each parameter is known";
  section.pictures = KnownParameters(estimate);
  for (Picture& picture : Correlations(estimate)) section.pictures.push_back(std::move(picture));
  return section;
}

// Between what is read first and what is looked up.
std::vector<Section> WithPictures(std::vector<Section> sections, const Calibration& calibration) {
  const auto first = static_cast<long>(SizeOfFirstScreen(calibration));
  sections.insert(sections.begin() + first, WhereTheRestLies(calibration));
  sections.insert(sections.begin() + first + 1, HowWellKnown(calibration.estimate));
  return sections;
}

}  // namespace

std::vector<Section> CalibrationPage(const Calibration& calibration) {
  return WithPictures(CalibrationSections(calibration), calibration);
}

std::string CalibrationToHtml(const Calibration& calibration, const Provenance& provenance) {
  return CalibrationToHtml(calibration, CalibrationSections(calibration), provenance);
}

std::string CalibrationToHtml(const Calibration& calibration, std::vector<Section> sections,
                              const Provenance& provenance) {
  return SectionsToPage(WithPictures(std::move(sections), calibration), provenance);
}

}  // namespace sagitta
