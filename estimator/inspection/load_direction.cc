#include "estimator/inspection/load_direction.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/alignment/starting_values.h"
#include "estimator/least_squares/sample.h"
#include "models/constants.h"
#include "models/kinematics.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr double kAlongGravity = 0.9998;   // cosine: 1 deg, as forces are written
constexpr size_t kFewestLoaded = 6;        // each determines about as many numbers as there are joints
constexpr double kTilted = 3.0 * kDegree;  // a level that is not looked at is better, and moments change by 5 %
constexpr double kExplained = 0.25;        // of the squares that the stated direction leaves: half of the RMS
constexpr double kSameDirection = 1e-5;    // rad, of a step
constexpr int kSweeps = 200, kDirectionAlternations = 200;  // guards: kSameDirection ends them
constexpr double kLookedAt = 2e4;     // numbers: thousands of rows show a direction as well as all
constexpr int kDirectionsTried = 60;  // over the sphere: 25 deg apart

// Sums over the deflections: all that a direction's misfit needs.
struct DeflectionSums {
  std::vector<Matrix3<double>> gram;   // sum B_j' B_l, row by row
  std::vector<Vector3<double>> along;  // sum B_j' u
  double squares = 0.0;                // u'u
  int coordinates = 0;
  std::map<int, int> configurations;
  Vector3<double> stated = Vector3<double>::Zero();
  int joints = 0;
  bool in_columns = false;
};

// A column of u per newton along each axis and unit of compliance, by joint.
std::vector<Matrix3<double>> MotionsPerForce(const Chain& chain, const ChainState<double>& state,
                                             const Vector3<double>& marker, const Vector3<double>& load) {
  std::vector<Matrix3<double>> motions;
  for (int j = 0; j < chain.num_joints(); ++j) {
    const int e = chain.JointTransform(j);
    const Vector3<double>& z = state.axis[e];
    const bool turns = chain.joints[j].type == JointType::kRevolute;
    const Vector3<double> moved = turns ? Vector3<double>(z.cross(marker - state.origin[e])) : z;
    const Vector3<double> pulled = turns ? Vector3<double>(z.cross(load - state.origin[e])) : z;
    motions.push_back(moved * pulled.transpose());
  }
  return motions;
}

class LoadedStation {
 public:
  LoadedStation(const CalibrationProblem& problem, const ParameterSet& aligned, int station)
      : problem_(problem), parameters_(aligned), base_(aligned.BaseInStation(station)), theta_(aligned.ModelValues()) {
    const Measurements& data = problem.data();
    using Key = std::tuple<int, std::string, int>;  // configuration, visit, marker
    std::map<Key, Vector3<double>> unloaded;
    const auto key = [&](const Observation& row) {
      const Shot& shot = data.shots[row.shot];
      return Key{shot.configuration, shot.visit, row.marker};
    };
    const auto is_here = [&](const Observation& row) {
      return data.shots[row.shot].station == station && row.is_point();
    };
    const std::vector<int> sample = SampleConfigurations(data, problem.CalibrationObservations(), 1, kLookedAt);
    for (const int i : sample) {
      const Observation& row = data.observations[i];
      if (is_here(row) && !IsLoaded(data.shots[row.shot])) unloaded.try_emplace(key(row), row.point_in_station);
    }
    for (const int i : sample) {
      const Observation& row = data.observations[i];
      if (!is_here(row) || !IsLoaded(data.shots[row.shot])) continue;
      const auto rest = unloaded.find(key(row));
      if (rest != unloaded.end()) Add(row, row.point_in_station - rest->second);
    }
  }

  const DeflectionSums& sums() const { return sums_; }

 private:
  void Add(const Observation& row, const Vector3<double>& moved_in_station) {
    const ShotInput& input = problem_.shot_inputs()[row.shot];
    if (input.conditions.load_wrenches.empty()) return;
    const AppliedWrench& wrench = input.conditions.load_wrenches.front();
    const Matrix3<double> base_from_station = base_.rotation.transpose();
    const auto in_base = [&](const Vector3<double>& v, WrenchFrame frame) {
      return frame == WrenchFrame::kBase ? v : Vector3<double>(base_from_station * v);
    };
    const Vector3<double> gravity = in_base(input.conditions.gravity, input.conditions.gravity_frame).normalized();
    if (wrench.expressed_in == WrenchFrame::kFlange || wrench.moment.norm() > 0.0) return;
    const Vector3<double> force = in_base(wrench.force, wrench.expressed_in);
    const double weight = force.dot(gravity);
    if (!(std::abs(weight) > kAlongGravity * force.norm())) return;
    const Chain& chain = problem_.model().chain();
    EvaluateChain(chain, problem_.model().TransformValues(input, theta_.data()).data(), &state_);
    const Vector3<double> marker =
        state_.frames[problem_.marker_frames()[row.marker]] * parameters_.MarkerPoint(row.marker);
    const Vector3<double> load = state_.frames[wrench.frame] * wrench.point;
    const Vector3<double> moved = base_from_station * moved_in_station;
    const std::vector<Matrix3<double>> motions = MotionsPerForce(chain, state_, marker, load);
    const size_t n = motions.size();
    sums_.joints = static_cast<int>(n);
    sums_.gram.resize(n * n, Matrix3<double>::Zero());
    sums_.along.resize(n, Vector3<double>::Zero());
    for (size_t j = 0; j < n; ++j) {
      for (size_t l = 0; l < n; ++l) sums_.gram[j * n + l] += weight * weight * motions[j].transpose() * motions[l];
      sums_.along[j] += weight * motions[j].transpose() * moved;
    }
    sums_.squares += moved.squaredNorm();
    sums_.coordinates += 3;
    ++sums_.configurations[problem_.data().shots[row.shot].configuration];
    sums_.stated = gravity;
    sums_.in_columns |= !problem_.data().shots[row.shot].wrench.IsZero();
  }

  const CalibrationProblem& problem_;
  const ParameterSet& parameters_;
  const Pose<double> base_;
  const std::vector<double> theta_;
  ChainState<double> state_;
  DeflectionSums sums_;
};

// min |u - sum_j k_j B_j d|^2 over k >= 0, one k at a time in turn.
double MisfitAlong(const DeflectionSums& sums, const Vector3<double>& direction, Eigen::VectorXd* k) {
  const int n = sums.joints;
  Eigen::MatrixXd gram(n, n);
  Eigen::VectorXd along(n);
  for (int j = 0; j < n; ++j) {
    for (int l = 0; l < n; ++l) gram(j, l) = direction.dot(sums.gram[j * n + l] * direction);
    along[j] = direction.dot(sums.along[j]);
  }
  k->setZero(n);
  const double least = 1e-12 * std::max(gram.diagonal().maxCoeff(), 1e-300);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int j = 0; j < n; ++j) {
      if (gram(j, j) > least) (*k)[j] = std::max(0.0, (*k)[j] + (along[j] - gram.row(j).dot(*k)) / gram(j, j));
    }
  }
  return sums.squares - 2.0 * k->dot(along) + k->dot(gram * *k);
}

// The direction that fits best with these k.
Vector3<double> DirectionOf(const DeflectionSums& sums, const Eigen::VectorXd& k) {
  const int n = sums.joints;
  Matrix3<double> normal = Matrix3<double>::Zero();
  Vector3<double> along = Vector3<double>::Zero();
  for (int j = 0; j < n; ++j) {
    for (int l = 0; l < n; ++l) normal += k[j] * k[l] * sums.gram[j * n + l];
    along += k[j] * sums.along[j];
  }
  normal.diagonal().array() += 1e-12 * normal.trace();
  return Eigen::LDLT<Matrix3<double>>(normal).solve(along).normalized();
}

// Evenly over the sphere: on a spiral of equal areas.
Vector3<double> OnSphere(int index) {
  const double z = 1.0 - (2.0 * index + 1.0) / kDirectionsTried, turn = index * kPi * (3.0 - std::sqrt(5.0));
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

double BestDirection(const DeflectionSums& sums, Vector3<double>* best) {
  Eigen::VectorXd k;
  *best = sums.stated;
  double least = MisfitAlong(sums, *best, &k);
  for (int i = 0; i < kDirectionsTried; ++i) {
    Eigen::VectorXd own;
    const double misfit = MisfitAlong(sums, OnSphere(i), &own);
    if (misfit < least) least = misfit, *best = OnSphere(i), k = own;
  }
  for (int i = 0; i < kDirectionAlternations && k.maxCoeff() > 0.0; ++i) {
    const Vector3<double> next = DirectionOf(sums, k);
    if (!next.allFinite()) break;
    const double step = (next - *best).norm();
    *best = next;
    least = MisfitAlong(sums, *best, &k);
    if (step < kSameDirection) break;
  }
  return least;
}

}  // namespace

std::optional<LoadDirection> FindLoadDirection(const CalibrationProblem& problem) {
  const bool any = std::any_of(problem.data().shots.begin(), problem.data().shots.end(), IsLoaded);
  if (!any) return std::nullopt;
  ParameterSet aligned = problem.parameters;
  FindStartingValues(problem, SampleOfRows(problem), &aligned);
  for (int s = 0; s < static_cast<int>(problem.data().stations.size()); ++s) {
    const DeflectionSums sums = LoadedStation(problem, aligned, s).sums();
    if (sums.configurations.size() < kFewestLoaded) continue;
    LoadDirection found;
    Eigen::VectorXd k;
    const double as_stated = MisfitAlong(sums, sums.stated, &k);
    const double left = BestDirection(sums, &found.fitted);
    found.station = s, found.stated = sums.stated;
    found.angle = std::acos(std::clamp(found.fitted.dot(sums.stated), -1.0, 1.0));
    if (found.angle < kTilted || !(left < kExplained * as_stated)) continue;
    found.left_stated = std::sqrt(as_stated / sums.coordinates);
    found.left = std::sqrt(std::max(0.0, left) / sums.coordinates);
    found.in_columns = sums.in_columns;
    found.stated_in_base = problem.experiment().gravity_in_base;
    found.fitted_in_frame =
        found.stated_in_base ? found.fitted : Vector3<double>(aligned.BaseInStation(s).rotation * found.fitted);
    return found;
  }
  return std::nullopt;
}

Finding LoadDirectionInWords(const LoadDirection& found) {
  return Found(Severity::kSerious, "load_direction",
               LoadsPullAcross(found.angle, found.fitted, found.stated, found.fitted_in_frame, found.stated_in_base,
                               found.in_columns, found.left_stated, found.left));
}

std::optional<Finding> LintLoadDirection(const CalibrationProblem& problem) {
  const std::optional<LoadDirection> found = FindLoadDirection(problem);
  if (!found) return std::nullopt;
  return LoadDirectionInWords(*found);
}

}  // namespace sagitta
