#include "estimator/alignment/aligned_misfit.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/alignment/starting_values.h"

namespace sagitta {
namespace {

constexpr int kRowsPerPair = 40;  // of a station and marker: enough to tell a wrong unit

}  // namespace

double Reach(const Chain& chain) {
  double reach = 0.0;
  for (const ElementaryTransform& transform : chain.transforms) {
    if (!transform.is_rotation()) reach += std::abs(transform.nominal);
  }
  return reach;
}

std::vector<int> SampleOfRows(const CalibrationProblem& problem) {
  std::map<std::pair<int, int>, std::vector<int>> pairs;
  for (const int i : problem.CalibrationObservations()) {
    const Observation& observation = problem.data.observations[i];
    pairs[{problem.data.shots[observation.shot].station, observation.marker}].push_back(i);
  }
  std::vector<int> sample;
  for (const auto& [pair, all] : pairs) {
    const size_t n = std::min<size_t>(kRowsPerPair, all.size());
    for (size_t k = 0; k < n; ++k) sample.push_back(all[k * all.size() / n]);
  }
  std::sort(sample.begin(), sample.end());
  return sample;
}

double AlignedMisfit(const CalibrationProblem& problem, const std::vector<int>& rows) {
  ParameterSet parameters = problem.parameters;
  return FindStartingValues(problem, rows, StartingValueOptions(), &parameters);
}

std::string WholeMillimetres(double metres) { return std::to_string(std::lround(1e3 * metres)) + " mm"; }

}  // namespace sagitta
