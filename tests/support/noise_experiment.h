// A KR-270 whose noise is known: joints that arrive a little off, trackers that
// read ranges and angles, and gross errors. Points come from the generator of
// kr270_experiment.h, nothing from models/ or problems/noise_model.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <set>

#include "estimator/calibration/noise_loop.h"
#include "models/quantiles.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/random_vector.h"

namespace sagitta::test {

// 18 configurations, 3 markers, 9 repeats. The markers of one arrival share the joints' deviations.
struct RepeatDesign {
  int configurations = 18;
  int repeats = 9;
  bool reapproached = false;  // every repeat is an arrival of its own
  double joint = 37e-6;       // rad: 60 um per axis at the flange of this arm
  double tracker = 1e-5;      // m per axis
  std::uint64_t seed = 1;     // of the configurations
};

inline Measurements RepeatRows(const RepeatDesign& design) {
  Kr270Design once;
  once.configurations = design.configurations;
  once.stations = 1;
  once.seed = design.seed;
  once.sigma = design.tracker;
  Measurements data = DesignMeasurements(once);
  const std::vector<Shot> shots = data.shots;
  data.shots.clear();
  data.observations.clear();
  data.files[0].rows.clear();
  for (const Shot& first : shots) {
    for (int r = 0; r < design.repeats; ++r) {
      Shot shot = first;
      (design.reapproached ? shot.visit : shot.repeat) = std::to_string(r + 1);
      AddShot(shot, 3, design.tracker, &data);
    }
  }
  return data;
}

// Deviation of every joint (rad) that moves a coordinate of the markers by `per_axis` (m) RMS at these configurations:
// per_axis^2 = joint^2 mean_k tr(D_k D_k') / 3, D_k by differences.
inline double JointDeviationFor(double per_axis, const Kr270Truth& truth, const Measurements& data) {
  constexpr double kStep = 1e-6;
  double squares = 0.0;
  for (const Observation& observation : data.observations) {
    const Shot& shot = data.shots[observation.shot];
    const Eigen::VectorXd& q = data.configurations[shot.configuration].q;
    const Vector3<double> here = ExactPoint(truth, data, observation);
    for (int j = 0; j < q.size(); ++j) {
      const Eigen::VectorXd moved = q + kStep * Eigen::VectorXd::Unit(q.size(), j);
      squares += (ExactPoint(truth, moved, observation.marker, shot.station) - here).squaredNorm() / (kStep * kStep);
    }
  }
  return per_axis / std::sqrt(squares / (3.0 * static_cast<double>(data.observations.size())));
}

// Joints deviate once per (configuration, visit).
inline void MeasureRepeated(const Kr270Truth& truth, const RepeatDesign& design, std::uint64_t seed,
                            Measurements* data) {
  NormalNumbers normal(seed);
  Eigen::VectorXd deviation = Eigen::VectorXd::Zero(6);
  int configuration = -1;
  std::string visit;
  for (const Shot& shot : data->shots) {
    if (shot.configuration != configuration || shot.visit != visit) {
      for (int j = 0; j < 6; ++j) deviation[j] = design.joint * normal();
      configuration = shot.configuration;
      visit = shot.visit;
    }
    const Eigen::VectorXd q = data->configurations[shot.configuration].q + deviation;
    for (const int i : shot.observations) {
      const Vector3<double> noise = test::RandomVector(normal);
      data->observations[i].point_in_station =
          ExactPoint(truth, q, data->observations[i].marker, shot.station) + design.tracker * noise;
    }
  }
}

// A tracker at `instrument` reads range, azimuth and elevation, each with its noise.
struct TrackerTruth {
  double range = 10e-6, range_per_m = 0.5e-6, angle = 15e-6, angle_per_m = 6e-6;  // m, m/m

  Vector3<double> Read(const Vector3<double>& point, const Vector3<double>& instrument, NormalNumbers* normal) const {
    const Vector3<double> d = point - instrument;
    const double flat = std::hypot(d.x(), d.y()), r = std::hypot(flat, d.z());
    const double across = angle + angle_per_m * r;
    const double far = r + (range + range_per_m * r) * (*normal)();
    const double azimuth = std::atan2(d.y(), d.x()) + across / flat * (*normal)();
    const double elevation = std::atan2(d.z(), flat) + across / r * (*normal)();
    return instrument + far * Vector3<double>(std::cos(elevation) * std::cos(azimuth),
                                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  }
};

// Where the trackers of two stations stand: ranges to the markers from about 2 to 8 m.
inline std::vector<Vector3<double>> TrackerPlaces() { return {{3.2, 0.3, 0.4}, {-1.0, -5.6, 1.8}}; }

inline Experiment TrackerExperiment(const TrackerTruth& tracker) {
  Experiment experiment;
  experiment.noise.from = NoiseSpec::From::kInstrument;
  experiment.noise.range = tracker.range;
  experiment.noise.range_per_m = tracker.range_per_m;
  experiment.noise.angle = tracker.angle;
  experiment.noise.angle_per_m = tracker.angle_per_m;
  for (int s = 0; s < 2; ++s) experiment.stations["S" + std::to_string(s + 1)].instrument_xyz = TrackerPlaces()[s];
  return experiment;
}

inline void MeasureByTracker(const Kr270Truth& truth, const TrackerTruth& tracker, std::uint64_t seed,
                             Measurements* data) {
  NormalNumbers normal(seed);
  for (Observation& observation : data->observations) {
    const Vector3<double> place = TrackerPlaces()[data->shots[observation.shot].station];
    observation.point_in_station = tracker.Read(ExactPoint(truth, *data, observation), place, &normal);
  }
}

// Appends the true errors of all rows, whitened by the problem's noise.
inline void AppendWhitenedErrors(const Kr270Truth& truth, const CalibrationProblem& problem,
                                 std::vector<double>* whitened) {
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    const Observation& row = problem.data().observations[i];
    const Vector3<double> error = row.point_in_station - ExactPoint(truth, problem.data(), row);
    const Vector3<double> u = problem.SqrtCovariance(static_cast<int>(i)).inverse() * error;
    whitened->insert(whitened->end(), u.data(), u.data() + 3);
  }
}

// Largest distance between the empirical distribution and the standard normal one.
inline double KolmogorovDistance(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  double distance = 0.0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    const double p = 0.5 * std::erfc(-numbers[i] / std::sqrt(2.0)), n = static_cast<double>(numbers.size());
    distance = std::max({distance, p - i / n, (i + 1) / n - p});
  }
  return distance;
}

// Spoils a share of the readings: exchanged markers of one shot, and shifts of 0.5 to 50 mm (even in the logarithm) in
// any direction. Returns the spoilt rows.
inline std::set<int> Spoil(double share, std::uint64_t seed, Measurements* data) {
  RandomNumbers random(seed);
  const auto pick = [&](size_t n) { return std::min(n - 1, static_cast<size_t>(random.Uniform(0.0, 1.0) * n)); };
  const int count = static_cast<int>(std::lround(share * data->observations.size()));
  std::set<int> spoilt;
  while (static_cast<int>(spoilt.size()) < count / 4) {
    const Shot& shot = data->shots[pick(data->shots.size())];
    const int a = shot.observations[0], b = shot.observations[1 + pick(2)];
    if (spoilt.count(a) + spoilt.count(b) > 0) continue;
    std::swap(data->observations[a].point_in_station, data->observations[b].point_in_station);
    spoilt.insert({a, b});
  }
  while (static_cast<int>(spoilt.size()) < count) {
    const int i = static_cast<int>(pick(data->observations.size()));
    if (!spoilt.insert(i).second) continue;
    const double size = 0.5e-3 * std::exp(random.Uniform(0.0, std::log(100.0)));
    const double z = random.Uniform(-1.0, 1.0), angle = random.Uniform(0.0, 6.283185307179586);
    const double flat = std::sqrt(1.0 - z * z);
    data->observations[i].point_in_station += size * Vector3<double>(flat * std::cos(angle), flat * std::sin(angle), z);
  }
  return spoilt;
}

// Estimate minus truth, a rotation as left perturbation.
inline double NoiseErrorOf(const Estimate& estimate, const Kr270Truth& truth, int coordinate) {
  const Coordinate& c = estimate.parameters.coordinates()[coordinate];
  if (c.quantity != Quantity::kRotationVector) return estimate.parameters.Value(coordinate) - TrueValue(truth, c.name);
  const int station = estimate.parameters.blocks()[c.block].owner;
  const Eigen::AngleAxisd off(estimate.parameters.BaseInStation(station).rotation *
                              BaseRotation(truth, station).transpose());
  return off.angle() * off.axis()[c.index_in_block];
}

// How often intervals hold the truth, and how large errors are, over trials.
struct IntervalTally {
  int trials = 0, failed = 0;
  Eigen::VectorXd covered, squares, variances;  // per coordinate

  void Add(const Estimate& estimate, const Kr270Truth& truth) {
    const int n = estimate.parameters.num_coordinates();
    if (covered.size() == 0) covered = squares = variances = Eigen::VectorXd::Zero(n);
    if (estimate.status != Status::kConverged) {
      ++failed;
      return;
    }
    ++trials;
    for (int i = 0; i < n; ++i) {
      const ParameterEstimate& row = estimate.table[i];
      const double error = NoiseErrorOf(estimate, truth, i);
      covered[i] += std::abs(error) <= 0.5 * (row.ci95.high - row.ci95.low);
      squares[i] += error * error;
      variances[i] += row.sigma * row.sigma;
    }
  }
  double Coverage() const { return covered.sum() / (static_cast<double>(trials) * covered.size()); }
  double LeastCoverage() const { return covered.minCoeff() / trials; }
  double MostCoverage() const { return covered.maxCoeff() / trials; }
};

// Flagged rows against spoilt ones.
struct FlagTally {
  int flagged = 0, spoilt = 0, both = 0, systematic = 0, exchanged = 0;

  void Add(const Estimate& estimate, const std::set<int>& rows) {
    spoilt += static_cast<int>(rows.size());
    systematic += estimate.noise_report.systematic;
    for (const Outlier& outlier : estimate.noise_report.outliers) {
      ++flagged;
      both += static_cast<int>(rows.count(outlier.observation));
      exchanged += outlier.swapped_with >= 0;
    }
  }
  double Precision() const { return both / static_cast<double>(flagged); }
  double Recall() const { return both / static_cast<double>(spoilt); }
};

// Median over the parameters of rmse(a) / rmse(b).
inline double MedianRatio(const IntervalTally& a, const IntervalTally& b) {
  std::vector<double> ratios;
  for (int i = 0; i < a.squares.size(); ++i) {
    ratios.push_back(std::sqrt((a.squares[i] / a.trials) / (b.squares[i] / b.trials)));
  }
  return Median(std::move(ratios));
}

}  // namespace sagitta::test
