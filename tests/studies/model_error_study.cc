// Real robots: does `ci95`, the interval with model error that calibrate gives, hold elsewhere?
//
//   sagitta_model_error_study [simulated=0 [file]]     # file: of one series alone, series_C.csv; series: only against
//                                                      # each other
//
// Every part is calibrated by itself, as `sagitta calibrate` does, and states its own intervals: the halves of a series
// (UR5; UR10 A, B, C, D) above and below the median of each joint and of x, y, z; the UR10's series against each other.
// Counted: geometric errors that both parts estimate and whose difference lies within the root of the sum of the
// squared halves of the two intervals. A value that depends on a held one counts by its unconditional interval.
//
// Each half also predicts the other one's points, as `sagitta predict` does: coordinates within 1.96 standard
// deviations of the sum psig^2 + parm^2 + pnoise^2, with model error in psig and without. Halves by a joint predict
// beyond what that joint measured; three random thirds of the configurations, each predicted by the rest, lie within.
//
// simulated: so many clean data sets of the KR 270 in addition (60 configurations): how often ci95 holds the truth, and
// in how many data sets any of it differs from ci95_noise_only.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>

#include "estimator/sagitta.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/noise_experiment.h"
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

// Points of another part, predicted.
struct Predicted {
  int coordinates = 0, inside = 0, inside_noise_only = 0;
  double squares = 0.0;
  std::vector<double> deviations;  // psig, m
  void Add(const Predicted& other) {
    coordinates += other.coordinates;
    inside += other.inside;
    inside_noise_only += other.inside_noise_only;
    squares += other.squares;
    deviations.insert(deviations.end(), other.deviations.begin(), other.deviations.end());
  }
  void Print(const std::string& what) {
    std::sort(deviations.begin(), deviations.end());
    const double middle = deviations.empty() ? 0.0 : deviations[deviations.size() / 2];
    std::printf(
        "%-28s %5d predicted coordinates, within 95 %% %5.1f %%, without model error %5.1f %%; RMS %.3f mm, "
        "median psig %.3f mm\n",
        what.c_str(), coordinates, 100.0 * inside / std::max(1, coordinates),
        100.0 * inside_noise_only / std::max(1, coordinates), 1e3 * std::sqrt(squares / std::max(1, coordinates)),
        1e3 * middle);
    std::fflush(stdout);
  }
};

// Rows of `part` that were excluded, by the calibration of the others.
Predicted PredictTheRest(const Calibration& part) {
  Measurements rows = part.problem.data();
  for (Observation& observation : rows.observations) observation.excluded = false;
  Calibration noise_only = part;
  noise_only.trust.between = {};
  noise_only.trust.excess = 1.0;
  const Prediction with = Predict(KnownFrom(part), rows), without = Predict(KnownFrom(noise_only), rows);
  Predicted found;
  for (size_t k = 0; k < rows.observations.size(); ++k) {
    if (!part.problem.data().observations[k].excluded) continue;
    const auto column = static_cast<Eigen::Index>(k);
    const Vector3<double> error = rows.observations[k].point_in_station - with.points.col(column);
    const Matrix3<double> reading = with.covariances[k].arm + with.instrument[k] * with.instrument[k].transpose();
    for (int axis = 0; axis < 3; ++axis) {
      const auto is_inside = [&](const Prediction& by) {
        return std::abs(error[axis]) <=
               NormalQuantile(0.975) * std::sqrt(by.covariances[k].mean()(axis, axis) + reading(axis, axis));
      };
      ++found.coordinates;
      found.inside += is_inside(with);
      found.inside_noise_only += is_inside(without);
      found.squares += error[axis] * error[axis];
      found.deviations.push_back(std::sqrt(with.covariances[k].mean()(axis, axis)));
    }
  }
  return found;
}

double HalfWidth(const Interval& interval) { return 0.5 * (interval.high - interval.low); }

Tally Compare(const Calibration& a, const Calibration& b) {
  Tally tally;
  for (size_t i = 0; i < a.estimate.table.size(); ++i) {
    const ParameterEstimate& p = a.estimate.table[i];
    if (p.name.rfind("geometry/", 0) != 0) continue;
    const auto other = std::find_if(b.estimate.table.begin(), b.estimate.table.end(),
                                    [&](const auto& row) { return row.name == p.name; });
    if (other == b.estimate.table.end() || !p.free || !other->free) continue;
    const bool depends = p.conditional || other->conditional;
    const auto half = [depends](const ParameterEstimate& row) {
      return HalfWidth(depends ? row.unconditional_ci95 : row.ci95);
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
  for (Observation& observation : problem.mutable_data()->observations) observation.excluded |= !use(observation);
  return problem;
}

// Halves by a joint (0, 1, …) or, beyond them, by x, y, z.
Tally Halves(const CalibrationProblem& problem, int by, Predicted* predicted) {
  const int joints = problem.robot().chain.num_joints();
  const auto value_of = [&](const Observation& observation) {
    return by < joints ? problem.data().ConfigurationOf(observation).q[by] : observation.point_in_station[by - joints];
  };
  std::vector<double> values;
  for (const Observation& observation : problem.data().observations) values.push_back(value_of(observation));
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  const double middle = values[values.size() / 2];
  const auto half = [&](bool above) {
    return Calibrate(
        Part(problem, [&](const Observation& observation) { return (value_of(observation) >= middle) == above; }));
  };
  const Calibration low = half(false), high = half(true);
  if (!IsUsable(low.estimate.status) || !IsUsable(high.estimate.status)) return {};
  for (const Calibration* part : {&low, &high}) predicted->Add(PredictTheRest(*part));
  return Compare(low, high);
}

// Every third configuration, in an order by chance, by the calibration of the others; three times.
Predicted RandomThirds(const CalibrationProblem& problem) {
  Predicted predicted;
  std::vector<size_t> order(problem.data().configurations.size());
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 generator(1);
  for (size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[generator() % (i + 1)]);
  std::vector<size_t> third(order.size());
  for (size_t k = 0; k < order.size(); ++k) third[order[k]] = k % 3;
  for (size_t t = 0; t < 3; ++t) {
    const Calibration rest = Calibrate(
        Part(problem, [&](const Observation& o) { return third[problem.data().shots[o.shot].configuration] != t; }));
    if (IsUsable(rest.estimate.status)) predicted.Add(PredictTheRest(rest));
  }
  return predicted;
}

void StudyClean(int trials) {
  test::Kr270Design design;
  design.configurations = 60;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  const test::Kr270Truth truth;
  int inside = 0, inside_noise_only = 0, compared = 0, wide = 0;
  for (int t = 0; t < trials; ++t) {
    test::MeasureKr270(truth, design.sigma, 9000 + t, &data);
    const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
    const Calibration result = Calibrate(problem);
    const auto holds = [](const Interval& interval, double value) {
      return interval.low <= value && value <= interval.high;
    };
    wide += result.trust.model_error > 1.0;
    for (const int i : result.estimate.estimated) {
      const double value = result.estimate.table[i].value - test::NoiseErrorOf(result.estimate, truth, i);
      ++compared;
      inside += holds(result.estimate.table[i].ci95, value);
      inside_noise_only += holds(result.trust.ci95_noise_only[i], value);
    }
  }
  std::printf("clean: %d data sets, %d intervals: ci95 holds %.2f %%, ci95_noise_only %.2f %%; they differ in %d\n",
              trials, compared, 100.0 * inside / std::max(1, compared),
              100.0 * inside_noise_only / std::max(1, compared), wide);
}

}  // namespace

int main(int argc, char** argv) {
  const int simulated = argc > 1 ? std::atoi(argv[1]) : 0;
  if (simulated > 0) StudyClean(simulated);
  if (!test::HasRealData()) {
    std::printf("no ../shared/data: nothing to study\n");
    return 0;
  }
  const std::string asked = argc > 2 ? argv[2] : "";
  Tally regions, series;
  Predicted points, thirds;
  std::vector<Calibration> alone;
  for (const auto& [folder, file] : {std::pair<const char*, const char*>{"ur5_gts3800", "measurements.csv"},
                                     {"ur10_leica", "series_A.csv"},
                                     {"ur10_leica", "series_B.csv"},
                                     {"ur10_leica", "series_C.csv"},
                                     {"ur10_leica", "series_D.csv"}}) {
    if (!asked.empty() && asked != "series" && asked != file) continue;
    const CalibrationProblem problem = test::RealProblem(folder, {file}, Experiment());
    if (asked != "series") {
      Tally own;
      Predicted of_halves;
      for (int by = 0; by < problem.robot().chain.num_joints() + 3; ++by) own.Add(Halves(problem, by, &of_halves));
      own.Print(std::string("halves of ") + folder + " " + file);
      of_halves.Print("  the other half");
      Predicted of_thirds = RandomThirds(problem);
      of_thirds.Print("  a random third");
      thirds.Add(of_thirds);
      regions.Add(own);
      points.Add(of_halves);
    }
    if (std::string(folder) == "ur10_leica") alone.push_back(Calibrate(problem));
  }
  for (size_t a = 0; a < alone.size(); ++a) {
    for (size_t b = a + 1; b < alone.size(); ++b) {
      const Tally own = Compare(alone[a], alone[b]);
      own.Print(alone[a].problem.data().stations[0] + " against " + alone[b].problem.data().stations[0]);
      series.Add(own);
    }
  }
  points.Print("the other half");
  thirds.Print("a random third");
  regions.Print("between regions");
  series.Print("between series");
  return 0;
}
