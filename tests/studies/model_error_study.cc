// Real robots: does `ci95`, the interval with model error that calibrate gives, hold elsewhere?
//
//   sagitta_model_error_study
//
// Every part is calibrated by itself, as `sagitta calibrate` does, and states its own intervals: the halves of a series
// (UR5; UR10 A, B, C, D) above and below the median of each joint and of x, y, z; the UR10's series against each other.
// Counted: geometric errors that both parts estimate and whose difference lies within the root of the sum of the
// squared halves of the two intervals. A value tied to a held one counts by its unconditional interval.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "estimator/sagitta.h"
#include "tests/support/real_data.h"

namespace {

using namespace sagitta;  // NOLINT: a program of two pages

struct Tally {
  int compared = 0, inside = 0, inside_noise_only = 0;
  void Add(const Tally& other) {
    compared += other.compared;
    inside += other.inside;
    inside_noise_only += other.inside_noise_only;
  }
  void Print(const std::string& what) const {
    std::printf("%-28s %5d differences, within ci95 %5.1f %%, within ci95_noise_only %5.1f %%\n", what.c_str(),
                compared, 100.0 * inside / std::max(1, compared), 100.0 * inside_noise_only / std::max(1, compared));
    std::fflush(stdout);
  }
};

double HalfWidth(const Interval& interval) { return 0.5 * (interval.high - interval.low); }

Tally Compare(const Calibration& a, const Calibration& b) {
  Tally tally;
  for (size_t i = 0; i < a.estimate.table.size(); ++i) {
    const ParameterEstimate& p = a.estimate.table[i];
    if (p.name.rfind("geometry/", 0) != 0) continue;
    const auto other = std::find_if(b.estimate.table.begin(), b.estimate.table.end(),
                                    [&](const auto& row) { return row.name == p.name; });
    if (other == b.estimate.table.end() || !p.free || !other->free) continue;
    const bool is_tied = p.tied || other->tied;
    const auto half = [is_tied](const ParameterEstimate& row) {
      return HalfWidth(is_tied ? row.unconditional_ci95 : row.ci95);
    };
    const double difference = std::abs(p.value - other->value);
    const size_t k = other - b.estimate.table.begin();
    ++tally.compared;
    tally.inside += difference <= std::hypot(half(p), half(*other));
    tally.inside_noise_only +=
        difference <= std::hypot(HalfWidth(a.trust.ci95_noise_only[i]), HalfWidth(b.trust.ci95_noise_only[k]));
  }
  return tally;
}

CalibrationProblem Part(CalibrationProblem problem, const std::function<bool(const Observation&)>& use) {
  for (Observation& observation : problem.data.observations) observation.excluded |= !use(observation);
  return problem;
}

// Halves by a joint (0, 1, …) or, beyond them, by x, y, z.
Tally Halves(const CalibrationProblem& problem, int by) {
  const int joints = problem.robot.chain.num_joints();
  const auto value_of = [&](const Observation& observation) {
    return by < joints ? problem.data.ConfigurationOf(observation).q[by] : observation.point_in_station[by - joints];
  };
  std::vector<double> values;
  for (const Observation& observation : problem.data.observations) values.push_back(value_of(observation));
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  const double middle = values[values.size() / 2];
  const auto half = [&](bool above) {
    return Calibrate(
        Part(problem, [&](const Observation& observation) { return (value_of(observation) >= middle) == above; }));
  };
  const Calibration low = half(false), high = half(true);
  return IsUsable(low.estimate.status) && IsUsable(high.estimate.status) ? Compare(low, high) : Tally();
}

}  // namespace

int main() {
  if (!test::HasRealData()) {
    std::printf("no ../shared/data: nothing to study\n");
    return 0;
  }
  Tally regions, series;
  std::vector<Calibration> alone;
  for (const auto& [folder, file] : {std::pair<const char*, const char*>{"ur5_gts3800", "measurements.csv"},
                                     {"ur10_leica", "series_A.csv"},
                                     {"ur10_leica", "series_B.csv"},
                                     {"ur10_leica", "series_C.csv"},
                                     {"ur10_leica", "series_D.csv"}}) {
    const CalibrationProblem problem = test::RealProblem(folder, {file}, Experiment());
    Tally own;
    for (int by = 0; by < problem.robot.chain.num_joints() + 3; ++by) own.Add(Halves(problem, by));
    own.Print(std::string("halves of ") + folder + " " + file);
    regions.Add(own);
    if (std::string(folder) == "ur10_leica") alone.push_back(Calibrate(problem));
  }
  for (size_t a = 0; a < alone.size(); ++a) {
    for (size_t b = a + 1; b < alone.size(); ++b) {
      const Tally own = Compare(alone[a], alone[b]);
      own.Print(alone[a].problem.data.stations[0] + " against " + alone[b].problem.data.stations[0]);
      series.Add(own);
    }
  }
  regions.Print("between regions");
  series.Print("between series");
  return 0;
}
