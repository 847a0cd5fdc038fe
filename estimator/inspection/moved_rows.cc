#include "estimator/inspection/moved_rows.h"

#include <algorithm>
#include <utility>

#include "estimator/alignment/starting_values.h"
#include "estimator/inspection/reading_lint.h"

namespace sagitta {
namespace {

// Rows of a half: 18 numbers, twice as many as a base pose and one marker have.
constexpr std::ptrdiff_t kFewestOfHalf = 6;

// rows: of one station, in order; half: some of them.
std::optional<FarRows> BlockOfHalf(const CalibrationProblem& problem, const std::vector<int>& rows,
                                   const std::vector<int>& half) {
  if (MarkersOfRows(problem.data(), half) != MarkersOfRows(problem.data(), rows)) return std::nullopt;
  ParameterSet parameters = problem.parameters;
  const double rms = FindStartingValues(problem, half, &parameters);
  if (!(rms <= SuspiciousMisfit(problem))) return std::nullopt;
  const double limit = kNearHalf * rms;
  const std::vector<double> distances = DistancesFromPoints(problem, rows, parameters);
  int changes = 0;
  for (size_t k = 1; k < rows.size(); ++k) changes += (distances[k] > limit) != (distances[k - 1] > limit) ? 1 : 0;
  if (changes != 1) return std::nullopt;
  return SplitByDistance(rows, distances, limit, std::move(parameters));
}

}  // namespace

std::vector<int> InOrderOfMeasurement(const Measurements& data, std::vector<int> rows) {
  const auto shot = [&](int i) -> const Shot& { return data.shots[data.observations[i].shot]; };
  if (!std::all_of(rows.begin(), rows.end(), [&](int i) { return shot(i).has_time; })) return rows;
  std::stable_sort(rows.begin(), rows.end(), [&](int a, int b) { return shot(a).time < shot(b).time; });
  return rows;
}

std::optional<FarRows> FindMovedRows(const CalibrationProblem& problem) {
  const std::vector<int> points = problem.data().PointsAmong(problem.CalibrationObservations());
  for (const auto& [station, listed] : ByStation(problem.data(), points)) {
    const std::vector<int> rows = InOrderOfMeasurement(problem.data(), listed);
    const auto middle = static_cast<std::ptrdiff_t>(rows.size() / 2);
    if (middle < kFewestOfHalf) continue;
    for (const bool is_first : {true, false}) {
      const std::vector<int> half(is_first ? rows.begin() : rows.begin() + middle,
                                  is_first ? rows.begin() + middle : rows.end());
      if (std::optional<FarRows> found = BlockOfHalf(problem, rows, half)) return found;
    }
  }
  return std::nullopt;
}

}  // namespace sagitta
