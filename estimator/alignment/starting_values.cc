#include "estimator/alignment/starting_values.h"

#include <algorithm>
#include <map>
#include <random>
#include <tuple>

#include "estimator/least_squares/condensed_cost.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/normal_equations.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

constexpr double kEqual = 1e-6;  // relative difference of RMS below which starts count as equal
// A choice: where a start leads shows long before an alternation is at its end (the best ones are polished).
constexpr int kStartAlternations = 25;
constexpr double kMarkerSpread = 0.3;  // m, of the random marker starts: about as far as tools hold them
constexpr unsigned long long kSeedOfStarts = 1;

bool AllFree(const ParameterSet& parameters, const ParameterBlock& block) {
  for (int i = 0; i < block.tangent_size; ++i) {
    if (!parameters.coordinates()[block.first_coordinate + i].estimated()) return false;
  }
  return true;
}

// One observation with its marker frame already evaluated.
struct FramedObservation {
  int station;
  int marker;
  Pose<double> base_from_frame;
  TargetReading reading;
};

std::vector<FramedObservation> EvaluateFrames(const CalibrationProblem& problem, const std::vector<int>& observations,
                                              const ParameterSet& parameters) {
  const std::vector<double> theta = parameters.ModelValues();
  std::vector<FramedObservation> framed;
  framed.reserve(observations.size());
  ChainState<double> state;
  int evaluated_shot = -1;
  for (const int i : observations) {
    const Observation& observation = problem.data().observations[i];
    const Shot& shot = problem.data().shots[observation.shot];
    if (observation.shot != evaluated_shot) {
      const ShotInput& input = problem.shot_inputs()[observation.shot];
      EvaluateChain(problem.model().chain(), problem.model().TransformValues(input, theta.data()).data(), &state);
      evaluated_shot = observation.shot;
    }
    framed.push_back({shot.station, observation.marker, state.frames[problem.marker_frames()[observation.marker]],
                      observation.reading()});
  }
  return framed;
}

std::vector<Vector3<double>> MarkersOf(const ParameterSet& parameters) {
  std::vector<Vector3<double>> markers;
  for (int m = 0; m < parameters.num_markers(); ++m) markers.push_back(parameters.MarkerPoint(m));
  return markers;
}

std::vector<Pose<double>> BasesOf(const ParameterSet& parameters) {
  std::vector<Pose<double>> bases;
  for (int s = 0; s < parameters.num_stations(); ++s) bases.push_back(parameters.BaseInStation(s));
  return bases;
}

void RegisterStations(const std::vector<FramedObservation>& framed, ParameterSet* parameters) {
  const std::vector<Vector3<double>> markers = MarkersOf(*parameters);
  Eigen::Matrix3Xd points(3, framed.size()), targets(3, framed.size());
  for (int s = 0; s < parameters->num_stations(); ++s) {
    if (!AllFree(*parameters, parameters->station_translation(s)) ||
        !AllFree(*parameters, parameters->station_rotation(s))) {
      continue;
    }
    Eigen::Index seen = 0;
    for (const FramedObservation& f : framed) {
      if (f.station != s || f.reading.kind != ReadingKind::kPoint) continue;
      points.col(seen) = f.base_from_frame * markers[f.marker];
      targets.col(seen++) = f.reading.point;
    }
    if (seen == 0) continue;  // a station that is held out stays where it is
    parameters->SetBaseInStation(s, RegisterRigid(points.leftCols(seen), targets.leftCols(seen)));
  }
}

void AverageMarkers(const std::vector<FramedObservation>& framed, ParameterSet* parameters) {
  std::vector<Vector3<double>> sum(parameters->num_markers(), Vector3<double>::Zero());
  std::vector<int> count(parameters->num_markers(), 0);
  const std::vector<Pose<double>> bases = BasesOf(*parameters);
  for (const FramedObservation& f : framed) {
    if (f.reading.kind != ReadingKind::kPoint) continue;
    const Pose<double>& base_in_station = bases[f.station];
    const Vector3<double> in_base =
        base_in_station.rotation.transpose() * (f.reading.point - base_in_station.translation);
    // m = R_frame' (R_base' (p - t_base) - t_frame), averaged over the readings: least squares for equal noise.
    sum[f.marker] += f.base_from_frame.rotation.transpose() * (in_base - f.base_from_frame.translation);
    ++count[f.marker];
  }
  for (int m = 0; m < parameters->num_markers(); ++m) {
    if (count[m] > 0 && AllFree(*parameters, parameters->marker(m))) {
      parameters->SetMarkerPoint(m, sum[m] / count[m]);
    }
  }
}

// The mean rotation of each target in the frame it rides on: the rotation next to the sum of the single ones.
void AverageRotations(const std::vector<FramedObservation>& framed, ParameterSet* parameters) {
  std::vector<Matrix3<double>> sum(parameters->num_markers(), Matrix3<double>::Zero());
  for (const FramedObservation& f : framed) {
    if (f.reading.kind != ReadingKind::kRotation) continue;
    const Matrix3<double> station_from_frame =
        parameters->BaseInStation(f.station).rotation * f.base_from_frame.rotation;
    sum[f.marker] += station_from_frame.transpose() * f.reading.rotation;
  }
  for (int m = 0; m < parameters->num_markers(); ++m) {
    const bool is_read = parameters->is_oriented(m) && !sum[m].isZero(0.0);
    if (!is_read || !AllFree(*parameters, parameters->marker_rotation(m))) continue;
    parameters->SetMarkerRotation(m, NearestRotation(sum[m]));
  }
}

double DistanceRms(const std::vector<FramedObservation>& framed, const ParameterSet& parameters) {
  double sum = 0.0;
  int count = 0;
  const std::vector<Pose<double>> bases = BasesOf(parameters);
  const std::vector<Vector3<double>> markers = MarkersOf(parameters);
  for (const FramedObservation& f : framed) {
    if (f.reading.kind != ReadingKind::kPoint) continue;
    const Vector3<double> predicted = bases[f.station] * (f.base_from_frame * markers[f.marker]);
    sum += (predicted - f.reading.point).squaredNorm();
    ++count;
  }
  return std::sqrt(sum / count);
}

// Rows by which the starts are distinguished: as many of each marker at each station, spread over the data. Six
// unknowns per station and three per marker are known from far fewer to better than the polish needs.
constexpr size_t kRowsOfStarts = 1500;

std::vector<int> RowsOfStarts(const CalibrationProblem& problem, const std::vector<int>& observations) {
  const size_t stride = (observations.size() + kRowsOfStarts - 1) / kRowsOfStarts;
  std::map<std::tuple<int, int, ReadingKind>, size_t> seen;
  std::vector<int> rows;
  for (const int i : observations) {
    const Observation& observation = problem.data().observations[i];
    const int station = problem.data().shots[observation.shot].station;
    if (seen[{station, observation.marker, observation.kind}]++ % stride == 0) rows.push_back(i);
  }
  return rows;
}

struct StartCandidate {
  double rms;
  ParameterSet parameters;
};

// Base and markers only; the model's parameters keep their values.
void HoldModel(ParameterSet* parameters) {
  for (int i = 0; i < parameters->num_coordinates(); ++i) {
    Coordinate& coordinate = parameters->coordinate(i);
    const BlockKind kind = parameters->blocks()[coordinate.block].kind;
    if (kind == BlockKind::kModelParameter) coordinate.free = false;
  }
}

// Base poses and markers by Levenberg-Marquardt on rows.
void PolishStart(const NormalEquations& equations, const std::vector<FramedObservation>& framed,
                 StartCandidate* candidate) {
  ParameterSet polished = candidate->parameters;
  HoldModel(&polished);
  MinimizeOptions minimize;
  minimize.cautious = true;
  MinimizeSums(equations, minimize, &polished);
  const double rms = DistanceRms(framed, polished);
  if (!(rms <= candidate->rms * 1.5)) return;  // weighted and unweighted optimum differ a little
  for (int s = 0; s < polished.num_stations(); ++s)
    candidate->parameters.SetBaseInStation(s, polished.BaseInStation(s));
  for (int m = 0; m < polished.num_markers(); ++m) {
    candidate->parameters.SetMarkerPoint(m, polished.MarkerPoint(m));
    candidate->parameters.SetMarkerRotation(m, polished.MarkerRotation(m));
  }
  candidate->rms = rms;
}

NormalEquations EquationsOf(const CalibrationProblem& problem, const std::vector<int>& observations) {
  return {problem, observations, FitRoots(problem, observations, kFallbackSigma), LatentTreatment::kIgnore, 1};
}

}  // namespace

Pose<double> RegisterRigid(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& targets) {
  const Vector3<double> point_mean = points.rowwise().mean();
  const Vector3<double> target_mean = targets.rowwise().mean();
  // min sum |R p + t - q|^2: R next to sum (q - q_mean)(p - p_mean)', t = q_mean - R p_mean.
  const Matrix3<double> correlation = (targets.colwise() - target_mean) * (points.colwise() - point_mean).transpose();
  Pose<double> pose;
  pose.rotation = NearestRotation(correlation);
  pose.translation = target_mean - pose.rotation * point_mean;
  return pose;
}

namespace {

// The best start by a sample of the rows.
struct Start {
  std::vector<FramedObservation> framed;  // the sample
  StartCandidate best;
};

Start StartOfSample(const CalibrationProblem& problem, const std::vector<int>& observations, StartsTried tried,
                    const ParameterSet& given) {
  const int random_starts = tried == StartsTried::kFew ? 1 : 6, polished = tried == StartsTried::kFew ? 1 : 2;
  const std::vector<int> looked_at = RowsOfStarts(problem, observations);
  std::vector<FramedObservation> framed = EvaluateFrames(problem, looked_at, given);
  std::mt19937_64 random(kSeedOfStarts);
  std::normal_distribution<double> normal(0.0, kMarkerSpread);
  std::vector<StartCandidate> candidates;
  for (int start = 0; start <= random_starts; ++start) {
    ParameterSet trial = given;
    for (int m = 0; start > 0 && m < trial.num_markers(); ++m) {
      // One draw after the other: the order of arguments is the compiler's.
      const double z = normal(random), y = normal(random), x = normal(random);
      const Vector3<double> guess(x, y, z);
      if (AllFree(trial, trial.marker(m))) trial.SetMarkerPoint(m, guess);
    }
    for (int i = 0; i < kStartAlternations; ++i) {
      RegisterStations(framed, &trial);
      AverageMarkers(framed, &trial);
    }
    AverageRotations(framed, &trial);
    candidates.push_back({DistanceRms(framed, trial), std::move(trial)});
  }
  // Where the data do not determine the markers, all starts fit alike: then the one
  // without random markers counts.
  candidates[0].rms *= 1.0 - kEqual;
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.rms < b.rms; });
  candidates.resize(std::min<size_t>(candidates.size(), polished));
  const NormalEquations equations = EquationsOf(problem, looked_at);
  for (StartCandidate& candidate : candidates) PolishStart(equations, framed, &candidate);
  StartCandidate* best = &candidates[0];
  for (StartCandidate& candidate : candidates) {
    if (candidate.rms < best->rms * (1.0 - kEqual)) best = &candidate;
  }
  return {std::move(framed), std::move(*best)};
}

}  // namespace

double FindStartingValues(const CalibrationProblem& problem, const std::vector<int>& observations,
                          ParameterSet* parameters, StartsTried tried) {
  Start start = StartOfSample(problem, observations, tried, *parameters);
  const bool are_all = start.framed.size() == observations.size();
  if (!are_all) PolishStart(EquationsOf(problem, observations), start.framed, &start.best);
  *parameters = start.best.parameters;
  if (are_all) return start.best.rms;
  return DistanceRms(EvaluateFrames(problem, observations, *parameters), *parameters);
}

void FindStartingValues(const CalibrationProblem& problem, const NormalEquations& equations, ParameterSet* parameters) {
  const std::vector<int>& observations = equations.batches().observations();
  Start start = StartOfSample(problem, observations, StartsTried::kSeveral, *parameters);
  if (start.framed.size() < observations.size()) PolishStart(equations, start.framed, &start.best);
  *parameters = start.best.parameters;
}

}  // namespace sagitta
