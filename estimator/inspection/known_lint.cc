#include "estimator/inspection/known_lint.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/calibration/unit_guess.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/report/inspection_known_words.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

// Times the expected RMS distance: three coordinates that share one held value exceed 4 standard deviations in 1 of
// 16000 cases, and their RMS is at least one of them.
constexpr double kBeyondExpected = 4.0;
constexpr size_t kFewestAlone = 3;  // rows of one marker and station that are off alone: of fewer the rows are bad
constexpr size_t kEquationsPerPlaceNumber = 2;  // from here on a fit of places alone says something

bool HasPoint(const Observation& row) { return row.is_point() && row.IsRead() && !row.excluded; }

// Base poses and markers alone are unknown, and only what was read counts.
CalibrationProblem WithFreePlaces(const CalibrationProblem& known) {
  CalibrationProblem problem = known;
  for (Observation& row : problem.mutable_data()->observations)
    row.excluded |= !(row.point_in_station.allFinite() && row.rotation().in_station.allFinite());
  for (int i = 0; i < problem.parameters.num_coordinates(); ++i) {
    Coordinate& coordinate = problem.parameters.coordinate(i);
    coordinate.free = problem.parameters.blocks()[coordinate.block].kind != BlockKind::kModelParameter;
  }
  return problem;
}

}  // namespace

KnownMisfit MisfitOfKnown(const Chain& chain, const Measurements& rows, const Eigen::Matrix3Xd& predicted,
                          const std::vector<double>& expected) {
  struct Pair {
    std::vector<double> distances;
    size_t far = 0;
  };
  const double suspicious = SuspiciousMisfit(chain);
  KnownMisfit misfit;
  std::vector<double> all;
  std::map<std::pair<int, int>, Pair> of_pair;  // station and marker
  for (size_t i = 0; i < rows.observations.size(); ++i) {
    const Observation& row = rows.observations[i];
    if (!HasPoint(row)) continue;
    all.push_back((row.point_in_station - predicted.col(static_cast<Eigen::Index>(i))).norm());
    Pair& pair = of_pair[{rows.shots[row.shot].station, row.marker}];
    pair.distances.push_back(all.back());
    if (!(all.back() > suspicious) || (!expected.empty() && all.back() <= kBeyondExpected * expected[i])) continue;
    ++pair.far;
    if (misfit.far.empty()) misfit.first = all.back();
    misfit.far.push_back(static_cast<int>(i));
  }
  if (misfit.far.empty()) return misfit;
  misfit.median = Median(all);
  misfit.is_far = 2 * misfit.far.size() > all.size();
  for (const auto& [labels, pair] : of_pair) {
    if (misfit.is_far || pair.distances.size() < kFewestAlone || 2 * pair.far <= pair.distances.size()) continue;
    misfit.is_far = true;
    misfit.median = Median(pair.distances);
    std::tie(misfit.station, misfit.marker) = labels;
  }
  return misfit;
}

Finding ExplainKnown(const CalibrationProblem& known, const KnownMisfit& misfit) {
  if (misfit.station >= 0) {
    return Found(Severity::kSerious, "label_stands_elsewhere",
                 LabelStandsElsewhere(known.data().markers[misfit.marker], known.data().stations[misfit.station],
                                      misfit.median));
  }
  const CalibrationProblem free = WithFreePlaces(known);
  if (3 * SampleOfRows(free).size() < kEquationsPerPlaceNumber * free.parameters.EstimatedCoordinates().size())
    return Found(Severity::kSerious, "not_these_readings", NotTheseReadings(misfit.median));
  const AlignedSample aligned(free);
  const double fitted = aligned.misfit;
  if (fitted <= SuspiciousMisfit(free))
    return Found(Severity::kSerious, "stands_elsewhere", StandsElsewhere(misfit.median, fitted));
  if (const std::optional<UnitFinding> unit = GuessWrongUnit(free, aligned)) {
    const std::string why = unit->column + ": " + unit->words;
    return {Severity::kSerious, "unit", MissesAndWhy(misfit.median, why), unit->hint, {}};
  }
  const ReadingLint lint = LintReadingsOfGoodRows(free, aligned);
  if (!lint.is_explained) return Found(Severity::kSerious, "not_this_robot", NotThisRobot(misfit.median, fitted));
  Finding finding = lint.findings.front();
  finding.words = MissesAndWhy(misfit.median, finding.words);
  return finding;
}

}  // namespace sagitta
