#include "problems/excitation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "models/batch/batch_rows.h"
#include "models/excitation.h"

namespace sagitta {
namespace {

constexpr double kHoldMotion = 5e-3;          // m or rad, FORMATS section 4
constexpr double kClear = 0.1;                // of a motion: what a rotation of the base changes of it is less
constexpr double kRoundOffOfMotions = 1e-12;  // a sum of some hundred products of what moves the others

// Lengths of the spring move its ends: they are limited as lengths.
bool IsLimitedByMotion(const ModelParameter& parameter) {
  if (parameter.law == ParameterLaw::kCompensator) return parameter.quantity == Quantity::kSpringRate;
  return parameter.law != ParameterLaw::kGeometry;
}

// Shots of one structure at one station, eight at a time.
class ShotBatches {
 public:
  explicit ShotBatches(const CalibrationProblem& problem) : problem_(problem) {
    std::vector<std::int64_t> key;
    for (size_t s = 0; s < problem.data().shots.size(); ++s) {
      const Shot& shot = problem.data().shots[s];
      if (problem.data().configurations[shot.configuration].is_validation) continue;
      key.clear();
      if (!AppendStructure(problem.model(), problem.shot_inputs()[s], ReadingsOf(shot), &key)) {
        by_model_.push_back(static_cast<int>(s));
        continue;
      }
      key.push_back(shot.station);
      for (const int i : shot.observations) key.push_back(problem.data().observations[i].marker);
      groups_[key].push_back(static_cast<int>(s));
    }
  }

  // At each of the given values.
  std::vector<std::vector<double>> LargestMotions(const std::vector<ParameterSet>& at) const {
    std::vector<std::vector<double>> largest(at.size(), std::vector<double>(problem_.model().num_parameters(), 0.0));
    for (const auto& [key, shots] : groups_) Raise(shots, at, &largest);
    for (const int s : by_model_) {
      for (size_t i = 0; i < at.size(); ++i) RaiseByModel(s, at[i], &largest[i]);
    }
    for (std::vector<double>& motions : largest) {
      for (int i = 0; i < problem_.model().num_parameters() && !groups_.empty(); ++i) {
        if (problem_.model().parameters()[i].law == ParameterLaw::kGeometry) motions[i] = 1.0;
      }
    }
    return largest;
  }

 private:
  std::vector<BatchReading> ReadingsOf(const Shot& shot) const {
    std::vector<BatchReading> readings;
    for (const int i : shot.observations) {
      const int marker = problem_.data().observations[i].marker;
      readings.push_back({marker, problem_.marker_frames()[marker], Vector3<double>::Zero(), Matrix3<double>::Zero()});
    }
    return readings;
  }

  void Raise(const std::vector<int>& shots, const std::vector<ParameterSet>& at,
             std::vector<std::vector<double>>* largest) const {
    const Shot& first = problem_.data().shots[shots.front()];
    const ShotProgram program =
        MakeShotProgram(problem_.model(), problem_.shot_inputs()[shots.front()], ReadingsOf(first));
    std::vector<std::vector<double>> theta;
    std::vector<BatchPoint> points;
    for (const ParameterSet& parameters : at) theta.push_back(parameters.ModelValues());
    for (size_t i = 0; i < at.size(); ++i) {
      std::vector<Vector3<double>> markers;
      for (const int k : first.observations)
        markers.push_back(at[i].MarkerPoint(problem_.data().observations[k].marker));
      points.emplace_back(program, theta[i].data(), at[i].BaseInStation(first.station), std::move(markers));
    }
    BatchScratch numbers, scratch;
    double* const data = numbers.Reserve(static_cast<std::size_t>(program.num_data) * kBatchLanes);
    for (size_t next = 0; next < shots.size(); next += kBatchLanes) {
      const auto shot_of = [&](int lane) { return shots[std::min(next + lane, shots.size() - 1)]; };
      for (int lane = 0; lane < kBatchLanes; ++lane) {
        const int s = shot_of(lane);
        PackShot(problem_.model(), program, problem_.shot_inputs()[s], ReadingsOf(problem_.data().shots[s]), lane,
                 data);
      }
      for (size_t i = 0; i < at.size(); ++i) {
        const unsigned left = RaiseMotions(program, points[i], data, &scratch, (*largest)[i].data());
        for (int lane = 0; lane < kBatchLanes; ++lane) {
          if ((left >> lane & 1u) != 0) RaiseByModel(shot_of(lane), at[i], &(*largest)[i]);
        }
      }
    }
  }

  void RaiseByModel(int s, const ParameterSet& parameters, std::vector<double>* largest) const {
    const Shot& shot = problem_.data().shots[s];
    std::vector<MarkerInFrame> markers;
    for (const int i : shot.observations) {
      const int marker = problem_.data().observations[i].marker;
      markers.push_back({problem_.marker_frames()[marker], parameters.MarkerPoint(marker), marker});
    }
    const std::vector<double> motion =
        MotionPerUnit(problem_.model(), problem_.shot_inputs()[s], parameters.ModelValues().data(),
                      parameters.BaseInStation(shot.station), markers);
    for (size_t i = 0; i < largest->size(); ++i) (*largest)[i] = std::max((*largest)[i], motion[i]);
  }

  const CalibrationProblem& problem_;
  std::map<std::vector<std::int64_t>, std::vector<int>> groups_;
  std::vector<int> by_model_;
};

// A force along the axis of its own lever leaves round-off where the effect's other parameters leave a motion: 0. In SI
// units these move the arm alike to a few orders of magnitude (a link's mass, kg, and its first moments, kg m).
void DropRoundOff(const std::vector<ModelParameter>& parameters, std::vector<double>* motions) {
  std::map<int, double> most;  // by effect
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].law != ParameterLaw::kEffect) continue;
    double& largest = most[parameters[i].index];
    largest = std::max(largest, (*motions)[i]);
  }
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].law != ParameterLaw::kEffect) continue;
    if ((*motions)[i] < kRoundOffOfMotions * most[parameters[i].index]) (*motions)[i] = 0.0;
  }
}

// At these values and at two with the bases rotated.
std::vector<ParameterSet> WithTilted(const ParameterSet& parameters) {
  std::vector<ParameterSet> at = {parameters};
  for (int axis = 0; axis < 2; ++axis) {
    ParameterSet tilted = parameters;
    for (int s = 0; s < tilted.num_stations(); ++s) {
      Pose<double> pose = tilted.BaseInStation(s);
      const Vector3<double> turn = kHoldMotion * Vector3<double>::Unit(axis);
      pose.rotation = RotationFromVector(turn) * pose.rotation;
      tilted.SetBaseInStation(s, pose);
    }
    at.push_back(tilted);
  }
  return at;
}

// largest: as they are, and with the bases rotated. The latter change more than this share of the former.
bool IsFeigned(const std::vector<std::vector<double>>& largest, size_t i, double share) {
  const double motion = largest[0][i];
  return share * motion < std::max(std::abs(largest[1][i] - motion), std::abs(largest[2][i] - motion));
}

bool AreClear(const std::vector<ModelParameter>& parameters, const std::vector<std::vector<double>>& largest) {
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].law == ParameterLaw::kGeometry) continue;
    if (!(largest[0][i] > 0.0) || IsFeigned(largest, i, kClear)) return false;
  }
  return true;
}

std::vector<double> TrueMotions(const CalibrationProblem& problem, const ParameterSet& parameters,
                                const LargestMotionsAt& largest_at, const LargestMotionsAt& some_at) {
  std::vector<ParameterSet> at = WithTilted(parameters);
  const bool are_clear = some_at && AreClear(problem.model().parameters(), some_at(at));
  if (are_clear) at.resize(1, parameters);
  const std::vector<std::vector<double>> largest = largest_at(at);
  std::vector<double> motions = largest[0];
  for (size_t i = 0; i < motions.size() && !are_clear; ++i) {
    if (IsFeigned(largest, i, 1.0)) motions[i] = 0.0;
  }
  DropRoundOff(problem.model().parameters(), &motions);
  return motions;
}

LargestMotionsAt OfAllShots(const CalibrationProblem& problem) {
  return [&problem](const std::vector<ParameterSet>& at) { return ShotBatches(problem).LargestMotions(at); };
}

}  // namespace

std::vector<double> LargestTrueMotions(const CalibrationProblem& problem, const ParameterSet& parameters) {
  return TrueMotions(problem, parameters, OfAllShots(problem), nullptr);
}

void SetHoldLimits(const CalibrationProblem& problem, ParameterSet* parameters) {
  SetHoldLimits(problem, OfAllShots(problem), nullptr, parameters);
}

void SetHoldLimits(const CalibrationProblem& problem, const LargestMotionsAt& largest, const LargestMotionsAt& some,
                   ParameterSet* parameters) {
  const auto& model_parameters = problem.model().parameters();
  const bool any = std::any_of(model_parameters.begin(), model_parameters.end(), IsLimitedByMotion);
  if (!any) return;
  const std::vector<double> motions = TrueMotions(problem, *parameters, largest, some);
  for (size_t i = 0; i < motions.size(); ++i) {
    if (!IsLimitedByMotion(model_parameters[i])) continue;
    Coordinate& coordinate = parameters->coordinate(parameters->model_parameter(static_cast<int>(i)).first_coordinate);
    coordinate.hold_limit = motions[i] > 0.0 ? kHoldMotion / motions[i] : TraitsOf(coordinate.quantity).hold_limit;
  }
}

}  // namespace sagitta
