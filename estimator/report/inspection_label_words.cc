#include "estimator/report/inspection_label_words.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "models/constants.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kMostRowsShown = 1000;  // rows

// "S2 in place of S1 in 30 rows, S1 in place of S2 in 12"
std::string StationsInWords(const CalibrationProblem& problem, const OtherLabel& found) {
  std::map<std::pair<std::string, std::string>, size_t> counts;
  for (size_t k = 0; k < found.far.size(); ++k) {
    const Observation& row = problem.data().observations[found.far[k]];
    ++counts[{problem.data().stations[problem.data().shots[row.shot].station], found.fits_of_row[k]}];
  }
  std::vector<std::string> listed;
  for (const auto& [labels, count] : counts) {
    listed.push_back("station " + labels.second + " in place of " + labels.first +
                     (counts.size() > 1 ? " in " + std::to_string(count) + (count == 1 ? " row" : " rows") : ""));
  }
  return Enumerate(listed);
}

}  // namespace

Finding OnePointInWords(double spread) {
  return {Severity::kSerious,
          "one_point",
          "the measured points are all the same within " + Significant(1e3 * spread, 2) +
              " mm (RMS), while the joints move the marker",
          "check the columns x, y, z: was one reading copied into all rows?",
          {}};
}

Finding OtherLabelInWords(const CalibrationProblem& problem, const OtherLabel& found) {
  const auto source = [&](int i) { return problem.data().SourceOf(problem.data().observations[i]); };
  const auto percent = std::lround(100.0 * static_cast<double>(found.far.size()) / static_cast<double>(found.rows));
  const std::string rows = std::to_string(found.far.size()) + " of " + std::to_string(found.rows) + " rows (" +
                           std::to_string(percent) + " %) are off, half of them by more than " +
                           InMillimetres(found.far_median) + ", and fit as the others do ";
  const std::string where = "; the first: " + source(found.far.front()) + ", the last: " + source(found.far.back());
  Finding finding{Severity::kSerious, "", rows, "", {}};
  switch (found.kind) {
    case OtherLabel::Kind::kOtherStation:
      finding.code = "station_label";
      finding.words += "with " + StationsInWords(problem, found) + ": their station labels are wrong";
      finding.remedy = "correct the column station in these rows" + where;
      break;
    case OtherLabel::Kind::kOtherMarker:
      finding.code = "marker_label";
      finding.words += "with marker " + found.fits + " in place of " + found.stated;
      finding.remedy = "exchange the marker names of these rows" + where;
      break;
    case OtherLabel::Kind::kOwnStation:
      finding.code = "station_moved";
      finding.words += "if they were read by another station than the others of " + found.stated + ", " +
                       InMillimetres(found.moved) + " and " + Significant(found.turned / kDegree, 2) +
                       " deg away from it";
      if (found.first_after >= 0) {
        finding.words = "between " + source(found.last_before) + " and " + source(found.first_after) + " station " +
                        found.stated +
                        " or the robot's foot moved, or rows of two stations were put together: " + finding.words;
      }
      finding.remedy = "give these rows a station of their own (column station)" + where;
      break;
    case OtherLabel::Kind::kOwnMarker:
      finding.code = "marker_moved";
      finding.words += "if they are of another marker than the others of " + found.stated + ", " +
                       InMillimetres(found.moved) + " away from it";
      finding.remedy = "give these rows a marker name of their own" + where;
      break;
    case OtherLabel::Kind::kOtherFrame:
      finding.code = "marker_frame";
      finding.words = "marker " + found.stated + " misses by " + InMillimetres(found.far_median) +
                      " (RMS) on what it is said to be on (the flange where nothing is said), by " +
                      InMillimetres(found.moved) + " on " + found.fits +
                      (found.place.kind == MarkerPlace::Kind::kBase ? "" : ", the link that this joint moves");
      finding.remedy = "state markers: {" + found.stated + ": {on: " + found.fits +
                       "}} in the experiment file (import: --on=" + found.stated + "=" + found.fits + ")" + where;
      break;
  }
  for (size_t k = 0; k < std::min(kMostRowsShown, found.far.size()); ++k) finding.rows.push_back(source(found.far[k]));
  return finding;
}

}  // namespace sagitta
